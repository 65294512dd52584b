"""An event in the moment that jolts the robot most is rather a patch on inexact laws than a push."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis_robots import engine_of, recording
from scipy.integrate import quad

from fsm_calib.diagnosis.candidates.jolts import (
    AFTER,
    BEFORE,
    TOO_JOLTED,
    _motion,
    against_patch,
    density,
    is_quiet,
)
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.diagnosis.proof.gates import DEFAULT_GATES
from fsm_calib.diagnosis.verdict.posterior import SURE
from fsm_calib.world2d.effects.numbered import numbered
from fsm_calib.world2d.parameters import parameter_table

NUDGE = {"external_push.impulse_x": 0.05, "external_push.impulse_y": 0.02}


@pytest.fixture(scope="module")
def drives():
    engine = engine_of(*(recording(seed) for seed in (0, 1)))
    return engine, fit_base(engine).values


def pushed(values, *moments):
    """Return a fit of which some recordings have a nudge: (run, start [s]) each."""
    return happened(values, NUDGE, "external_push", *((run, [start]) for run, start in moments))


def happened(values, strengths, name, *moments):
    """Return a fit of which some recordings have an event at some times: (run, starts [s]) each."""
    place, slots = parameter_table().place, []
    for run, starts in moments:
        told = {numbered(f"{name}.start", time): start for time, start in enumerate(starts, 1)}
        values = with_values(values, strengths | told, run)
        slots += [SimpleNamespace(place=place(full), run=run) for full in told]
    return SimpleNamespace(values=values, slots=slots, runs_of=lambda name: [run for run, _ in moments])


def moment(engine, values, order):
    """Return the start [s] in the second recording, the wilder one, with the so-many-th smallest jolt."""
    motion = _motion(engine, values, 1)
    return float(motion.times[np.argsort(motion.jolts)[order]])


def test_a_push_in_the_hardest_moment_of_the_drives_loses_its_name(drives):
    hardest = moment(*drives, -1)
    assert against_patch(drives[0], pushed(drives[1], (1, hardest)), ["external_push"]) > 2.0


def ranked(fit):
    """Return an event as a hypothesis is ranked."""
    return SimpleNamespace(name="external_push", fit=fit)


def test_an_event_may_not_be_said_where_each_of_its_moments_is_the_hardest_and_may_where_they_are_quiet(
    drives,
):
    engine, values = drives
    hard, quiet = (pushed(values, (1, moment(engine, values, order))) for order in (-1, 0))
    assert not is_quiet(engine, ranked(hard))
    assert is_quiet(engine, ranked(quiet))


def test_what_is_too_jolted_takes_the_surest_name_below_what_is_said():
    said = DEFAULT_GATES.least_confidence
    assert pytest.approx(SURE - math.log(said / (1.0 - said)), abs=0.05) == TOO_JOLTED


def test_a_push_in_a_quiet_moment_keeps_its_name(drives):
    quiet = moment(*drives, 0)
    assert against_patch(drives[0], pushed(drives[1], (1, quiet)), ["external_push"]) == 0.0


def test_one_quiet_moment_of_two_is_enough(drives):
    both = pushed(drives[1], (0, 0.1), (1, moment(*drives, -1)))
    alone = pushed(drives[1], (1, moment(*drives, -1)))
    assert against_patch(drives[0], both, ["external_push"]) < against_patch(
        drives[0], alone, ["external_push"]
    )


def test_what_comes_at_every_hard_moment_of_a_drive_loses_its_name_and_one_long_span_is_not_asked(drives):
    engine, values = drives
    loss = {"motor_fault.loss_left": 1.0, "motor_fault.loss_right": 1.0}
    hard = [moment(engine, values, -1 - 12 * k) for k in range(4)]
    quiet = [moment(engine, values, 120 * k) for k in range(4)]

    def against(*starts):
        return against_patch(engine, happened(values, loss, "motor_fault", (1, starts)), ["motor_fault"])

    assert against(*hard) > 4.0
    assert against(*quiet) == 0.0
    assert against(*hard) > against(hard[0], *quiet)
    assert against(hard[0]) == 0.0


@pytest.mark.parametrize(("seconds", "asked"), [(0.15, True), (1.9, True), (2.1, False)])
def test_a_span_as_short_as_a_push_is_asked(drives, seconds, asked):
    engine, values = drives
    fault = {"motor_fault.loss_left": 1.0, "motor_fault.duration": seconds}
    fit = happened(values, fault, "motor_fault", (1, [moment(engine, values, -1)]))
    assert (against_patch(engine, fit, ["motor_fault"]) > 2.0) is asked


def test_what_has_no_moment_is_not_asked(drives):
    assert against_patch(drives[0], pushed(drives[1], (1, moment(*drives, -1))), ["floor_tilt"]) == 0.0


def test_a_robot_that_stands_is_not_jolted_and_one_that_is_told_to_reverse_is(drives):
    """Nothing but its commands moves the base robot: its jolts come within a moment of their changes."""
    engine, values = drives
    motion = _motion(engine, values, 1)
    times, sizes = motion.times, motion.jolts
    drive = engine.simulators[1].drive
    begin = drive.time[np.flatnonzero(np.hypot(drive.left, drive.right))[0]]
    changes = np.hypot(np.diff(drive.left), np.diff(drive.right))
    hardest = drive.time[1 + np.flatnonzero(changes > 0.7 * changes.max())]
    assert sizes[times < begin - AFTER] == pytest.approx(0.0, abs=1e-9)
    assert np.abs(hardest - moment(engine, values, -1)).min() < AFTER + BEFORE


def test_pushes_where_wheels_begin_to_turn_lose_their_name_and_those_far_from_it_keep_it(drives):
    engine, values = drives
    motions = [_motion(engine, values, run) for run in range(2)]
    near, far = (
        pushed(values, *((run, float(m.times[np.argsort(m.apart)[place]])) for run, m in enumerate(motions)))
        for place in (0, -1)
    )
    assert against_patch(engine, near, ["external_push"]) > 4.0
    assert against_patch(engine, far, ["external_push"]) == 0.0


def test_wheels_begin_to_turn_where_commands_leave_zero_or_change_their_sign(drives):
    engine, values = drives
    motion, drive = _motion(engine, values, 1), engine.simulators[1].drive
    signs = np.sign(np.column_stack([drive.left, drive.right]))
    begun = drive.time[np.any((np.diff(signs, axis=0, prepend=0.0) != 0.0) & (signs != 0.0), axis=1)]
    least = motion.times[motion.apart <= 0.05]
    assert least.size
    assert np.all(np.min(np.abs(least[:, None] - begun), axis=1) < 0.4)


def test_the_density_of_patches_is_one():
    assert quad(density, 0.0, 1.0)[0] == pytest.approx(1.0, rel=1e-6)
