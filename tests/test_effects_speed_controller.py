"""A controller with an integral holds the wheels' speeds: how robots are built that are told velocities."""

from functools import partial

import diagnosis_robots
import numpy as np
import pytest
from diagnosis_robots import engine_of, judged, recording, selector_on

from fsm_calib.diagnosis.candidates.free_number import with_free
from fsm_calib.diagnosis.candidates.speed_loop import DROPS, HOLD, WEIGHT, loop_told
from fsm_calib.diagnosis.candidates.usual_loop import MOST
from fsm_calib.diagnosis.candidates.whole_base import fit_whole_base
from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.diagnosis.fitting.base import fit_base, slot_of
from fsm_calib.diagnosis.verdict import bared
from fsm_calib.diagnosis.verdict.bared import ranked_if_bared
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

RIVALS = ("coulomb_friction", "motor_asymmetric_lag", "command_delay", "motor_deadband", "battery_sag")
GAIN, LAG = 0.6, 0.1
MARKED = {"turn": 0.2, "shift_x": 0.04, "x": 0.15, "y": 0.0, "radius": 0.25}
HOLD_PLACE, WEIGHT_PLACE = (parameter_table().place(name) for name in (HOLD, WEIGHT))
speeds = partial(diagnosis_robots.speeds, gain_left=GAIN, gain_right=GAIN, tau_forward=LAG, slip_speed=1e-4)


def based(*recordings):
    return fit_whole_base(engine_of(*recordings), [registry()[name] for name in RIVALS])


def free(fit):
    return {slot.place: float(value) for slot, value, _ in fit.numbers()}


@pytest.mark.parametrize(("hold", "weight"), [(4.0, 1.0), (10.0, 0.3), (25.0, 0.0)])
def test_a_step_rings_as_a_loop_of_second_order(hold, weight):
    """tau w'' + w' + hold w = weight w_s' + hold w_s, integrated apart in steps of 0.1 ms."""
    grid = np.arange(0.0, 2.0, 0.005)
    step, wanted, speed, integral, expected = 1e-4, GAIN * 0.5, 0.0, 0.0, [0.0]
    for _ in range(round(grid[-1] / step)):
        missed = wanted - speed
        speed += step * (weight * wanted + integral - speed) / LAG
        integral += step * hold * missed
        expected.append(speed)
    found = speeds([0.0], [0.5], grid, speed_controller__hold=hold, speed_controller__weight=weight)
    assert found == pytest.approx(np.array(expected)[np.rint(grid / step).astype(int)], abs=4e-3)


def test_no_lasting_load_slows_it_down():
    grid = np.arange(0.0, 4.0, 0.01)
    load = {"coulomb_friction__friction": 0.02}
    free_run, loaded = (speeds([0.0], [0.5], grid, **e)[-1] for e in ({}, load))
    held = speeds([0.0], [0.5], grid, speed_controller__hold=4.0, **load)[-1]
    assert loaded < 0.95 * free_run
    assert held == pytest.approx(free_run, rel=1e-3)


def test_it_lets_go_where_the_robot_rests():
    """What the integral had gathered against a load is not there at the next start."""
    grid = np.arange(0.0, 6.0, 0.01)
    options = {"speed_controller__hold": 4.0, "coulomb_friction__friction": 0.02, "slip_speed": 0.0125}
    speed = speeds([0.0, 2.0, 4.0], [0.5, 0.0, 0.5], grid, **options)
    assert np.abs(speed[360:400]).max() < 1e-6
    assert speed[400:500] == pytest.approx(speed[:100], abs=1e-3)


def test_what_is_dropped_with_the_command_does_not_drive_the_wheel_back():
    """Without an integral the wheel comes to rest as w = w_0 exp(-t / tau); one that is kept drives it back."""
    grid = np.arange(0.0, 4.0, 0.01)
    kept, dropped = (
        speeds([0.0, 2.0], [0.5, 0.0], grid, speed_controller__hold=4.0, speed_controller__drops=drops)
        for drops in (0.0, 1.0)
    )
    after = grid >= 2.0
    assert dropped[after] == pytest.approx(dropped[200] * np.exp(-(grid[after] - 2.0) / LAG), abs=2e-3)
    assert kept[after].min() < -0.02
    assert np.array_equal(kept[~after], dropped[~after])


@pytest.mark.parametrize("drops", [0.0, 1.0])
def test_how_it_rests_is_found(drops):
    robot = {"speed_controller__hold": 4.0, "speed_controller__drops": drops}
    fit = based(*(recording(seed, **robot) for seed in (0, 1)))
    assert np.all(fit.values[:, parameter_table().place(DROPS)] == drops)
    assert any("drops" in said for said in loop_told(fit)) == bool(drops)


@pytest.mark.parametrize("drops", [0.0, 1.0])
def test_how_it_rests_is_found_beside_dry_friction(drops):
    """Without the friction a kept integral seems likelier of both."""
    robot = {
        "speed_controller__hold": 4.0,
        "speed_controller__drops": drops,
        "coulomb_friction__friction": 0.01,
    }
    selector, _, ranking = ranked_if_bared(*ranked_on(robot, *RIVALS))
    assert ranking[0].name == "coulomb_friction"
    assert np.all(selector.base.values[:, parameter_table().place(DROPS)] == drops)


def test_a_robot_that_has_one_is_given_one():
    fit = based(*(recording(seed, 40.0, speed_controller__hold=5.0) for seed in (0, 1)))
    assert free(fit)[HOLD_PLACE] == pytest.approx(5.0, rel=0.1)
    assert WEIGHT_PLACE not in free(fit)


def test_one_without_feed_forward_has_a_weight_of_its_set_point():
    fit = based(*(recording(s, speed_controller__hold=5.0, speed_controller__weight=0.4) for s in (0, 1)))
    assert free(fit)[HOLD_PLACE] == pytest.approx(5.0, rel=0.1)
    assert free(fit)[WEIGHT_PLACE] == pytest.approx(0.4, abs=0.05)


@pytest.mark.parametrize(
    "robot",
    [
        {},
        {"coulomb_friction__friction": 0.01},
        {"motor_deadband__offset": 0.06},
        {"command_delay__delay": 0.25},
        {"motor_asymmetric_lag__ratio": 1.6},
    ],
    ids=lambda robot: next(iter(robot), "nothing"),
)
def test_a_robot_that_is_told_duties_has_none(robot):
    assert HOLD_PLACE not in free(based(*(recording(seed, **robot) for seed in (0, 1))))


def test_it_is_said_and_never_accused():
    others = set(registry()) - set(RIVALS)
    found = diagnose([recording(seed, speed_controller__hold=5.0) for seed in (0, 1)], without=others)
    assert found.decision.outcome == "match"
    assert found.verdict.base[HOLD].value == pytest.approx(5.0, rel=0.1)
    assert any("a controller holds the wheels' speeds (integral" in note for note in found.notes)


def test_an_effect_is_named_beside_it():
    decision = judged(RIVALS, speed_controller__hold=5.0, motor_deadband__offset=0.08)
    assert [belief.name for belief in decision.named] == ["motor_deadband"]


def ranked_beside_a_marker(**robot):
    """Return selector, bank and ranking of a `robot` whose poses are wrong about a marker."""
    numbers = {f"misplaced_marker__{name}": value for name, value in MARKED.items()}
    return ranked_on({**robot, **numbers}, "misplaced_marker", "motor_asymmetric_lag")


def test_one_that_a_misplaced_marker_hid_is_bare_beside_it():
    selector, _, ranking = ranked_if_bared(*ranked_beside_a_marker(speed_controller__hold=5.0))
    assert free(selector.base)[HOLD_PLACE] > 1.0
    assert ranking[0].name == "misplaced_marker"
    assert free(ranking[0].fit)[HOLD_PLACE] == pytest.approx(5.0, rel=0.15)


def test_beside_a_marker_a_robot_without_one_is_given_none():
    found = ranked_beside_a_marker()
    assert ranked_if_bared(*found) == found


def ranked_on(robot, *names):
    """Return selector, bank and ranking of a `robot` among some effects, on the base as it is without a controller."""
    engine = engine_of(*(recording(seed, **robot) for seed in (0, 1)))
    selector = selector_on(fit_base(engine), engine, *names)
    return selector, *selector.first_ranked()


def test_one_that_winds_up_against_dry_friction_is_bare_beside_it():
    robot = {
        "speed_controller__hold": 5.0,
        "speed_controller__weight": 0.0,
        "coulomb_friction__friction": 0.02,
    }
    selector, _, ranking = ranked_if_bared(*ranked_on(robot, *RIVALS))
    assert {HOLD_PLACE, WEIGHT_PLACE} <= set(free(selector.base))
    assert ranking[0].name == "coulomb_friction"
    assert free(ranking[0].fit)[HOLD_PLACE] == pytest.approx(5.0, rel=0.1)
    assert free(ranking[0].fit)[WEIGHT_PLACE] == pytest.approx(0.0, abs=0.05)


@pytest.mark.parametrize("hidden", [{"command_delay__delay": 0.2}, {"motor_asymmetric_lag__ratio": 1.6}])
def test_beside_dry_friction_a_late_robot_that_is_told_duties_is_given_none(hidden):
    found = ranked_on({"coulomb_friction__friction": 0.02, **hidden}, *RIVALS)
    selector, _, _ = ranked_if_bared(*found)
    assert HOLD_PLACE not in free(selector.base)


def test_a_number_that_is_found_in_place_of_the_one_that_was_asked_for_is_kept(monkeypatch):
    def with_weight(engine, fit, rivals):
        return with_free(engine, fit, [slot_of(WEIGHT)], (1.0,))

    found = ranked_on({"coulomb_friction__friction": 0.02}, "coulomb_friction")
    monkeypatch.setattr(bared, "NUMBERS", ((MOST, with_weight),))
    selector, _, ranking = ranked_if_bared(*found)
    assert WEIGHT_PLACE in free(selector.base)
    assert ranking[0].name == "coulomb_friction"
