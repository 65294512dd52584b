"""A speed controller sees the wheels' speeds late, and set points act half as late: how such robots are built."""

from dataclasses import replace
from functools import partial

import diagnosis_robots
import numpy as np
import pytest
from diagnosis_robots import engine_of, fitted_number, recording

from fsm_calib.diagnosis.candidates.free_number import found_free
from fsm_calib.diagnosis.candidates.late_sight import LAG, with_late_sight
from fsm_calib.diagnosis.candidates.rivals import Rivals
from fsm_calib.diagnosis.candidates.speed_loop import with_speed_loop
from fsm_calib.diagnosis.candidates.supply_end import CEILING, with_supply_end
from fsm_calib.diagnosis.candidates.supply_end import LOOP as LOOP_GAIN
from fsm_calib.diagnosis.candidates.whole_base import fit_whole_base
from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.diagnosis.fitting.base import fit_base, settled
from fsm_calib.world2d.effects import registry

RIVALS = ("command_delay", "observation_delay", "motor_asymmetric_lag", "payload_offset")
GAIN, TAU, HOLD, LATE, LOOP = 0.6, 0.1, 5.0, 0.04, 3.0
HELD = {"speed_controller__hold": HOLD}
SEEING = {**HELD, "speed_controller__lag": LATE, "speed_controller__loop": LOOP}
speeds = partial(diagnosis_robots.speeds, gain_left=GAIN, gain_right=GAIN, tau_forward=TAU, slip_speed=1e-4)


def sampled(wanted, grid, step=1e-4):
    """Return speeds [m/s] towards a set point [m/s] under a loop that sees them late, in steps of 0.1 ms."""
    speed, seen, integral, expected = 0.0, 0.0, 0.0, [0.0]
    for k in range(round(grid[-1] / step)):
        told = wanted if k * step >= 0.5 * LATE else 0.0
        target = told + integral + LOOP / (1.0 + LOOP) * (speed - seen)
        seen += step * (speed - seen) / LATE
        integral += step * HOLD * (told - speed)
        speed += step * (target - speed) / TAU
        expected.append(speed)
    return np.array(expected)[np.rint(grid / step).astype(int)]


@pytest.mark.parametrize("command", [0.5, -0.3])
def test_a_step_overshoots_as_a_loop_that_sees_late(command):
    grid = np.arange(0.0, 2.0, 0.005)
    found = speeds([0.0], [command], grid, **SEEING)
    assert found == pytest.approx(sampled(GAIN * command, grid), abs=4e-3)
    assert np.abs(found).max() > 1.01 * np.abs(speeds([0.0], [command], grid, **HELD)).max()


def based(**changes):
    recordings = [recording(seed, **changes) for seed in (0, 1)]
    return fit_whole_base(engine_of(*recordings), [registry()[name] for name in RIVALS])


def test_a_robot_whose_controller_sees_late_is_given_its_lag():
    fit = based(**SEEING)
    assert fitted_number(fit, LAG) == pytest.approx(LATE, rel=0.15)


def test_a_controller_that_sees_at_once_has_none():
    assert not found_free(based(**HELD), LAG)


def test_a_supply_that_ends_behind_it_leaves_the_loop_one_gain():
    both = {**SEEING, "speed_controller__ceiling": 1.2}
    engine = engine_of(*(recording(seed, **both) for seed in (0, 1)))
    late = with_late_sight(engine, with_speed_loop(engine, fit_base(engine), Rivals([])), Rivals([]))
    assert found_free(late, LAG)
    fit = with_supply_end(engine, late, Rivals([]))
    assert found_free(fit, CEILING)
    assert len(found_free(fit, LOOP_GAIN)) == 1


def test_it_is_said_and_never_accused():
    others = set(registry()) - set(RIVALS)
    found = diagnose([recording(seed, **SEEING) for seed in (0, 1)], without=others)
    assert found.decision.outcome == "match"
    assert any("sees the wheels' speeds" in note for note in found.notes)


def test_a_fit_that_is_settled_keeps_that_commands_act_at_odd_moments():
    engine = engine_of(recording(0))
    fit = fit_whole_base(engine, [])
    odd = engine.fit(fit.values, fit.slots, replace(fit.noise, jitter=0.01))
    assert settled(engine, odd).noise.jitter > 0.0
