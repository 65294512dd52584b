"""What the key says of a robot's hidden effect, in the words of the catalogue, beside what a verdict says of it.

The generator's laws (`physics.py`, `robots.py`) and the catalogue's (`fsm-calib effects`) were written apart. Where
both have the same number it is compared as it stands; where only a consequence is common, the consequence; where not
even that, nothing. The README beside this file lists which is which.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

DRIVE = 60.0
"""s, the length of a concealed drive: how long a motor has warmed at its end."""
EFFORT = 12.5
"""s of full command that a wheel has done by then: 9.6 to 14.5 on development drives."""
USUAL_EFFORT = 20.0
"""s, the catalogue's `effort` where a verdict does not state one: it was held."""
KICK = 0.25
"""s, how long a concealed push lasts."""
SPREADS_90 = 1.645
"""Standard deviations on each side that hold 90 % of a normal distribution."""

Key = Mapping[str, Any]
Numbers = Mapping[str, float]


@dataclass(frozen=True)
class Compared:
    """One number of one robot: true and found, the stated standard deviation (nan: none), units of the catalogue.

    kind : strength, place [m] or time [s]; size : what an error of a strength is a share of.
    """

    name: str
    kind: str
    true: float
    found: float
    sd: float
    size: float

    @property
    def share(self) -> float:
        """The error as a share of the true size."""
        return abs(self.found - self.true) / self.size

    @property
    def held(self) -> bool | None:
        """Whether the stated 90 % interval holds the truth; None without an interval."""
        return None if math.isnan(self.sd) else abs(self.found - self.true) <= SPREADS_90 * self.sd


def _same(**fields: str) -> Callable[[Numbers], dict[str, float]]:
    """Return a translation that only changes names: parameter of the catalogue = field of the generator."""
    return lambda p: {name: p[field] for name, field in fields.items()}


def _nap(p: Numbers) -> dict[str, float]:
    """0.5 nap (1 + cos(direction of travel - nap_direction)) is |n| - n.d with n against nap_direction."""
    half = 0.5 * p["nap"]
    return {"x": -half * math.cos(p["nap_direction"]), "y": -half * math.sin(p["nap_direction"])}


def _warm(p: Numbers) -> dict[str, float]:
    return {f"change_{side}": p[f"warm_{side}"] for side in ("left", "right")}


STRENGTHS: dict[str, Callable[[Numbers], dict[str, float]]] = {
    "motor_deadband": _same(offset="deadband"),
    "command_saturation": _same(limit="saturation"),
    "motor_gain_curve": _same(curvature="curve"),
    "motor_reverse_asymmetry": _same(loss="reverse_left"),
    "motor_asymmetric_lag": lambda p: {"ratio": 1.0 / (1.0 - p["brake_fade"])},
    "coulomb_friction": _same(friction="coulomb_left"),
    "gear_backlash": _same(gap="play"),
    "battery_sag": _same(per_charge="sag_charge"),
    "motor_warmup": _warm,
    "motor_fault": _same(loss_left="fault_left", loss_right="fault_right"),
    "command_delay": _same(delay="delay"),
    "wheel_eccentricity": _same(left="ecc_left", right="ecc_right"),
    "caster_drag": _same(drag="caster_drag"),
    "tyre_scrub": _same(moment="scrub_dry"),
    "payload_offset": _same(x="com_x", y="com_y"),
    "floor_tilt": _same(slope_x="tilt_x", slope_y="tilt_y"),
    "carpet_nap": _nap,
    "rough_floor_patch": lambda p: {"drag": 0.5 * p["patch_drag"]},
    "low_friction_patch": lambda p: {"loss": 1.0 - p["patch_mu"]},
    "external_push": lambda p: {"impulse_turn": KICK * p["push_m"]},
    "observation_delay": _same(delay="delay"),
    "sensor_offset": _same(x="dx", y="dy"),
    "sensor_yaw": _same(yaw="yaw"),
    "clock_drift": lambda p: {"drift": 1.0 / (1.0 + p["drift"]) - 1.0},
    "misplaced_marker": _same(turn="mark"),
}
"""True strengths of each effect by the catalogue's names, from the generator's fields; `lateral_slip` has none."""

NULLS = {"motor_asymmetric_lag": 1.0}
"""Where nothing is not at zero: the ratio of two time constants."""
PLACES = {
    "rough_floor_patch": _same(x="patch_x", y="patch_y"),
    "low_friction_patch": _same(x="patch_x", y="patch_y"),
    "misplaced_marker": _same(x="mark_x", y="mark_y"),
}
TIMES = {"motor_fault": _same(start="fault_start"), "external_push": _same(start="push_time")}
SETS = {"command_delay": "observation_delay", "observation_delay": "command_delay"}
"""Names that count as one without encoders, and have the same numbers."""


def compared(line: Key, effect: Key) -> list[Compared]:
    """Return the numbers that a verdict's effect and a key line have in common; none where the laws differ."""
    label, fields = line["label"], {**line["physics"], **line["sensor"]}
    if effect["name"] not in (label, SETS.get(label)) or label not in STRENGTHS:
        return []
    stated = effect["parameters"]
    if label == "motor_warmup":
        fields, stated = _at_the_end(fields, stated)
    found: list[Compared] = []
    for kind, table in (("strength", STRENGTHS), ("place", PLACES), ("time", TIMES)):
        found += _pairs(kind, table.get(label, lambda p: {}), fields, stated, NULLS.get(label, 0.0))
    return found


def _pairs(
    kind: str, translate: Callable[[Numbers], dict[str, float]], fields: Numbers, stated: Key, null: float
) -> Iterator[Compared]:
    """Yield the numbers of one kind that key and verdict hold; another world's key may lack some."""
    try:
        true = translate(fields)
    except KeyError:
        return
    size = math.hypot(*(value - null for value in true.values()))
    for name, value in true.items():
        said = stated.get(name)
        if said is None and value != null and kind == "strength":
            said = {"value": null, "sd": None}  # the other wheel was blamed
        if said is not None and said["value"] is not None and size > 0.0:
            sd = math.nan if said["sd"] is None else said["sd"]
            yield Compared(name, kind, value, said["value"], sd, size)


def _at_the_end(fields: Key, stated: Key) -> tuple[dict[str, float], dict[str, Any]]:
    """Return both warm-ups at the end of a drive, without intervals: one law grows with time, the other with effort."""
    grown = 1.0 - math.exp(-DRIVE / fields["warm_time"]) if "warm_time" in fields else 1.0
    effort, by_time = ((stated.get(name) or {}).get("value") for name in ("effort", "idle"))
    done = 1.0 - math.exp(-(DRIVE if by_time else EFFORT) / (effort or USUAL_EFFORT))
    true = {**fields, **{f"warm_{s}": grown * fields.get(f"warm_{s}", 0.0) for s in ("left", "right")}}
    said = {
        name: {"value": done * number["value"], "sd": None}
        for name, number in stated.items()
        if name.startswith("change") and number["value"] is not None
    }
    return true, said


def strength_error(numbers: Iterable[Compared]) -> float | None:
    """Return the error of a robot's strengths as a share of their size; None where none can be compared."""
    shares = [number.share for number in numbers if number.kind == "strength"]
    return math.hypot(*shares) if shares else None


def distance(numbers: Iterable[Compared], kind: str) -> float | None:
    """Return how far a place [m] or a moment [s] was missed; None where there was none."""
    misses = [number.found - number.true for number in numbers if number.kind == kind]
    return math.hypot(*misses) if misses else None
