"""A controller that a heavy load hides: its integral ends, its supply ends, and no number of both shows alone."""

from functools import partial

import diagnosis_robots
import numpy as np
import pytest
from diagnosis_robots import engine_of, fitted_number, recording, selector_on

from fsm_calib.diagnosis.candidates.free_number import found_free
from fsm_calib.diagnosis.candidates.rivals import Rivals
from fsm_calib.diagnosis.candidates.speed_loop import HOLD
from fsm_calib.diagnosis.candidates.supply_end import CEILING, LOOP
from fsm_calib.diagnosis.candidates.usual_loop import MOST, integral_told, with_usual_loop
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.verdict.bared import ranked_if_bared

GAIN, LAG = 0.6, 0.1
CONTROLLER = {
    "speed_controller__hold": 3.0,
    "speed_controller__most": 0.1,
    "speed_controller__ceiling": 1.2,
    "speed_controller__loop": 1.5,
}
FRICTION = {"coulomb_friction__friction": 0.02}
speeds = partial(diagnosis_robots.speeds, gain_left=GAIN, gain_right=GAIN, tau_forward=LAG, slip_speed=1e-4)


def test_a_load_beyond_what_the_integral_gives_slows_the_wheels_by_the_rest():
    grid = np.arange(0.0, 8.0, 0.01)
    free_run, loaded = (speeds([0.0], [0.5], grid, **e)[-1] for e in ({}, FRICTION))
    most = 0.5 * (free_run - loaded) / GAIN
    bounded = {"speed_controller__hold": 4.0, "speed_controller__most": most}
    held = speeds([0.0], [0.5], grid, **bounded, **FRICTION)[-1]
    assert held == pytest.approx(loaded + most * GAIN, rel=2e-3)


def test_an_integral_that_is_never_so_large_is_as_one_without_bounds():
    grid = np.arange(0.0, 4.0, 0.01)
    hold = {"speed_controller__hold": 4.0}
    bounded = speeds([0.0, 2.0], [0.5, -0.3], grid, **hold, speed_controller__most=1.9)
    assert bounded == pytest.approx(speeds([0.0, 2.0], [0.5, -0.3], grid, **hold), abs=1e-12)


def ranked_on(robot, *names):
    """Return selector, bank and ranking of a robot among some effects, on the base as it is without a controller."""
    engine = engine_of(*(recording(seed, **robot) for seed in (0, 1)))
    selector = selector_on(fit_base(engine), engine, *names)
    return selector, *selector.first_ranked()


@pytest.mark.parametrize("moment", [0.1, 0.15])
def test_a_controller_whose_integral_ends_is_found_beside_scrubbing_tyres(moment):
    selector, _, ranking = ranked_on({**CONTROLLER, "tyre_scrub__moment": moment}, "tyre_scrub")
    fit = with_usual_loop(selector.engine, ranking[0].fit, Rivals([]))
    for name, true in ((HOLD, 3.0), (MOST, 0.1), ("tyre_scrub.moment", moment)):
        assert fitted_number(fit, name) == pytest.approx(true, rel=0.15)
    assert any("integral ends" in said for said in integral_told(fit))


@pytest.mark.parametrize(
    "hidden",
    [{"tyre_scrub__moment": 0.1}, FRICTION, {"motor_deadband__offset": 0.08}],
    ids=lambda e: next(iter(e)),
)
def test_beside_an_effect_a_robot_that_is_told_duties_is_given_none(hidden):
    selector, _, ranking = ranked_on(hidden, next(iter(hidden)).split("__")[0])
    leader = ranking[0].fit
    assert with_usual_loop(selector.engine, leader, Rivals([])) is leader


def test_a_controller_that_no_load_brings_to_its_ends_is_given_none():
    robot = {"speed_controller__hold": 4.0, "coulomb_friction__friction": 0.005}
    selector, _, _ = ranked_if_bared(*ranked_on(robot, "coulomb_friction"))
    assert found_free(selector.base, HOLD)
    assert not found_free(selector.base, MOST)


def test_a_controller_whose_integral_ends_on_a_slope_is_found_on_the_bare_base():
    engine = engine_of(*(recording(s, **CONTROLLER, floor_tilt__slope_x=0.06) for s in (0, 1)))
    fit = with_usual_loop(engine, fit_base(engine), Rivals([]))
    assert fitted_number(fit, HOLD) == pytest.approx(3.0, rel=0.1)
    assert fitted_number(fit, MOST) == pytest.approx(0.1, abs=0.01)


def test_a_supply_that_ends_just_above_full_command_is_kept_without_an_integral_that_never_ends():
    robot = {**CONTROLLER, "speed_controller__most": 1.0, "speed_controller__ceiling": 1.12}
    engine = engine_of(*(recording(seed, asked=2.0, **robot) for seed in (0, 1)))
    fit = with_usual_loop(engine, fit_base(engine), Rivals([]))
    for name, true, within in ((HOLD, 3.0, 0.3), (CEILING, 1.12, 0.04), (LOOP, 1.5, 0.2)):
        assert fitted_number(fit, name) == pytest.approx(true, abs=within)
    assert not found_free(fit, MOST)


def test_where_limits_of_acceleration_explain_more_the_controller_is_found_beside_them():
    limits = {"motor_asymmetric_lag__ramp_up": 1.0, "motor_asymmetric_lag__ramp_down": 1.0}
    selector, _, ranking = ranked_on({**CONTROLLER, **limits, "asked": 2.0}, "motor_asymmetric_lag")
    rivals = Rivals(selector.catalogue)
    assert with_usual_loop(selector.engine, selector.base, rivals, asked_again=True) is selector.base
    fit = with_usual_loop(selector.engine, ranking[0].fit, Rivals([]))
    assert fitted_number(fit, HOLD) == pytest.approx(3.0, rel=0.15)
    assert fitted_number(fit, "motor_asymmetric_lag.ramp_up") == pytest.approx(1.0, rel=0.05)


def test_bounds_that_no_drive_feels_are_not_taken():
    robot = {"speed_controller__hold": 3.0, "coulomb_friction__friction": 0.005}
    engine = engine_of(*(recording(seed, **robot) for seed in (0, 1)))
    base = fit_base(engine)
    assert with_usual_loop(engine, base, Rivals([])) is base
