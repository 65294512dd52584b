"""Commands as they reach the motors: an edge that is there for the fit's sake, and shares beyond full command."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis_robots import GAIN_LEFT, engine_of, recording

from fsm_calib.diagnosis.candidates import beyond_full
from fsm_calib.diagnosis.candidates.beyond_full import CLEARLY, beyond_told, likelier_driven
from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis
from fsm_calib.diagnosis.candidates.plausible import passes_whole
from fsm_calib.diagnosis.candidates.ranked import Ranked
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.identify_in_world import identify_in_world
from fsm_calib.diagnosis.proof.gates import DEFAULT_GATES
from fsm_calib.diagnosis.replay.simulator import drive_of, full_speed
from fsm_calib.recording.channels import CommandTrack
from fsm_calib.world2d.parameters import parameter_table
from fsm_calib.world2d.rollout import Drive


@pytest.fixture(scope="module")
def robot():
    engine = engine_of(recording(0, 20.0))
    return engine, fit_base(engine)


def passes(robot, number, value, left, right):
    """Return whether a threshold passes whole what a robot is driven by, each pair of commands for a second."""
    engine, base = robot
    values = base.values.copy()
    values[:, parameter_table().place(f"motor_deadband.{number}")] = value
    form = Ranked(Hypothesis("motor_deadband", (number,)), replace(base, values=values), 100.0, 60.0)
    drive = Drive(np.arange(float(len(left))), np.asarray(left), np.asarray(right))
    return passes_whole(form, [replace(engine.simulators[0], drive=drive)])


LEVELS = [0.17, -0.255, 0.34, 0.0]


@pytest.mark.parametrize(
    ("threshold", "whole"), [(0.2, True), (0.2547, False), (0.2580, False), (0.2598, True), (0.3, True)]
)
def test_a_threshold_that_lets_part_of_a_level_through_is_none(robot, threshold, whole):
    assert passes(robot, "threshold", threshold, LEVELS, LEVELS) is whole


def test_commands_of_every_size_may_cross_an_edge(robot):
    ramp = np.linspace(-0.5, 0.5, 101)
    assert passes(robot, "threshold", 0.2547, ramp, ramp)


def test_an_edge_of_one_wheel_asks_that_wheel_alone(robot):
    other = [0.17, 0.17, 0.34, 0.0]
    assert not passes(robot, "threshold_left", 0.2547, LEVELS, other)
    assert passes(robot, "threshold_right", 0.2547, LEVELS, other)


def test_a_number_without_an_edge_passes_whole(robot):
    assert passes(robot, "offset", 0.255, LEVELS, LEVELS)


def test_what_is_asked_beyond_full_command_is_driven_by_full_command():
    drive = recording(0, 20.0)
    track = CommandTrack(np.arange(4.0), np.array([0.0, 1.2, -1.1, 0.4]), np.array([0.3, 1.0, 0.2, -1.3]))
    driven, measured = drive_of(replace(drive, command=track), full_speed(drive))
    assert driven.left.tolist() == [0.0, 1.0, -1.0, 0.4]
    assert driven.right.tolist() == [0.3, 1.0, 0.2, -1.0]
    assert not measured


@pytest.mark.parametrize(("most", "followed"), [(1.0, False), (np.inf, True)])
def test_what_is_asked_beyond_full_command_drives_the_robot_that_follows_it(most, followed):
    simulators = engine_of(*(recording(seed, 20.0, asked=2.6, most=most) for seed in (0, 1))).simulators
    driven, new = likelier_driven(simulators, simulators[:1])
    largest = [np.abs([s.drive.left, s.drive.right]).max() for s in (driven[1], new[0])]
    assert largest == pytest.approx([1.2810, 1.2138] if followed else [1.0, 1.0], abs=1e-3)
    assert bool(beyond_told(driven)) is followed


@pytest.mark.parametrize(
    ("plain", "whole", "followed"),
    [(5.0, 30.0, True), (5.0, 5.0, False), (30.0, 0.0, True), (-30.0, 30.0, False)],
)
def test_where_the_plain_base_robot_leaves_it_open_the_whole_one_decides(monkeypatch, plain, whole, followed):
    def winning(units):
        return lambda engine, *further: SimpleNamespace(score=0.0 if engine.simulators[0].cut else units)

    monkeypatch.setattr(beyond_full, "fit_base", winning(plain))
    monkeypatch.setattr(beyond_full, "fit_whole_base", winning(whole))
    driven, _ = likelier_driven(engine_of(recording(0, 20.0, asked=2.6)).simulators, ())
    assert driven[0].cut is not followed


def test_uncut_drives_must_win_the_evidence_that_an_effect_needs():
    assert DEFAULT_GATES.detect == 2.0 * CLEARLY


def test_drives_within_full_command_are_left_as_they_are():
    simulators = engine_of(*(recording(seed, 20.0) for seed in (0, 1))).simulators
    driven, new = likelier_driven(simulators, ())
    assert driven == simulators
    assert new == ()
    assert beyond_told(driven) == []


@pytest.mark.parametrize("most", [1.0, np.inf])
def test_a_robot_is_identified_by_what_drives_it(most):
    """Of 0.66 m/s 0.68 would be found cut, of the robot that follows; 0.64 uncut, of the one that does not."""
    found = identify_in_world([recording(seed, 20.0, asked=2.6, most=most) for seed in (0, 1)], {})
    assert found.estimates["speed_at_full_left"].value == pytest.approx(GAIN_LEFT, rel=0.005)
    assert any("they are not cut" in note for note in found.notes) is (most > 1.0)
