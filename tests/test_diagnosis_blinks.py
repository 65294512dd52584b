"""A plug that loses contact again and again: short spans of one drive that are one fault, and no pushes."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis_robots import (
    HEADING_NOISE,
    POSITION_NOISE,
    START,
    decided,
    engine_of,
    recording,
    robot,
    speeds,
)

from fsm_calib.diagnosis.candidates.candidate import Candidate
from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis, alike_in
from fsm_calib.diagnosis.candidates.once_more import once_more
from fsm_calib.diagnosis.candidates.outstanding import standing_out
from fsm_calib.diagnosis.candidates.plausible import lasts
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.candidates.starts import Start
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.observation import predict
from fsm_calib.world2d.parameters import parameter_table
from fsm_calib.world2d.rollout import Drive

OPEN = ((9.0, 0.6), (16.3, 0.4), (24.1, 0.7), (31.4, 0.5))
"""Begin and length [s] of the times at which the plug is open."""


def acted(command, spans, loss):
    """Return the commands that act where the right motor misses a part of them in some spans."""
    edges = [t for begin, length in spans for t in (begin, begin + length)]
    times = np.unique([*command.time, *edges])
    now = np.maximum(np.searchsorted(command.time, times, side="right") - 1, 0)
    right = command.right[now].copy()
    for begin, length in spans:
        right[(times >= begin) & (times < begin + length)] *= 1.0 - loss
    return Drive(times, command.left[now], right)


def plugged(seed, spans=OPEN, loss=1.0):
    """Return a drive in which the right motor loses contact; the commands that were recorded do not tell."""
    whole = recording(seed)
    poses = predict(robot(), acted(whole.command, spans, loss), whole.pose.time, START).poses
    rng = np.random.default_rng((seed, 9))
    poses = poses + rng.normal(size=poses.shape) * [POSITION_NOISE, POSITION_NOISE, HEADING_NOISE]
    x, y, theta = poses.T
    return replace(whole, pose=replace(whole.pose, x=x, y=y, theta=theta))


def offered(*recordings):
    """Return what a scan of some recordings offers of faults that come several times."""
    engine = engine_of(*recordings)
    found = Bank.on(engine, fit_base(engine)).scanner.spans(registry()["motor_fault"])
    return [candidate for candidate in found if "motor_fault.start_2" in candidate.changes]


def test_a_plug_that_opens_four_times_is_one_fault_of_that_motor():
    best = max(offered(plugged(0), recording(1)), key=lambda candidate: candidate.promise)
    assert best.run == 0
    begins = sorted(value for name, value in best.changes.items() if "start" in name)
    assert all(min(abs(begin - at) for at, _ in OPEN) < 0.5 for begin in begins)
    assert len(begins) >= 3
    assert best.changes["motor_fault.loss_right"] > 0.5
    assert "motor_fault.loss_left" not in best.changes


def test_a_robot_whose_plugs_are_tight_has_no_such_spans():
    assert offered(recording(0), recording(1)) == []


def test_a_plug_that_opened_once_did_not_do_so_several_times():
    assert offered(plugged(0, OPEN[:1]), recording(1)) == []


def test_a_plug_that_opened_once_for_a_moment_is_a_fault_of_the_whole_motor_and_no_push():
    once = ((16.3, 0.13),)
    decision = decided([plugged(0, once), recording(1)], ("external_push", "motor_fault"))
    assert [belief.name for belief in decision.named] == ["motor_fault"]
    fit = decision.model.effects[0].fit
    told = {n: fit.values[0, parameter_table().place(f"motor_fault.{n}")] for n in ("loss_right", "start")}
    assert told == pytest.approx({"loss_right": 1.0, "start": 16.3}, abs=0.25)


def test_it_is_named_a_fault_and_not_pushes():
    decision = decided([plugged(0), plugged(1)], ("external_push", "motor_fault", "payload_offset"))
    assert [belief.name for belief in decision.named] == ["motor_fault"]
    assert "times" in decision.model.effects[0].hypothesis.closure


TWICE = ((16.3, 0.13), (24.1, 0.3))


@pytest.fixture(scope="module")
def opened_twice():
    """A fit with one of two moments in which the plug was open, and the best fit with one more."""
    engine = engine_of(plugged(0, TWICE), recording(1))
    bank, effect = Bank.on(engine, fit_base(engine)), registry()["motor_fault"]
    form = Hypothesis("motor_fault", effect.closure("right motor").frees, 0, closure="right motor")
    begun = {"motor_fault.loss_right": 0.9, "motor_fault.start": 16.3, "motor_fault.duration": 0.15}
    once = bank.fit(form, Start(with_values(bank.parent.values, begun, 0), 0.0))
    return once, Bank.on(engine, once.fit)


def test_an_event_that_a_model_has_is_found_once_more_with_numbers_of_its_own(opened_twice):
    once, bank = opened_twice
    more = bank.again(once.hypothesis, 0)
    assert more.hypothesis.closure == "right motor, two times"
    assert more.evidence > 50.0
    first, second = (
        more.fit.values[0, parameter_table().place(f"motor_fault.{n}")] for n in ("start", "start_2")
    )
    assert (first, second) == pytest.approx((16.3, 24.1), abs=0.1)


def test_an_event_is_not_found_once_more_in_a_recording_without_one(opened_twice):
    once, bank = opened_twice
    other = bank.again(once.hypothesis, 1)
    assert other is None or other.evidence < 14.0


def one_more(told, known, values):
    """Return what is made of a span that a scan tells, where the right motor is known to have failed `known` times."""
    effect = registry()["motor_fault"]
    changes = {f"motor_fault.{name}": value for name, value in told.items()}
    return once_more(
        effect, alike_in(effect, "right motor"), (0, known), [Candidate(changes, 30.0, 0)], values
    )


def test_once_more_takes_no_moment_of_the_other_motor_and_none_beyond_the_catalogues_times():
    values, moment = parameter_table().null[None], {"start": 9.0, "duration": 0.2}
    (form, (start,)) = one_more({"loss_right": 0.4, **moment}, 2, values)[0]
    assert form.closure == "right motor, three times"
    assert start.values[0, parameter_table().place("motor_fault.start_3")] == 9.0
    assert one_more({"loss_left": 0.4, **moment}, 2, values) == []
    assert one_more({"loss_right": 0.4, **moment}, 8, values) == []


def test_the_opposite_of_a_fault_within_it_is_a_pause_between_two():
    known = {"motor_fault.loss_right": 0.02, "motor_fault.start": 21.0, "motor_fault.duration": 30.0}
    values = with_values(parameter_table().null[None], known, 0)

    def begun(start, duration):
        plans = one_more({"loss_right": -0.01, "start": start, "duration": duration}, 1, values)
        names = ("start", "duration", "start_2", "duration_2")
        places = [parameter_table().place(f"motor_fault.{name}") for name in names]
        return [starts[0].values[0, places].tolist() for _, starts in plans]

    assert begun(31.0, 9.0) == [[21.0, 10.0, 40.0, 11.0]]
    assert begun(45.0, 9.0) == []  # it ends after the fault does


def test_the_losses_of_several_spans_are_what_one_span_loses():
    grid = np.arange(0.0, 12.0, 0.01)
    told = {"loss_right": 0.5, "start": 2.0, "duration": 1.0, "start_3": 6.0, "duration_3": 2.0}
    faults = {f"motor_fault__{name}": value for name, value in told.items()}
    faulty, whole = speeds([0.0], [0.3], grid, **faults), speeds([0.0], [0.3], grid)
    lost = 1.0 - faulty / np.maximum(whole, 1e-9)
    settled = [
        lost[(grid > a) & (grid < b)].mean() for a, b in ((2.8, 3.0), (4.5, 6.0), (7.5, 8.0), (10.0, 12.0))
    ]
    assert settled[0] > 0.2
    assert settled[2] > 0.2
    assert np.abs([settled[1], settled[3]]).max() < 0.01


@pytest.mark.parametrize(
    ("count", "length", "loss", "expected"),
    [
        (1, 0.5, 0.2, False),
        (2, 0.5, 0.2, False),
        (3, 0.5, 0.2, True),
        (1, 3.0, 0.2, True),
        (1, 0.1, 0.8, True),
    ],
)
def test_short_spans_last_where_they_come_often_or_take_the_whole_motor(count, length, loss, expected):
    table, effect = parameter_table(), registry()["motor_fault"]
    closure = "right motor" if count == 1 else f"right motor, {('two', 'three')[count - 2]} times"
    values = table.null[None].copy()
    values[0, table.place("motor_fault.loss_right")] = loss
    for time in range(1, count + 1):
        end = "" if time == 1 else f"_{time}"
        values[0, table.place(f"motor_fault.start{end}")] = 8.0 * time
        values[0, table.place(f"motor_fault.duration{end}")] = length
    form = Hypothesis("motor_fault", effect.closure(closure).frees, 0, closure=closure)
    ranked = SimpleNamespace(name="motor_fault", hypothesis=form, fit=SimpleNamespace(values=values))
    assert lasts(ranked, engine_of(recording(0)).simulators) == expected


def test_faults_of_one_motor_are_of_one_kind_however_often_they_come():
    kind = alike_in(registry()["motor_fault"], "left motor")
    assert {"left motor", "left motor, two times", "left motor, eight times"} <= kind
    assert not any("right" in name or "both" in name for name in kind)
    assert alike_in(registry()["motor_fault"], "both motors") == {"both motors"}
    pushes = registry()["external_push"]
    assert alike_in(pushes, "held") == {closure.name for closure in pushes.closures if not closure.alike}


@pytest.mark.parametrize(
    ("won", "expected"),
    [
        ([30.0, 28.0, 26.0, 6.0], 3),
        ([30.0, 26.0, 22.0, 18.0], 0),
        ([8.0, 7.5, 1.0], 0),
        ([30.0, 12.0, 3.0], 2),
        ([30.0], 0),
    ],
)
def test_moments_stand_out_together_where_a_gap_follows_them(won, expected):
    assert standing_out(won, worth=10.0, most=4) == expected
