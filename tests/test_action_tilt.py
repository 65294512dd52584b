"""How the camera sits over the floor, from the markers of the first frames: what counts, and what is left alone."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from fsm_calib.actions import Bench, markers
from fsm_calib.actions.markers import found_in
from fsm_calib.errors import DataError
from fsm_calib.types import CameraMount, Frame

FRAME = Frame(np.zeros((4, 4), dtype=np.uint8), 0.0, 0)


@pytest.fixture
def bench() -> Bench:
    return Bench(object())  # type: ignore[arg-type]


def shown(monkeypatch: pytest.MonkeyPatch, rows: list[float], *tilts: object) -> list[list[float]]:
    """Let a frame show tags at these image rows, and each fit of the tilt end so; return what each fit was given."""
    tags = [SimpleNamespace(tag_id=i, corners_image=np.full((4, 2), row)) for i, row in enumerate(rows)]
    left, given = list(tilts), []

    def estimate(near: list, camera: object, size: float) -> object:
        given.append([float(tag.corners_image[0, 1]) for tag in near])
        answer = left.pop(0)
        if isinstance(answer, Exception):
            raise answer
        return SimpleNamespace(**dict(zip(("pitch", "roll", "height"), answer, strict=True)))

    monkeypatch.setattr(markers, "find_tags", lambda image: tuple(tags))
    monkeypatch.setattr(markers, "estimate_tilt", estimate)
    return given


def test_the_six_nearest_markers_tell_the_tilt(bench: Bench, monkeypatch) -> None:
    given = shown(monkeypatch, [10.0, 80.0, 20.0, 70.0, 30.0, 60.0, 40.0, 50.0], (0.3, 0.02, 0.11))
    found_in(bench, FRAME)
    assert given == [[80.0, 70.0, 60.0, 50.0, 40.0, 30.0]]
    mount = bench.notebook.mount
    assert (mount.pitch, mount.roll, mount.height) == (0.3, 0.02, 0.11)


@pytest.mark.parametrize(("count", "readings"), [(3, 0), (4, 1)])
def test_three_markers_are_too_few(bench: Bench, monkeypatch, count: int, readings: int) -> None:
    shown(monkeypatch, [10.0 * row for row in range(count)], (0.3, 0.02, 0.11))
    found_in(bench, FRAME)
    assert len(bench.notebook.tilt_readings) == readings


def test_markers_that_agree_on_no_floor_leave_the_mount_alone(bench: Bench, monkeypatch) -> None:
    shown(monkeypatch, [10.0] * 4, DataError("no floor"))
    found_in(bench, FRAME)
    assert bench.notebook.mount == CameraMount()
    assert bench.notebook.tilt_readings == []


def test_the_median_of_the_readings_counts_and_no_more_are_taken_than_asked_for(
    bench: Bench, monkeypatch
) -> None:
    asked = bench.settings.marker.tilt_readings
    readings = [(0.30, 0.01, 0.110), (0.34, 0.03, 0.112), (0.31, 0.02, 0.111)] + [(0.31, 0.02, 0.111)] * 9
    given = shown(monkeypatch, [10.0] * 4, *readings)
    for _ in range(asked + 2):
        found_in(bench, FRAME)
    assert len(given) == asked
    assert bench.notebook.mount.pitch == pytest.approx(0.31)


def test_where_boards_told_the_tilt_markers_tell_the_height_alone(bench: Bench, monkeypatch) -> None:
    bench.notebook.mount_known = "tilt"
    shown(monkeypatch, [10.0] * 4, (0.3, 0.02, 0.13))
    found_in(bench, FRAME)
    assert bench.notebook.mount == CameraMount(height=0.13)


def test_where_boards_told_all_markers_are_not_asked(bench: Bench, monkeypatch) -> None:
    bench.notebook.mount_known = "all"
    assert shown(monkeypatch, [10.0] * 4) == []
    found_in(bench, FRAME)
    assert bench.notebook.mount == CameraMount()


def test_the_corners_of_a_frames_tags_are_kept_for_the_report(bench: Bench, monkeypatch) -> None:
    shown(monkeypatch, [10.0, 20.0])
    found_in(bench, FRAME)
    assert bench.frames[0].points_image.shape == (8, 2)


def test_a_frame_without_tags_is_kept_with_no_points(bench: Bench, monkeypatch) -> None:
    shown(monkeypatch, [])
    assert found_in(bench, FRAME) == ()
    assert bench.frames[0].points_image.shape == (0, 2)
