"""The kinds of robots, as ranges that one is drawn from."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Kind:
    """Ranges of one kind of robot: mass [kg], wheel radius, axle [m], full speed [m/s], caster's place over the
    axle's length, height of the mass over the floor [m], reach of its drives [m].
    """

    mass: tuple[float, float]
    radius: tuple[float, float]
    axle: tuple[float, float]
    speed: tuple[float, float]
    caster: str
    caster_x: float
    height: tuple[float, float]
    behind: tuple[float, float]
    reach: tuple[float, float]


KINDS = {
    "duck": Kind(
        (1.0, 1.2),
        (0.0318, 0.0318),
        (0.1, 0.1),
        (0.4, 0.6),
        "ball",
        -0.7,
        (0.03, 0.04),
        (0.008, 0.018),
        (0.7, 1.2),
    ),
    "puck": Kind(
        (0.8, 1.0),
        (0.018, 0.024),
        (0.08, 0.095),
        (0.3, 0.5),
        "skid",
        0.55,
        (0.02, 0.026),
        (0.005, 0.012),
        (0.6, 1.0),
    ),
    "burger": Kind(
        (0.9, 1.3),
        (0.033, 0.033),
        (0.15, 0.17),
        (0.22, 0.4),
        "ball",
        -0.5,
        (0.04, 0.06),
        (0.012, 0.025),
        (0.7, 1.2),
    ),
    "kobuki": Kind(
        (2.4, 4.5),
        (0.034, 0.036),
        (0.22, 0.24),
        (0.45, 0.7),
        "pair",
        -0.45,
        (0.04, 0.06),
        (0.012, 0.025),
        (0.9, 1.6),
    ),
    "pioneer": Kind(
        (9.0, 14.0),
        (0.09, 0.1),
        (0.32, 0.36),
        (0.5, 0.8),
        "swivel",
        -0.6,
        (0.09, 0.12),
        (0.018, 0.03),
        (1.1, 1.9),
    ),
    "cart": Kind(
        (16.0, 40.0),
        (0.08, 0.11),
        (0.4, 0.52),
        (0.6, 1.0),
        "swivel",
        -0.8,
        (0.1, 0.14),
        (0.02, 0.045),
        (1.4, 2.0),
    ),
    "carrier": Kind(
        (6.0, 15.0),
        (0.05, 0.065),
        (0.28, 0.36),
        (0.4, 0.7),
        "pair",
        -0.6,
        (0.06, 0.09),
        (0.015, 0.025),
        (1.0, 1.8),
    ),
}
