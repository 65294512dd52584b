"""A floor that is not level: a plane pulls alike everywhere, a hollow towards its deepest point."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_robots import recording

from fsm_calib.diagnosis.candidates.free_number import found_free
from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.recording.channels import PoseTrack
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameters
from fsm_calib.world2d.rollout import Drive, simulate

SAMPLES = np.arange(0.0, 6.0, 0.05)
CONSIDERED = ("floor_tilt", "carpet_nap", "rough_floor_patch", "coulomb_friction")
WITHOUT = [name for name in registry() if name not in CONSIDERED]


def rolled(x, y, **tilt):
    """Return by how much (2,) [m] a robot that looks along x rolls from (x, y) with its motors off."""
    vector = parameters({f"floor_tilt.{name}": value for name, value in tilt.items()})
    path = simulate(vector, Drive([0.0], [0.0], [0.0]), SAMPLES, (x, y, 0.0))
    return path[-1, :2] - (x, y)


def test_in_a_hollow_a_robot_rolls_to_the_middle_from_either_side():
    hollow = {"curve_x": 0.05, "curve_y": 0.05}
    assert rolled(1.0, 0.0, **hollow)[0] < -1e-3
    assert rolled(-1.0, 0.0, **hollow)[0] > 1e-3
    assert rolled(0.0, 0.0, **hollow) == pytest.approx([0.0, 0.0], abs=1e-9)


def test_a_floor_with_a_twist_rises_along_x_as_one_goes_along_y():
    assert rolled(0.0, 1.0, twist=0.05)[0] < -1e-3
    assert rolled(0.0, -1.0, twist=0.05)[0] > 1e-3


@pytest.mark.parametrize("curve_y", [0.01, 0.03])
def test_a_curved_floor_is_measured_and_has_no_name_since_a_cable_may_pull_so(curve_y):
    hidden = {"floor_tilt__slope_x": 0.01, "floor_tilt__curve_x": 0.03, "floor_tilt__curve_y": curve_y}
    found = diagnose([recording(seed, 30.0, **hidden) for seed in (1, 2)], without=WITHOUT)
    assert found.decision.outcome == "unexplained"
    (tilt,) = found.decision.model.beliefs
    assert (tilt.name, tilt.probability) == ("floor_tilt", pytest.approx(0.5, abs=0.05))
    for name, true in (("curve_x", 0.03), ("curve_y", curve_y)):
        ((_, number, sd),) = found_free(found.decision.model.fit, f"floor_tilt.{name}")
        assert number == pytest.approx(true, abs=3.0 * sd)


def test_a_plane_that_falls_alike_everywhere_keeps_its_name():
    hidden = {"floor_tilt__slope_x": 0.02, "floor_tilt__slope_y": -0.01}
    found = diagnose([recording(seed, 30.0, **hidden) for seed in (1, 2)], without=WITHOUT)
    (tilt,) = found.verdict.effects
    assert (tilt.name, tilt.closure) == ("floor_tilt", "plane")


def test_beyond_a_fold_a_robot_rolls_and_before_it_rests():
    fold = {"slope_x": 0.015, "fold": 0.03, "across": 0.0, "fold_at": 0.2}
    far, near = rolled(1.0, 0.5, **fold)[0], rolled(0.4, -0.5, **fold)[0]
    assert far < -1e-3
    assert far == pytest.approx(near)  # a plane: alike everywhere
    assert rolled(0.0, 0.0, **fold) == pytest.approx([0.0, 0.0], abs=1e-9)


def test_the_line_of_a_fold_lies_across_its_direction():
    level_before_it = {"slope_x": 0.015 * np.sqrt(0.5), "slope_y": 0.015 * np.sqrt(0.5)}
    fold = {**level_before_it, "fold": 0.03, "across": 0.25 * np.pi, "fold_at": 0.0}
    assert rolled(0.4, 0.0, **fold)[0] == pytest.approx(rolled(0.0, 0.4, **fold)[0]) != 0.0
    assert rolled(-0.4, 0.0, **fold) == pytest.approx([0.0, 0.0], abs=1e-9)


def test_a_folded_floor_is_named_with_its_line_since_no_cable_pulls_so():
    fold = {"slope_x": -0.01, "fold": 0.025, "across": 0.6, "fold_at": 0.1}
    hidden = {f"floor_tilt__{name}": value for name, value in fold.items()}
    found = diagnose([recording(seed, 30.0, **hidden) for seed in (1, 2)], without=WITHOUT)
    (tilt,) = found.verdict.effects
    assert (tilt.name, tilt.closure) == ("floor_tilt", "folded")
    assert tilt.confidence > 0.9
    assert tilt.parameters["fold"].value == pytest.approx(0.025, rel=0.15)
    assert tilt.parameters["fold_at"].value == pytest.approx(0.1, abs=0.03)


def elsewhere(told, x, y):
    """Return a recording whose map has its origin (x, y) [m] back from where it was."""
    pose = told.pose
    return replace(told, pose=PoseTrack(pose.time, pose.x + x, pose.y + y, pose.theta))


def test_a_ridge_is_found_where_the_map_has_its_origin_far_away():
    fold = {"fold": -0.025, "across": 0.6, "fold_at": 0.1}
    hidden = {f"floor_tilt__{name}": value for name, value in fold.items()}
    told = [elsewhere(recording(seed, 30.0, **hidden), 15.0, -3.0) for seed in (1, 2)]
    (tilt,) = diagnose(told, without=WITHOUT).verdict.effects
    assert (tilt.name, tilt.closure) == ("floor_tilt", "folded")
    numbers = {name: told.value for name, told in tilt.parameters.items()}
    side = 1.0 if np.cos(numbers["across"] - 0.6) > 0.0 else -1.0  # the line is the same from behind
    assert numbers["fold"] == pytest.approx(side * -0.025, rel=0.15)
    line = 0.1 + 15.0 * np.cos(0.6) - 3.0 * np.sin(0.6)
    assert numbers["fold_at"] == pytest.approx(side * line, abs=0.3)
