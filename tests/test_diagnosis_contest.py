"""A name against shapes without a name: forms, their lag, and the contest that a name has to win."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_robots import engine_of, recording

from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis
from fsm_calib.diagnosis.candidates.plausible import (
    has_size,
    is_crossed,
    is_plausible,
    is_seen,
    lasts,
    plausible_of,
    stays_in,
)
from fsm_calib.diagnosis.candidates.polish import polished
from fsm_calib.diagnosis.candidates.ranked import Ranked
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.fitting.base import fit_base, noise_names, slot_of
from fsm_calib.diagnosis.fitting.fit import Engine, jacobian
from fsm_calib.diagnosis.fitting.values import switched_off, with_values
from fsm_calib.diagnosis.proof.form_test import Linear, Remainder, contest
from fsm_calib.diagnosis.replay.prepared import prepare
from fsm_calib.diagnosis.replay.simulator import make_simulator
from fsm_calib.diagnosis.shapes.form_frame import frames_of, lagged
from fsm_calib.diagnosis.shapes.forms import RECIPES, forms
from fsm_calib.diagnosis.shapes.wheel_response import driven
from fsm_calib.recording.channels import PoseTrack
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table


def fitted(name, **changes):
    engine = engine_of(*(recording(seed, **changes) for seed in (0, 1)))
    base = fit_base(engine)
    (ranked,) = Bank.on(engine, base).rank([registry()[name]])
    return engine, base, polished(engine, ranked, base, noise_names(engine.simulators)).fit


@pytest.fixture(scope="module")
def saturated():
    return fitted("command_saturation", command_saturation__limit=0.3)


def test_the_lag_answers_a_step_exponentially():
    dt = np.full(40, 0.05)
    answer = lagged(np.ones((40, 1)), dt, 0.2)[:, 0]
    assert answer == pytest.approx(1.0 - np.exp(-np.cumsum(dt) / 0.2), abs=1e-12)


def test_every_form_has_finite_columns_for_each_recording(saturated):
    engine, _, fit = saturated
    found = list(forms(frames_of(engine.simulators, fit)))
    assert [f.quantity for f in found] == list(RECIPES)
    for form in found:
        assert [c.shape[0] for c in form.columns] == [len(s.prepared.time) for s in engine.simulators]
        assert all(np.isfinite(c).all() for c in form.columns)


def test_forms_of_the_sensor_leave_the_wheels_alone(saturated):
    engine, _, fit = saturated
    mount = next(f for f in forms(frames_of(engine.simulators, fit)) if f.quantity == "where the sensor sits")
    assert not mount.columns[0][:, 3:].any()


def test_a_right_name_wins(saturated):
    engine, base, fit = saturated
    found = contest(Remainder.of(engine, fit), base, ["command_saturation"])
    assert found.explained > 100.0
    assert max(found.beside, found.instead) < 0.02 * found.explained


def test_a_neighbour_of_the_truth_loses():
    engine, base, fit = fitted("motor_gain_curve", command_saturation__limit=0.3)
    found = contest(Remainder.of(engine, fit), base, ["motor_gain_curve"])
    assert max(found.beside, found.instead) > 0.05 * found.explained
    assert "the command's size" in found.instead_quantities + found.beside_quantities


@pytest.mark.parametrize(("delay", "has_a_form"), [(0.0015, False), (0.03, True)])
def test_late_by_a_millisecond_is_no_form_and_late_by_thirty_is(delay, has_a_form):
    drives = [recording(seed, noise=0.1, observation_delay__delay=delay) for seed in (0, 1)]
    engine = engine_of(*drives)
    left = Remainder.of(engine, fit_base(engine))
    assert (left.beside > 0.0) == has_a_form


def test_play_in_the_gears_is_no_delay():
    engine, base, fit = fitted("command_delay", gear_backlash__gap=0.2)
    found = contest(Remainder.of(engine, fit), base, ["command_delay"])
    assert found.explained > 100.0
    assert found.beside > 0.05 * found.explained
    assert "which way the motors push" in found.beside_quantities


def test_a_slide_that_carries_the_base_robot_far_is_not_replaced():
    spot = {"x": 0.12, "y": 0.05, "radius": 0.25, "loss": 0.8}
    numbers = {f"low_friction_patch__{name}": value for name, value in spot.items()}
    engine, base, fit = fitted("low_friction_patch", **numbers)
    found = contest(Remainder.of(engine, fit), base, ["low_friction_patch"])
    assert found.instead < -0.3 * found.explained


def test_a_place_that_covers_the_floor_or_is_hardly_touched_is_none():
    engine, base, _ = fitted("motor_deadband", motor_deadband__offset=0.04)
    table = parameter_table()
    values, places = base.values.copy(), [f"rough_floor_patch.{n}" for n in ("half_x", "half_y")]
    values[:, [table.place(n) for n in places]] = 5.0
    wide = Ranked(Hypothesis("rough_floor_patch", ("drag",)), replace(base, values=values), 100.0, 60.0)
    values = values.copy()
    values[:, table.place(places[0])] = 0.1
    narrow = replace(wide, fit=replace(base, values=values))
    values = values.copy()
    values[:, table.place("rough_floor_patch.x")] = 30.0
    beside = replace(wide, fit=replace(base, values=values))
    assert not is_plausible(wide, engine.simulators)
    assert is_plausible(narrow, engine.simulators)
    assert not is_plausible(beside, engine.simulators)


def test_stays_in_a_place_are_told_apart():
    inside = np.array([False, True, True, False, False, True, False, True])
    assert stays_in(inside, np.full(8, 0.1)) == pytest.approx([0.2, 0.1, 0.1])
    assert stays_in(np.zeros(3, dtype=bool), np.ones(3)) == []


@pytest.mark.parametrize(("radius", "holds"), [(0.03, False), (0.25, True)])
def test_a_place_crossed_once_for_a_moment_is_none(radius, holds):
    engine = engine_of(recording(0, duration=12.0))
    base = fit_base(engine)
    path = engine.simulators[0].prepared.reference
    values, corner = base.values.copy(), path[int(np.argmax(np.hypot(*(path[:, :2] - path[0, :2]).T)))]
    numbers = {"x": corner[0], "y": corner[1], "radius": radius, "turn": 0.1}
    for name, number in numbers.items():
        values[:, parameter_table().place(f"misplaced_marker.{name}")] = number
    marker = Ranked(Hypothesis("misplaced_marker", ("turn",)), replace(base, values=values), 100.0, 60.0)
    assert is_crossed(marker, engine.simulators) is holds


@pytest.mark.parametrize(
    ("effect", "radius", "holds"),
    [
        ("misplaced_marker", 0.9, True),
        ("rough_floor_patch", 0.9, False),
        ("misplaced_marker", 1.2, False),
    ],
)
def test_most_of_the_floor_is_a_place_only_where_poses_jump_at_its_edge(effect, radius, holds):
    """The drive stays within 1.2 m of its start, for three quarters of its time within 0.9 m."""
    engine = engine_of(recording(0))
    base = fit_base(engine)
    sizes = {"radius": radius} if effect == "misplaced_marker" else {"half_x": radius, "half_y": radius}
    values = with_values(base.values, {f"{effect}.{n}": v for n, v in {"x": 0.0, "y": 0.0, **sizes}.items()})
    place = Ranked(Hypothesis(effect, ("x",)), replace(base, values=values), 100.0, 60.0)
    assert is_crossed(place, engine.simulators) is holds


def at_value(fit, effect, name, value):
    values = fit.values.copy()
    values[:, parameter_table().place(f"{effect}.{name}")] = value
    return Ranked(Hypothesis(effect, (name,)), replace(fit, values=values), 100.0, 60.0)


@pytest.mark.parametrize(
    ("effect", "name", "value", "holds"),
    [
        ("motor_warmup", "change_left", -0.35, False),
        ("motor_warmup", "change_left", -0.3, True),
        ("motor_warmup", "effort", 3.0, False),  # nothing warms within a moment
        ("motor_warmup", "effort", 4.0, True),
        ("motor_warmup", "effort", 120.0, True),  # a slow one is a straight line
        ("motor_fault", "loss_left", 1.0, True),  # a dead motor is where nature ends
        ("motor_fault", "loss_left", -0.5, False),  # no motor gains a half by a fault
        ("coulomb_friction", "friction", 0.0, True),  # at rest at nothing at all
        ("command_delay", "delay", 0.003, False),  # tyres are as late
        ("command_delay", "delay", 0.005, True),
        ("observation_delay", "delay", -0.003, False),
    ],
)
def test_a_size_at_its_bound_or_too_small_to_be_told_is_none(saturated, effect, name, value, holds):
    _, base, _ = saturated
    assert has_size(at_value(base, effect, name, value)) is holds


def test_a_form_that_is_no_finding_gives_way_to_another_of_its_effect(saturated):
    engine, base, _ = saturated
    ends_late = at_value(base, "command_saturation", "voltage", 1.2)
    limited = at_value(base, "command_saturation", "current", 0.16)
    assert plausible_of([ends_late, limited], engine.simulators) == [limited]
    assert plausible_of([ends_late], engine.simulators) == [ends_late]


@pytest.mark.parametrize(("smoothing", "holds"), [(0.002, False), (0.05, True)])
def test_one_of_two_sizes_is_enough_for_both(saturated, smoothing, holds):
    _, base, _ = saturated
    filtered = at_value(base, "observation_delay", "smoothing", smoothing)
    both = replace(filtered, hypothesis=Hypothesis("observation_delay", ("delay", "smoothing")))
    assert has_size(both) is holds


@pytest.mark.parametrize(("duration", "holds"), [(0.7, False), (6.0, True), (60.0, False)])
def test_a_fault_as_short_as_a_push_or_as_long_as_the_drive_is_none(saturated, duration, holds):
    engine, base, _ = saturated
    assert lasts(at_value(base, "motor_fault", "duration", duration), engine.simulators) is holds


@pytest.mark.parametrize(("start", "holds"), [(12.0, True), (20.5, False), (38.5, False)])
def test_a_push_must_be_seen_by_the_poses(start, holds):
    drive = recording(0)
    looking = (drive.pose.time < 20.0) | (drive.pose.time > 21.0)
    channels = (drive.pose.time, drive.pose.x, drive.pose.y, drive.pose.theta)
    gapped = replace(drive, pose=PoseTrack(*(channel[looking] for channel in channels)))
    engine = engine_of(gapped)
    push = at_value(fit_base(engine), "external_push", "start", start)
    assert is_seen(push, engine.simulators) is holds


def test_a_fault_may_begin_unseen(saturated):
    engine, base, _ = saturated
    assert is_seen(at_value(base, "motor_fault", "duration", 6.0), engine.simulators)


def test_switching_off_takes_strengths_alone(saturated):
    _, _, fit = saturated
    table = parameter_table()
    off = switched_off(fit.values, ["command_saturation"])
    changed = {table.owner[i] for i in np.flatnonzero((off != fit.values).any(axis=0))}
    assert changed == {"command_saturation"}


def test_the_linear_model_finds_the_least_squares_solution():
    rng = np.random.default_rng(0)
    columns = rng.normal(size=(500, 3)) * [1.0, 10.0, 0.1]
    truth = np.array([0.3, -0.02, 2.0])
    model = Linear(columns @ truth, columns, np.zeros(3), np.zeros(3), 1e6)
    left, _, _ = model.solved()
    assert np.abs(left).max() < 1e-5


def test_a_prior_holds_a_number_that_the_data_do_not_know():
    column = np.full((10, 1), 1e-6)
    model = Linear(np.full(10, 1.0), column, np.array([0.2]), np.array([0.1]), 1e6)
    _, _, score = model.solved()
    without = Linear(np.full(10, 1.0), column, np.array([0.0]), np.array([0.1]), 1e6).solved()[2]
    assert score == pytest.approx(without, abs=1e-3)


def test_more_drive_in_the_command_is_more_gain():
    simulator = make_simulator(prepare(recording(0)))
    engine = Engine((simulator,))
    base = fit_base(engine)
    (gain,) = jacobian((simulator,), base.values, [slot_of("gain_left")], base.simulated)
    held = np.searchsorted(simulator.drive.time, simulator.prepared.time - 1e-9, side="right") - 1
    command = np.where(held >= 0, simulator.drive.left[np.maximum(held, 0)], 0.0)[:, None]
    # commands change between events, so that shapes of the command are early or late by part of an interval there
    column = driven(simulator, base.values[0], simulator.full_speed * command, np.zeros_like(command))
    expected = base.values[0, parameter_table().place("gain_left")] * gain[:, :, 0]
    travelled = np.cumsum(column[:, 0, 0]), np.cumsum(expected[:, 0])
    assert np.abs(travelled[0] - travelled[1]).max() < 0.03 * np.abs(travelled[1]).max()


def test_limits_of_the_command_do_not_hide_a_shape():
    simulator = make_simulator(prepare(recording(0)))
    values = fit_base(Engine((simulator,))).values[0]
    limited = values.copy()
    limited[parameter_table().place("command_saturation.limit")] = 0.1
    shape = np.full((len(simulator.prepared.time), 1), 0.05)
    assert np.array_equal(driven(simulator, limited, shape, shape), driven(simulator, values, shape, shape))


def test_a_marker_without_its_name_is_no_push():
    marker = {"turn": 0.12, "x": 0.15, "y": 0.0, "radius": 0.2}
    engine, base, fit = fitted("external_push", **{f"misplaced_marker__{k}": v for k, v in marker.items()})
    found = contest(Remainder.of(engine, fit), base, ["external_push"])
    assert found.beside > 0.05 * found.explained
    assert found.beside_quantities == ("the pose's jumps at a place",)
