"""A push that comes alike in every drive is told by both together, where neither drive tells it alone."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis_robots import engine_of, recording

from fsm_calib.diagnosis.candidates.each_its_own import each_its_own
from fsm_calib.diagnosis.candidates.plausible import is_seen
from fsm_calib.diagnosis.candidates.push_alike import _agreeing, _Told
from fsm_calib.diagnosis.candidates.push_search import PushSearch
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.candidates.scan_pushes import turns
from fsm_calib.diagnosis.candidates.scanned import WORTH_FITTING, scanned
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.fitting.slot import ALL_RUNS
from fsm_calib.diagnosis.replay.simulator import scale_of
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.effects.external_push import ALONG_WHAT
from fsm_calib.world2d.parameters import parameter_table, parameters
from fsm_calib.world2d.rollout import Drive, simulate

BEGINS = (12.0, 21.0)  # s, of a push in each of two drives
TWIST = {"impulse_turn": 0.007}
PUSH = registry()["external_push"]


def told(starts, scores):
    """Return moments of a recording with some scores, all of the same power."""
    return _Told(np.array(starts), np.tile(np.eye(3), (len(starts), 1, 1)), np.array(scores, dtype=float))


def test_moments_agree_where_one_impulse_explains_both():
    chance = [[4.0, 0.0, 0.0], [0.0, -4.0, 0.0]]
    first = told([1.0, 2.0, 3.0], [*chance, [3.0, 3.0, 1.0]])
    second = told([4.0, 5.0, 6.0], [[-4.0, 0.0, 0.0], [3.0, 3.0, 1.0], [0.0, 0.0, 4.0]])
    best = max(_agreeing([first, second], 0.0, 0.25), key=lambda one: one.agreed)
    assert best.starts == (3.0, 5.0)
    assert best.won == best.agreed == pytest.approx(19.0)  # half of (6^2 + 6^2 + 2^2) / 2; each alone has 9.5


def test_what_one_drive_has_alone_agrees_with_nothing():
    first = told([1.0, 2.0], [[20.0, 0.0, 0.0], [3.0, 1.0, 0.0]])
    second = told([4.0, 5.0], [[0.0, 3.0, 0.0], [3.0, 1.0, 0.0]])
    found = {one.starts: one for one in _agreeing([first, second], 0.0, 0.25)}
    best = max(found.values(), key=lambda one: one.agreed)
    assert best.starts == (2.0, 5.0)
    assert max(found.values(), key=lambda one: one.won).starts == (1.0, 5.0)


def test_moments_of_three_drives_are_joined_one_after_the_other():
    drives = [told([1.0, 2.0], [[4.0, 0.0, 0.0], [0.0, 0.0, 3.0 + run]]) for run in range(3)]
    drives[1] = told([1.0, 2.0], [[-4.0, 0.0, 0.0], [0.0, 0.0, 4.0]])
    best = max(_agreeing(drives, 0.0, 0.25), key=lambda one: one.agreed)
    assert best.starts == (2.0, 2.0, 2.0)


def test_what_is_ahead_turns_with_the_heading():
    np.testing.assert_allclose(turns(np.array([np.pi / 2]))[0] @ [1.0, 0.0, 2.0], [0.0, 1.0, 2.0], atol=1e-12)


def pushed(**second):
    """Return an engine and base robot of two drives with the same twist, or another one in the second."""
    changes = ({**TWIST, "start": BEGINS[0]}, {**TWIST, **second, "start": BEGINS[1]})
    drives = [
        recording(run, **{f"external_push__{name}": value for name, value in own.items()})
        for run, own in enumerate(changes)
    ]
    engine = engine_of(*drives)
    return engine, fit_base(engine)


@pytest.fixture(scope="module")
def bank():
    return Bank.on(*pushed())


@pytest.fixture(scope="module")
def offered(bank):
    """Return the candidates of the scan for pushes, and those of both drives together."""
    scanner = bank.scanner
    scale = scale_of(scanner.simulators[0])
    search = PushSearch(PUSH, scanner.residual, scanner.situations, scanner.passages, scale)
    found = search.candidates(3)
    return [c for c in found if not c.each], [c for c in found if c.each]


def test_what_both_drives_have_is_found_at_its_moments(offered):
    best = max(offered[1], key=lambda candidate: candidate.promise)
    begins = [own["external_push.start"] for own in best.each]
    assert begins == pytest.approx(BEGINS, abs=0.5)
    assert best.run == ALL_RUNS


def test_both_drives_together_stand_out_farther_than_the_better_one(offered):
    alone, alike = (max(some, key=lambda candidate: candidate.promise) for some in offered)
    assert alike.promise > 1.4 * alone.promise
    assert alike.chance < alone.chance


def test_a_form_that_comes_alike_shares_its_impulse_and_has_a_begin_in_each_drive(bank):
    forms = [plan for plan in scanned(bank.prober, bank.scanner, PUSH) if plan[0].run == ALL_RUNS]
    fit = bank.fit(forms[0][0], forms[0][1][0]).fit
    table = parameter_table()
    own = {table.names[s.place]: s.run for s in fit.slots if table.owner[s.place] == "external_push"}
    assert own["external_push.impulse_turn"] == ALL_RUNS
    assert fit.runs_of("external_push") == (0, 1)
    turn = fit.values[:, table.place("external_push.impulse_turn")]
    assert turn[0] == turn[1] == pytest.approx(TWIST["impulse_turn"], rel=0.4)


def test_what_came_alike_is_tried_beside_a_much_stronger_push_of_one_drive():
    kick = {"impulse_x_2": 1.5, "impulse_y_2": 1.5, "start_2": 5.0}
    engine, base = pushed(**kick)
    bank = Bank.on(engine, base)
    forms = [(form, starts[0]) for form, starts in scanned(bank.prober, bank.scanner, PUSH) if starts]
    alike = [start.promise for form, start in forms if form.run == ALL_RUNS]
    assert alike
    assert max(alike) < WORTH_FITTING * max(start.promise for _, start in forms)


def hidden(run, begin):
    """Return recordings of which one has no poses for a second from `begin` [s] on."""
    time = np.arange(0.0, 40.0, 0.1)
    seen = [time, time]
    seen[run] = time[(time < begin - 0.05) | (time > begin + 1.0)]
    return [SimpleNamespace(prepared=SimpleNamespace(poses=SimpleNamespace(time=t))) for t in seen]


@pytest.mark.parametrize("run", [0, 1])
def test_what_came_alike_needs_to_be_seen_in_one_drive_and_what_came_in_one_drive_in_that(bank, run):
    form = next(p for p in scanned(bank.prober, bank.scanner, PUSH) if p[0].run == ALL_RUNS)
    found = bank.fit(form[0], form[1][0])
    begin = float(found.fit.values[run, parameter_table().place("external_push.start")])
    alone = replace(found, hypothesis=replace(found.hypothesis, run=run))
    assert is_seen(found, hidden(run, begin))
    assert not is_seen(alone, hidden(run, begin))


@pytest.mark.parametrize(("second", "own"), [({}, False), ({"impulse_turn": 0.025}, True)])
def test_pushes_have_numbers_of_their_own_only_where_these_tell_more(second, own):
    engine, base = pushed(**second)
    bank = Bank.on(engine, base)
    forms = [plan for plan in scanned(bank.prober, bank.scanner, PUSH) if plan[0].run == ALL_RUNS]
    ranked = max((bank.fit(form, starts[0]) for form, starts in forms), key=lambda r: r.evidence)
    found = each_its_own(engine, ranked)
    assert (found is not None) == own
    if found is not None:
        turn = found.fit.values[:, parameter_table().place("external_push.impulse_turn")]
        assert turn[1] > 1.5 * turn[0]
        assert found.evidence > ranked.evidence


def test_a_push_along_the_robot_is_the_same_push_along_the_room_turned_by_its_heading():
    grid, rest = np.arange(0.0, 6.0, 0.01), Drive(np.array([0.0]), np.array([0.0]), np.array([0.0]))
    free = {"gain_left": 0.6, "gain_right": 0.6, "external_push.start": 1.0}
    heading = 0.5 * np.pi
    ahead = {**free, "external_push.impulse_x": 0.3, "external_push.along": ALONG_WHAT["robot"]}
    north = {**free, "external_push.impulse_y": 0.3}
    paths = [simulate(parameters(p), rest, grid, (0.0, 0.0, heading))[:, :3] for p in (ahead, north)]
    np.testing.assert_allclose(paths[0], paths[1], atol=1e-12)
    assert paths[0][-1, 1] > 1e-3
