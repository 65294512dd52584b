"""A caster whose wheel rolls hard pulls along its fork: what that does, and that it is found by its sizes."""

import numpy as np
import pytest
from diagnosis_robots import decided, engine_of, fitted_number, recording, robot

from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.rollout import Drive, simulate

DRAG, ARM, TRAIL = 0.25, 0.075, 0.3  # N, m, over the arm
BUILT = {f"caster_drag__{n}": v for n, v in (("drag", DRAG), ("arm", ARM), ("trail", TRAIL), ("forked", 1.0))}
ALIKE = {"gain_left": 0.6, "gain_right": 0.6}


def yaw_rates(begin, then, times, **changes):
    """Return yaw rates [rad/s] at `times` [s] after commands `begin` of a second gave way to `then`."""
    drive = Drive(np.array([0.0, 1.0]), [begin[0], then[0]], [begin[1], then[1]])
    grid = np.arange(0.0, 3.0, 0.01)
    states = simulate(robot(**ALIKE, **changes), drive, grid, (0.0, 0.0, 0.0))
    return np.interp(1.0 + np.asarray(times), grid, states[:, 5])


def test_on_a_straight_it_brakes_as_a_drag_against_its_velocity_does():
    grid = np.arange(0.0, 3.0, 0.01)
    straight = Drive(np.array([0.0]), [0.5], [0.5])
    forked, point = (
        simulate(robot(**ALIKE, **built), straight, grid, (0.0, 0.0, 0.0))[-1, 0]
        for built in (BUILT, {**BUILT, "caster_drag__forked": 0.0})
    )
    assert forked == pytest.approx(point, rel=1e-6)


def test_driving_off_after_a_spin_it_brakes_the_turn_longer_than_one_that_drags_against_its_velocity():
    point = {**BUILT, "caster_drag__forked": 0.0}
    spin, straight, times = (-0.4, 0.4), (0.5, 0.5), np.arange(0.25, 0.4, 0.05)
    pulls = yaw_rates(spin, straight, times, **BUILT) - yaw_rates(spin, straight, times, **point)
    assert np.all(pulls < -0.02)


def test_a_trail_length_or_four_after_a_spin_it_follows():
    assert abs(yaw_rates((-0.4, 0.4), (0.5, 0.5), [1.5], **BUILT)[0]) < 1e-3


@pytest.mark.slow
def test_it_is_named_with_its_drag_arm_and_trail():
    drives = [recording(seed, 28.0, **BUILT) for seed in (0, 1)]
    decision = decided(drives, ("caster_drag", "tyre_scrub", "coulomb_friction", "motor_asymmetric_lag"))
    assert [b.name for b in decision.named] == ["caster_drag"]
    assert decision.model.effects[0].hypothesis.closure == "along its fork"
    found = [fitted_number(decision.model.fit, f"caster_drag.{n}") for n in ("drag", "arm", "trail")]
    assert found == pytest.approx([DRAG, ARM, TRAIL], rel=0.1)


def test_one_that_kicks_as_well_is_found_with_its_trail():
    built = {**BUILT, "caster_drag__drag": 0.15, "caster_drag__kick": 0.3}
    engine = engine_of(*(recording(seed, **built) for seed in (0, 1)))
    best = Bank.on(engine, fit_base(engine)).best_of(registry()["caster_drag"])
    assert best.hypothesis.closure == "swivelling wheel"
    found = [fitted_number(best.fit, f"caster_drag.{n}") for n in ("drag", "kick", "arm", "trail")]
    assert found == pytest.approx([0.15, 0.3, ARM, TRAIL], rel=0.15)
