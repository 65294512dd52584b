"""An eccentric wheel lifts its part of the robot once a turn: the load slows it on the way up and drives it down."""

import numpy as np
import pytest
from diagnosis_robots import judged, speeds

from fsm_calib.world2d.parameters import parameter_table
from fsm_calib.world2d.slots import GRAVITY

GAIN, COMMAND, TAU, RADIUS = 0.6, 0.5, 0.1, 0.0318
SPEED = GAIN * COMMAND


def speeds_of(eccentricity, seconds=8.0, command=COMMAND, **changes):
    """Return times [s] and speeds [m/s] of a robot of gripping tyres whose two wheels rise together."""
    ecc = {
        "left": eccentricity,
        "right": eccentricity,
        "phase_left": 0.0,
        "lift": 1.0,
        "lobes": 1.0,
    } | changes
    named = {f"wheel_eccentricity__{name}": value for name, value in ecc.items()}
    base = {"gain_left": GAIN, "gain_right": GAIN, "tau_forward": TAU, "wheel_inertia": 0.0}
    grid = np.arange(0.0, seconds, 0.01)
    return grid, speeds([0.0], [command], grid, **base, **named)


@pytest.mark.parametrize("lobes", [1.0, 2.0])
def test_the_speed_swings_as_a_lag_answers_the_force_that_lifts(lobes):
    """v' = (T - v) / tau + g e n sin(w t), w = n v / R: to first order an amplitude of g e n tau / sqrt(1 + (w tau)^2).

    What the radius does by itself is added at most, whatever its phase.
    """
    e = 0.002
    grid, speed = speeds_of(e, lobes=lobes)
    late = speed[grid > 2.0]
    omega = lobes * SPEED / RADIUS
    lag = 1.0 / (1.0 + 1j * omega * TAU)
    _, plain = speeds_of(e, lobes=lobes, lift=0.0)
    of_the_radius = np.ptp(plain[grid > 2.0]) / 2.0
    force = abs(GRAVITY * e * lobes * TAU * lag)
    assert np.ptp(late) / 2.0 == pytest.approx(force, abs=of_the_radius + 0.05 * force)
    assert force > 3.0 * of_the_radius


def test_a_turn_takes_as_much_as_it_gives():
    grid, speed = speeds_of(0.004)
    late = speed[grid > 2.0]
    turns = int(len(late) * 0.01 * SPEED / (2.0 * np.pi * RADIUS))
    whole = round(turns * 2.0 * np.pi * RADIUS / SPEED / 0.01)
    assert np.mean(late[:whole]) == pytest.approx(SPEED, rel=0.01)


def test_a_wheel_that_is_told_to_rest_is_held():
    _, speed = speeds_of(0.05, command=0.0, phase_left=1.5, phase_right=1.5)
    assert np.abs(speed).max() == pytest.approx(0.0, abs=1e-9)


def test_a_wheel_that_lifts_is_named_with_its_eccentricity():
    decision = judged(
        ("wheel_eccentricity", "misplaced_marker", "rough_floor_patch", "motor_gain_curve"),
        wheel_eccentricity__left=0.012,
        wheel_eccentricity__phase_left=2.0,
        wheel_eccentricity__lift=1.0,
    )
    assert [belief.name for belief in decision.named] == ["wheel_eccentricity"]
    table, values = parameter_table(), decision.model.fit.values[0]
    assert values[table.place("wheel_eccentricity.lift")] == 1.0
    assert values[table.place("wheel_eccentricity.left")] == pytest.approx(0.012, rel=0.1)
