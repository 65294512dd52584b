"""Rows that somebody interpolated between measurements: known by lying on their chords, and dropped."""

import numpy as np
import pytest

from fsm_calib.recording.channels import PoseTrack
from fsm_calib.recording.interpolated_rows import knots_of, without_interpolated_rows
from fsm_calib.recording.recording import Recording

GRID = np.arange(0.0, 20.0, 0.01)


def measured(rate=8.0, seed=3, noise=0.002):
    """Return poses of a robot on a bent path, `rate` [Hz] times a second, with noise."""
    rng = np.random.default_rng(seed)
    time = np.sort(
        np.arange(0.0, 20.5, 1.0 / rate) + rng.uniform(0.0, 0.02, len(np.arange(0.0, 20.5, 1.0 / rate)))
    )
    theta = np.sin(0.7 * time)
    x, y = np.cumsum(0.3 * np.cos(theta)) / rate, np.cumsum(0.3 * np.sin(theta)) / rate
    off = noise * rng.normal(size=(3, len(time)))
    return PoseTrack(time, x + off[0], y + off[1], theta + 3.0 * off[2])


def on(grid, pose, digits=15):
    """Return the poses straight between those of `pose`, at other times."""
    columns = (np.round(np.interp(grid, pose.time, c), digits) for c in (pose.x, pose.y, pose.theta))
    return PoseTrack(grid, *columns)


def test_measurements_between_the_rows_of_a_finer_grid_are_found_again():
    pose = measured()
    knots = knots_of(on(GRID, pose))
    inside = (pose.time > 0.1) & (pose.time < 19.8)
    nearest = np.array([np.argmin(np.abs(knots.time - t)) for t in pose.time[inside]])
    assert knots.time[nearest] == pytest.approx(pose.time[inside], abs=2e-4)
    assert knots.x[nearest] == pytest.approx(pose.x[inside], abs=1e-4)
    assert knots.theta[nearest] == pytest.approx(pose.theta[inside], abs=1e-3)
    assert len(knots) <= inside.sum() + 8


def test_rows_of_five_digits_are_known_as_well():
    pose = measured()
    knots = knots_of(on(GRID, pose, digits=5))
    assert len(knots) == pytest.approx(len(pose), abs=8)


@pytest.mark.parametrize(
    ("pose", "why"),
    [
        (measured(rate=100.0), "each row is measured"),
        (on(GRID, measured(rate=100.0), digits=2), "few digits make chords of their own"),
        (PoseTrack(GRID, 0.3 * GRID, 0.0 * GRID, 0.0 * GRID), "a straight drive without noise"),
        (PoseTrack(GRID, np.sin(GRID), 1.0 - np.cos(GRID), GRID), "a circle without noise"),
        (on(GRID, measured(rate=1.0)), "a second between two measurements"),
    ],
)
def test_other_poses_stay(pose, why):
    assert knots_of(pose) is None, why


def test_the_recording_tells_what_was_dropped():
    recording = without_interpolated_rows(Recording(pose=on(GRID, measured())))
    assert len(recording.pose) < 200
    assert [f.kind for f in recording.checks] == ["interpolated"]
    assert "8.0 measurements a second" in recording.checks[0].sentence
