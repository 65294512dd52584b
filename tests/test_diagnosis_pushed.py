"""How hard was it pushed? A simulation tells, also of a robot that does not move until its friction gives way."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_robots import engine_of, recording

from fsm_calib.diagnosis.candidates.push_search import _moments_of, _others
from fsm_calib.diagnosis.candidates.pushed import Moment, Pushed, known_beside, standing
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.candidates.scan_pushes import Pushes
from fsm_calib.diagnosis.candidates.whole_base import fit_whole_base
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.replay.passage import Passages
from fsm_calib.diagnosis.replay.simulator import scale_of
from fsm_calib.diagnosis.replay.situation import situations_of
from fsm_calib.world2d.effects import registry

BEGIN = 12.0  # s


def moment_of(run, length, hidden, start=BEGIN, fitted=fit_base, **robot):
    """Return a moment of one of two drives of a `robot`, of which the second has `hidden` at BEGIN."""
    changes = {f"external_push__{name}": value for name, value in hidden.items()}
    drives = (recording(0, **robot), recording(1, external_push__start=BEGIN, **changes, **robot))
    engine = engine_of(*drives)
    base = fitted(engine)
    scanner = Bank.on(engine, base).scanner
    situation = situations_of(engine.simulators, base.values)[run]
    passages = Passages.of(engine.simulators[run], base.values[run], base.simulated[run])
    effect, scale = registry()["external_push"], scale_of(engine.simulators[0])
    return Moment(effect, passages, scanner.residual, situation, run, start, length, scale)


def asked(run, length, hidden):
    """Return the push that a simulation finds at BEGIN."""
    return moment_of(run, length, hidden).push()


@pytest.mark.parametrize(
    ("hidden", "length"),
    [
        ({"impulse_x": 1.2, "impulse_y": -0.8, "impulse_turn": 0.05}, 0.25),
        ({"impulse_x": 6.0, "impulse_y": 3.0, "impulse_turn": 0.1, "duration": 1.5}, 1.5),
    ],
)
def test_a_push_is_found_as_large_as_it_was(hidden, length):
    found = asked(1, length, hidden)
    true = np.array([hidden["impulse_x"], hidden["impulse_y"]])
    told = np.array([found.changes["external_push.impulse_x"], found.changes["external_push.impulse_y"]])
    assert np.linalg.norm(told - true) < 0.5 * np.linalg.norm(true)
    assert found.won > 20.0
    assert ("external_push.duration" in found.changes) == ("duration" in hidden)


def test_where_nobody_pushed_nothing_is_won():
    assert asked(0, 0.25, {"impulse_x": 1.2}).won < 10.0


def pushed(run, start, won):
    return Pushed(run, start, 0.25, {}, won)


def standing_in(pushes, worth):
    """Return what stands out of some pushes in each recording, of at most four."""
    return {push.run: standing(pushes, push.run, worth, 4) for push in pushes}


def others(pushes, known):
    """Return what moments win that are none of the known ones, most first."""
    none = Pushes(0, 0.25, *(np.empty(shape) for shape in (0, 0, (0, 3), (0, 3, 3))))
    return _others(_moments_of([[none, replace(none, run=1)]], pushes), known)


def test_other_moments_are_apart_in_time_and_not_the_best_of_another_recording():
    here, beside, later = pushed(0, 5.0, 90.0), pushed(0, 5.5, 80.0), pushed(0, 9.0, 20.0)
    best, same, second = pushed(1, 4.0, 70.0), pushed(1, 4.5, 60.0), pushed(1, 8.0, 30.0)
    for some, expected in (
        ([here, beside, later, best, same, second], [30.0, 20.0]),
        ([here, beside, later, best, same], [20.0]),
        ([here, beside], []),
    ):
        assert others(some, known_beside(here, standing_in(some, 1e9))) == expected


def test_pushes_that_all_stand_out_do_not_deny_each_other():
    pushes = [pushed(0, 5.0, 90.0), pushed(0, 9.0, 80.0), pushed(0, 20.0, 12.0), pushed(1, 4.0, 11.0)]
    stand = standing_in(pushes, 20.0)
    assert stand[0] == pushes[:2]
    assert others(pushes, known_beside(pushes[0], stand)) == [12.0]
    assert others(pushes, known_beside(pushes[2], stand)) == [90.0, 80.0]


def test_several_small_pushes_stand_out_where_one_alone_would_not():
    three = [pushed(0, 5.0, 45.0), pushed(0, 15.0, 34.0), pushed(0, 25.0, 28.0)]
    chance = [pushed(0, 35.0, 12.0), pushed(0, 45.0, 11.0)]
    assert standing([*three, *chance], 0, 24.0, 4) == three
    assert (
        standing([three[0], *chance, pushed(0, 55.0, 40.0), pushed(0, 65.0, 36.0)], 0, 24.0, 2) == three[:1]
    )


def test_a_further_push_that_does_not_win_its_numbers_is_none():
    pushes = [pushed(0, 5.0, 80.0), pushed(0, 15.0, 35.0), pushed(0, 25.0, 18.0), pushed(0, 35.0, 6.0)]
    assert standing(pushes, 0, 24.0, 4) == pushes[:2]


def test_of_jolts_that_come_in_all_sizes_none_stands_out_with_another():
    jolts = [pushed(0, 3.0 * i, 90.0 - 15.0 * i) for i in range(6)]
    stand = standing_in(jolts, 20.0)
    assert stand[0] == jolts[:1]
    assert others(jolts, known_beside(jolts[0], stand))[0] == 75.0


def test_a_kick_against_a_stiff_controller_is_found_between_the_moments_of_the_scan():
    stiff = {"speed_controller__hold": 12.0, "tau_forward": 0.03, "tau_turn": 0.03}
    kick = {"impulse_x": 1.2, "impulse_turn": 0.06}
    moment = moment_of(1, 0.25, kick, BEGIN - 0.15, lambda engine: fit_whole_base(engine, []), **stiff)
    assert moment.kick().won > 20.0
    assert moment.push().won < 0.5 * moment.kick().won


def test_how_long_somebody_leant_on_a_robot_with_a_controller_is_found_from_how_it_began():
    stiff = {"speed_controller__hold": 12.0, "tau_forward": 0.03, "tau_turn": 0.03}
    lean = {"impulse_x": 2.4, "impulse_turn": 0.1, "duration": 1.2}
    moment = moment_of(1, 0.25, lean, BEGIN, lambda engine: fit_whole_base(engine, []), **stiff)
    assert moment.held().length == pytest.approx(1.2, abs=0.5)
    assert moment.held().won > 2.0 * moment.kick().won


def test_what_a_span_of_events_makes_of_columns_is_what_the_whole_recording_does():
    moment = moment_of(1, 0.25, {"impulse_x": 1.2})
    whitener, rng = moment.residual.whiteners[1], np.random.default_rng(0)
    first, last = 200, 260
    columns = np.zeros((len(whitener.prepared.time), 5, 2))
    columns[first : last + 1] = rng.normal(size=(last + 1 - first, 5, 2))
    before = int(whitener.prepared.scored[:first].sum())
    part = whitener.of_span(columns[first : last + 1], first, last)
    np.testing.assert_allclose(part, whitener.columns(columns)[before : before + len(part)], atol=1e-12)
