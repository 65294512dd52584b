"""A floor that is not level: a plane pulls alike everywhere, a hollow towards its deepest point."""

import numpy as np
import pytest
from diagnosis_robots import recording

from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.effects.floor_tilt import is_central, is_taut
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


def test_a_gutter_is_named_a_tilt_that_is_curved_and_its_curve_is_measured():
    hidden = {"floor_tilt__slope_x": 0.01, "floor_tilt__curve_x": 0.03, "floor_tilt__curve_y": 0.01}
    found = diagnose([recording(seed, 30.0, **hidden) for seed in (1, 2)], without=WITHOUT)
    (tilt,) = found.verdict.effects
    assert (tilt.name, tilt.closure) == ("floor_tilt", "curved")
    for name, true in (("curve_x", 0.03), ("curve_y", 0.01)):
        assert tilt.parameters[name].value == pytest.approx(true, abs=3.0 * tilt.parameters[name].sd)


def test_a_hollow_alike_on_all_sides_may_be_a_taut_cable_and_has_no_name():
    hidden = {"floor_tilt__slope_x": 0.01, "floor_tilt__curve_x": 0.03, "floor_tilt__curve_y": 0.03}
    found = diagnose([recording(seed, 30.0, **hidden) for seed in (1, 2)], without=WITHOUT)
    assert found.decision.outcome == "unexplained"
    assert found.decision.model.beliefs[0].name == "floor_tilt"
    assert found.decision.model.beliefs[0].probability == pytest.approx(0.5, abs=0.05)


@pytest.mark.parametrize(
    ("curve_x", "curve_y", "twist", "is_told"),
    [(0.04, 0.041, 0.0, False), (-0.02, -0.02, 0.001, False), (0.03, 0.0, 0.0, True), (0.0, 0.0, 0.01, True)],
)
def test_only_what_falls_alike_on_all_sides_is_what_a_spring_does(curve_x, curve_y, twist, is_told):
    assert is_central({"curve_x": curve_x, "curve_y": curve_y, "twist": twist}) is not is_told


def taut(at, slack, grown):
    """Return the numbers of a cable that is fixed at a place (2,), by differences of its pull about the origin."""

    def slope(x, y):
        away = np.array([x, y]) - at
        far = np.hypot(*away)
        return grown * max(far - slack, 0.0) * away / far

    step = 1e-4
    here, along_x, along_y = slope(0.0, 0.0), slope(step, 0.0), slope(0.0, step)
    curves = (along_x - here) / step, (along_y - here) / step
    return {
        "slope_x": here[0],
        "slope_y": here[1],
        "curve_x": curves[0][0],
        "curve_y": curves[1][1],
        "twist": curves[0][1],
    }


@pytest.mark.parametrize("angle", [0.0, 0.7, 2.5])
def test_what_a_taut_cable_does_has_no_name(angle):
    fixed = 2.0 * np.array([np.cos(angle), np.sin(angle)])
    assert is_taut(taut(fixed, 1.2, 0.02))


@pytest.mark.parametrize(
    ("slopes", "curves"),
    [
        ((0.0, 0.02), (0.03, 0.0, 0.0)),  # a gutter that falls along itself
        ((0.005, 0.0), (0.03, 0.0, 0.0)),  # one whose bottom is under the robot
        ((0.02, 0.0), (-0.03, 0.0, 0.0)),  # a slope that ends
        ((0.02, 0.0), (0.0, 0.0, 0.02)),  # a saddle
    ],
)
def test_other_floors_are_no_taut_cable(slopes, curves):
    names = ("slope_x", "slope_y", "curve_x", "curve_y", "twist")
    assert not is_taut(dict(zip(names, (*slopes, *curves), strict=True)))
