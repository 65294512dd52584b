"""Motors of unequal slopes: found in the base, told, and not taken for a load beside the axle."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_robots import drive, engine_of, recording, selector_on

from fsm_calib.diagnosis.candidates.free_number import found_free, unless_stood_in, with_free
from fsm_calib.diagnosis.candidates.rivals import Rivals
from fsm_calib.diagnosis.candidates.stiffness import STIFFNESS, stiffness_told, with_stiffness
from fsm_calib.diagnosis.candidates.whole_base import fit_whole_base
from fsm_calib.diagnosis.fitting.base import fit_base, slot_of
from fsm_calib.diagnosis.verdict.bared import ranked_if_bared
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.observation import predict
from fsm_calib.world2d.parameters import parameter_table, parameters
from fsm_calib.world2d.rollout import Drive

PLACE = parameter_table().place(STIFFNESS)
UNLIKE = {"unequal_motors__stiffness": 0.06}


def engine_with(**changes):
    """Return the engine over two drives of a robot with `changes`."""
    return engine_of(*(recording(seed, **changes) for seed in (0, 1)))


def stiffness_of(fit):
    """Return value and standard deviation of the freed number; none where it is held."""
    return next(((value, sd) for _, value, sd in found_free(fit, STIFFNESS)), None)


@pytest.fixture(scope="module")
def unlike():
    """Return the whole base of a robot whose right motor's torque falls 12 % more than the left one's."""
    return fit_whole_base(engine_with(**UNLIKE), list(registry().values()))


def test_unlike_motors_are_found_in_size_and_sign(unlike):
    value, sd = stiffness_of(unlike)
    assert value == pytest.approx(0.06, abs=3.0 * sd)
    assert sd < 0.015


def test_unlike_motors_are_told_in_a_sentence(unlike):
    (said,) = stiffness_told(unlike)
    assert said.startswith("the right motor's torque falls")


def test_equal_motors_have_no_such_number():
    engine = engine_with()
    base = fit_base(engine)
    held = with_stiffness(engine, base, Rivals(list(registry().values())))
    assert stiffness_of(held) is None
    assert not stiffness_told(held)


def test_a_load_beside_the_axle_keeps_the_number_held():
    engine = engine_with(payload_offset__y=0.02)
    held = with_stiffness(engine, fit_base(engine), Rivals(list(registry().values())))
    assert stiffness_of(held) is None


def test_the_mirrored_robot_has_the_other_sign():
    commands = drive(np.random.default_rng(3), 10.0)
    swapped = Drive(commands.time, commands.right, commands.left)
    stamps = np.arange(0.0, 10.0, 0.1)
    base = {"gain_left": 0.6, "gain_right": 0.6}
    one = predict(parameters({**base, STIFFNESS: 0.08}), commands, stamps, (0.0, 0.0, 0.0)).poses
    other = predict(parameters({**base, STIFFNESS: -0.08}), swapped, stamps, (0.0, 0.0, 0.0)).poses
    np.testing.assert_allclose(one, other * [1.0, -1.0, -1.0], atol=1e-9)


def test_a_start_turns_the_robot_by_twice_the_number_times_the_way_that_the_lag_costs():
    """To first order a start from rest to T turns it by 2 rho T tau / b, however slow the turn: momenta balance."""
    rho, no_load, tau, axle = 0.02, 0.6 * 0.4, 0.08, 0.1
    straight = Drive([0.5], [0.4], [0.4])
    numbers = {"gain_left": 0.6, "gain_right": 0.6, "tau_forward": tau, "axle_length": axle, STIFFNESS: rho}
    heading = predict(parameters(numbers), straight, np.array([0.5, 3.0]), (0.0, 0.0, 0.0)).poses[-1, 2]
    assert heading == pytest.approx(2.0 * rho * no_load * tau / axle, rel=0.01)


def test_a_number_that_another_effect_has_made_small_is_not_told(unlike):
    values = unlike.values.copy()
    values[:, PLACE] = 0.5 * stiffness_of(unlike)[1]
    assert not stiffness_told(replace(unlike, values=values))


def ranked(engine, *names):
    """Return selector, bank and ranking of some effects on a base robot of like motors."""
    selector = selector_on(fit_base(engine), engine, *names)
    return selector, *selector.first_ranked()


def test_unlike_motors_beside_the_first_effect_are_the_base_of_all():
    given = ranked(engine_with(**UNLIKE, motor_deadband__offset=0.06), "motor_deadband", "payload_offset")
    selector, _, ranking = ranked_if_bared(*given)
    assert given[2][0].name == ranking[0].name == "motor_deadband"
    assert found_free(selector.base, STIFFNESS)
    assert stiffness_of(ranking[0].fit)[0] == pytest.approx(0.06, abs=0.02)


def test_like_motors_beside_the_first_effect_change_nothing():
    given = ranked(engine_with(motor_deadband__offset=0.06), "motor_deadband", "payload_offset")
    assert ranked_if_bared(*given) == given


@pytest.mark.parametrize("as_good", [True, False])
def test_the_robots_own_number_takes_the_place_of_one_like_it_where_both_do_as_well(as_good):
    """A rival leads that leaves the number nothing to say, unless that stands in for one of the rival's own."""
    engine = engine_with(duration=40.0, unequal_motors__stiffness=0.03, payload_offset__x=-0.03)
    base, slot = fit_base(engine), slot_of(STIFFNESS)

    def freed(fit):
        return with_free(engine, fit, [slot], (0.02,)) if fit is base else fit

    found = unless_stood_in(
        engine,
        base,
        freed,
        Rivals([registry()["payload_offset"]]),
        lambda rival: rival.fit if as_good else base,
    )
    assert bool(found_free(found, STIFFNESS)) is as_good


def test_noise_that_is_fitted_again_is_no_evidence_of_the_number_beside_it():
    """The base has far more noise than there is; a fit with the number free wins hundreds of units by that alone."""
    engine = engine_with()
    base = fit_base(engine)
    noisy = replace(base.noise, forward=0.02, turning=0.1)
    loose = engine.fit(base.values, base.slots, noisy)
    slot = slot_of(STIFFNESS)
    freed = with_free(engine, loose, [slot], (0.02,))
    assert freed.score > loose.score + 100.0
    found = unless_stood_in(engine, loose, lambda fit: with_free(engine, fit, [slot], (0.02,)), Rivals([]))
    assert found is loose
