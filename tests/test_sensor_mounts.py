"""Sensors whose mounts give way, sway or see a heading wrong by the view: their laws, and found in recordings."""

import numpy as np
import pytest
from diagnosis_robots import recording, robot

from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.observation import observe, smoothed
from fsm_calib.world2d.parameters import parameters

CONSIDERED = ("sensor_offset", "sensor_yaw", "misplaced_marker", "lateral_slip", "coulomb_friction")
WITHOUT = [name for name in registry() if name not in CONSIDERED]


def seen(times, poses, **numbers):
    """Return what a sensor reports of poses (n, 3) at times (n,) [s], with the numbers of one effect."""
    return observe(robot(**numbers), np.asarray(times, dtype=float), np.asarray(poses, dtype=float))


def named(**hidden):
    """Return the one effect that a diagnosis of two recordings names."""
    found = diagnose([recording(seed, 30.0, **hidden) for seed in (1, 2)], without=WITHOUT)
    (effect,) = found.verdict.effects
    return effect


def test_a_mount_that_gives_way_begins_short_of_its_place_and_reaches_it():
    creeping = {"sensor_offset__x": 0.04, "sensor_offset__creep": 0.5, "sensor_offset__settle": 10.0}
    x = seen([0.0, 10.0, 1e3], np.zeros((3, 3)), **creeping)[:, 0]
    assert x == pytest.approx([0.02, 0.04 * (1.0 - 0.5 / np.e), 0.04])


def test_a_plate_that_works_loose_turns_as_its_time_goes():
    loose = {"sensor_yaw__yaw": 0.1, "sensor_yaw__creep": -0.5, "sensor_yaw__settle": 10.0}
    heading = seen([0.0, 1e3], np.zeros((2, 3)), **loose)[:, 2]
    assert heading == pytest.approx([0.15, 0.1])


def test_on_a_circle_a_mast_leans_outwards_by_the_centripetal_acceleration():
    radius, rate, sway = 0.5, 2.0, 0.01
    times = np.arange(0.0, 4.0, 0.01)
    turned = rate * times
    circle = np.column_stack([radius * np.cos(turned), radius * np.sin(turned), turned])
    vector = parameters({"sensor_offset.x": 0.03, "sensor_offset.sway": sway})
    far = np.hypot(*smoothed(vector, times, circle)[:, :2].T)[5:-5]
    assert far == pytest.approx(radius * (1.0 + sway * rate**2), rel=1e-4)


def test_a_foreshortened_view_turns_headings_as_a_stretched_picture_does():
    swing = 0.01
    theta = np.linspace(-3.0, 3.0, 31)
    poses = np.column_stack([np.zeros((31, 2)), theta])
    stretched = np.unwrap(np.arctan2((1.0 + 2.0 * swing) * np.sin(theta), np.cos(theta)))
    told = seen(np.zeros(31), poses, sensor_yaw__yaw=1e-9, sensor_yaw__swing=swing)[:, 2]
    assert told - theta == pytest.approx(stretched - theta, abs=2.0 * swing**2)


def test_a_tilted_tag_is_off_once_a_turn():
    theta = np.linspace(-3.0, 3.0, 31)
    poses = np.column_stack([np.zeros((31, 2)), theta])
    tilted = {"sensor_yaw__yaw": 0.05, "sensor_yaw__swing": 0.01, "sensor_yaw__folds": 1.0}
    off = seen(np.zeros(31), poses, **tilted)[:, 2] - theta
    assert off == pytest.approx(0.05 + 0.01 * np.sin(theta))


def test_a_creeping_tape_is_told_from_a_tag_that_stays():
    offset = named(sensor_offset__x=0.04, sensor_offset__creep=0.6, sensor_offset__settle=15.0)
    assert (offset.name, offset.closure) == ("sensor_offset", "creeping")
    assert offset.parameters["x"].value == pytest.approx(0.04, abs=0.004)
    assert offset.parameters["creep"].value == pytest.approx(0.6, abs=0.12)


def test_a_swaying_mast_is_told_from_a_stiff_one():
    offset = named(sensor_offset__x=0.05, sensor_offset__y=-0.03, sensor_offset__sway=0.02)
    assert (offset.name, offset.closure) == ("sensor_offset", "on a mast")
    assert offset.parameters["sway"].value == pytest.approx(0.02, rel=0.25)


def test_a_tag_that_stays_keeps_the_plain_closure():
    offset = named(sensor_offset__x=0.03, sensor_offset__y=-0.02)
    assert (offset.name, offset.closure) == ("sensor_offset", "full")


@pytest.mark.parametrize(("closure", "folds"), [("foreshortened", 2.0), ("tilted", 1.0)])
def test_a_heading_that_swings_with_the_view_is_measured(closure, folds):
    yaw = named(
        sensor_yaw__yaw=0.06, sensor_yaw__swing=0.02, sensor_yaw__towards=0.7, sensor_yaw__folds=folds
    )
    assert (yaw.name, yaw.closure) == ("sensor_yaw", closure)
    assert yaw.parameters["yaw"].value == pytest.approx(0.06, abs=0.004)
    assert abs(yaw.parameters["swing"].value) == pytest.approx(0.02, abs=0.004)
