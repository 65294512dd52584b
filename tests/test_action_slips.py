"""What each small step of an action asks of the robot, in order: the stop at the end, the wait until it stands, the
comparisons that pick a marker or a board.
"""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from fsm_calib.actions import Bench, boards, focusing, leaving, markers
from fsm_calib.actions.boards import SAME_BOARD_WITHIN, Sighting, beyond, first_of, followed
from fsm_calib.actions.held_up import DRIVE_BLOCKED
from fsm_calib.actions.leaving import drive_off, hand_over
from fsm_calib.actions.looking import FRAME_FROZEN, FRAME_MISSING, look
from fsm_calib.actions.markers import MARKER_MISSED, heading_of, heading_sd, read_markers
from fsm_calib.actions.moving import CLOCKWISE, COUNTERCLOCKWISE, drive, push, run_wheels
from fsm_calib.actions.notebook import MarkerReading
from fsm_calib.actions.stopping import stop_wheels
from fsm_calib.types import STOP, Frame, TagObservation, WheelCommand


class Tape:
    """A robot that writes down what it was asked."""

    def __init__(self) -> None:
        self.asked: list[tuple] = []
        self.time = 3.0

    def command(self, command: WheelCommand) -> None:
        self.asked.append(("command", command))

    def wait(self, duration: float) -> None:
        self.asked.append(("wait", duration))

    def run(self, command: WheelCommand, duration: float) -> None:
        self.asked.append(("run", command, duration))

    def now(self) -> float:
        return self.time

    def capture(self) -> Frame | None:
        return None


@pytest.fixture
def bench() -> Bench:
    return Bench(Tape())


def test_stopping_commands_zero_and_then_waits_until_the_robot_stands(bench: Bench) -> None:
    outcome = stop_wheels(bench)
    assert bench.robot.asked == [("command", STOP), ("wait", bench.settings.drive.settle)]
    assert outcome.trigger == "wheels_stopped"


def test_a_wheel_run_is_followed_by_its_settling_time(bench: Bench) -> None:
    run_wheels(bench, WheelCommand(0.3, 0.2), 0.5, 0.25)
    assert bench.robot.asked == [("run", WheelCommand(0.3, 0.2), 0.5), ("wait", 0.25)]


@pytest.mark.parametrize(
    ("way", "reverse", "sign"),
    [(CLOCKWISE, False, 1.0), (CLOCKWISE, True, -1.0), (COUNTERCLOCKWISE, False, -1.0), (COUNTERCLOCKWISE, True, 1.0)],
)  # fmt: skip
def test_a_push_turns_by_the_left_wheel_alone(bench: Bench, way: str, reverse: bool, sign: float) -> None:
    push(bench, way, 0.4, reverse=reverse)
    turn = bench.settings.turn
    assert bench.robot.asked == [("run", WheelCommand(0.4 * sign, 0.0), turn.quantum), ("wait", turn.settle)]


@pytest.mark.parametrize(("backward", "sign"), [(False, 1.0), (True, -1.0)])
def test_a_drive_gives_the_right_wheel_the_ratio_and_waits(bench: Bench, backward: bool, sign: float) -> None:
    drive(bench, 2.0, 1.1, backward=backward)
    left = sign * bench.settings.drive.command
    assert bench.robot.asked == [
        ("run", WheelCommand(left, left * 1.1), 2.0),
        ("wait", bench.settings.drive.settle),
    ]
    bench.notebook.drive_command = 0.21
    drive(bench, 1.0, 1.0)
    assert bench.robot.asked[-2] == ("run", WheelCommand(0.21, 0.21), 1.0)


def tag(number: int, distance: float, heading: float = 0.0, **more: float) -> TagObservation:
    return TagObservation(number, distance, 0.01 * number, heading, distance, **more)


def shown(monkeypatch: pytest.MonkeyPatch, *frames: object) -> None:
    """Let the markers of these frames be seen, one after the other."""
    left = list(frames)
    monkeypatch.setattr(markers, "look_at_markers", lambda bench: left.pop(0))


def test_markers_are_read_over_frames_with_a_wait_between_them_only(bench: Bench, monkeypatch) -> None:
    count = bench.settings.marker.frames
    shown(monkeypatch, *[(tag(1, 0.3),)] * count)
    reading = read_markers(bench)
    assert isinstance(reading, MarkerReading)
    assert bench.robot.asked == [("wait", bench.settings.turn.quantum)] * (count - 1)
    assert reading.time == 3.0


def test_the_nearest_marker_is_first_and_gives_the_heading(bench: Bench, monkeypatch) -> None:
    frame = (tag(1, 0.40, 0.5), tag(2, 0.25, -0.2), tag(3, 0.30, 0.9))
    shown(monkeypatch, *[frame] * bench.settings.marker.frames)
    reading = read_markers(bench)
    assert [seen.tag_id for seen in reading.tags] == [2, 3, 1]
    assert reading.heading == pytest.approx(-0.2)


def test_a_marker_at_the_farthest_distance_counts_and_one_beyond_does_not(bench: Bench, monkeypatch) -> None:
    farthest = bench.settings.marker.farthest
    frame = (tag(1, farthest), tag(2, farthest + 1e-6))
    shown(monkeypatch, *[frame] * bench.settings.marker.frames)
    assert [seen.tag_id for seen in read_markers(bench).tags] == [1]


def test_a_marker_needs_half_of_the_frames(bench: Bench, monkeypatch) -> None:
    bench.settings = replace(bench.settings, marker=replace(bench.settings.marker, frames=4))
    shown(monkeypatch, (tag(1, 0.3), tag(2, 0.2)), (tag(1, 0.3),), (), ())
    assert [seen.tag_id for seen in read_markers(bench).tags] == [1]


def test_a_look_at_the_markers_returns_those_of_its_frame(bench: Bench, monkeypatch) -> None:
    frame, seen = Frame(np.zeros((4, 4), dtype=np.uint8), 0.0, 7), (tag(1, 0.3),)
    monkeypatch.setattr(markers, "look", lambda bench: frame)
    monkeypatch.setattr(markers, "tags_in", lambda bench, given: seen if given is frame else ())
    assert markers.look_at_markers(bench) == seen
    monkeypatch.setattr(markers, "look", lambda bench: FRAME_MISSING)
    assert markers.look_at_markers(bench) is FRAME_MISSING


def test_no_marker_and_a_lost_frame_are_told(bench: Bench, monkeypatch) -> None:
    shown(monkeypatch, *[()] * bench.settings.marker.frames)
    assert read_markers(bench) is MARKER_MISSED
    shown(monkeypatch, *[FRAME_MISSING] * bench.settings.marker.frames)
    assert read_markers(bench) is FRAME_MISSING


def test_a_frame_that_does_not_come_is_done_without(bench: Bench, monkeypatch) -> None:
    bench.settings = replace(bench.settings, marker=replace(bench.settings.marker, frames=3))
    shown(monkeypatch, FRAME_MISSING, (tag(1, 0.30),), (tag(1, 0.32),))
    (seen,) = read_markers(bench).tags
    assert seen.distance == pytest.approx(0.31)


def test_after_a_frozen_frame_the_ones_before_it_are_not_trusted(bench: Bench, monkeypatch) -> None:
    bench.settings = replace(bench.settings, marker=replace(bench.settings.marker, frames=3))
    shown(monkeypatch, (tag(1, 0.3),), (tag(1, 0.3),), FRAME_FROZEN)
    assert read_markers(bench) is FRAME_FROZEN


def test_readings_over_frames_are_medians_and_headings_do_not_wrap(bench: Bench, monkeypatch) -> None:
    bench.settings = replace(bench.settings, marker=replace(bench.settings.marker, frames=3))
    headings = (math.pi - 0.01, -math.pi + 0.02, math.pi - 0.03)
    shown(monkeypatch, *[(tag(1, d, h),) for d, h in zip((0.3, 0.31, 0.4), headings, strict=True)])
    (seen,) = read_markers(bench).tags
    assert seen.distance == 0.31
    assert math.remainder(seen.heading - (math.pi - 0.01), math.tau) == pytest.approx(0.0, abs=1e-9)


def test_a_median_heading_is_taken_about_the_first_frame_s(bench: Bench, monkeypatch) -> None:
    bench.settings = replace(bench.settings, marker=replace(bench.settings.marker, frames=3))
    shown(monkeypatch, *[(tag(1, 0.3, heading),) for heading in (0.10, 0.13, 0.16)])
    (seen,) = read_markers(bench).tags
    assert seen.heading == pytest.approx(0.13)


def test_the_published_rules_take_the_last_marker_and_the_camera_s_heading(bench: Bench) -> None:
    tags = (tag(5, 0.2, 0.1, heading_camera=0.3), tag(9, 0.4, 0.5, heading_camera=0.7))
    assert heading_of(bench, tags) == 0.1
    bench.settings = replace(bench.settings, marker=replace(bench.settings.marker, nearest="last"))
    assert heading_of(bench, tags) == 0.5
    bench.settings = replace(bench.settings, marker=replace(bench.settings.marker, heading="camera"))
    assert heading_of(bench, tags) == 0.7


def test_a_heading_s_deviation_rises_with_the_cube_of_the_distance_from_a_least_one(bench: Bench) -> None:
    settings = bench.settings.marker
    assert heading_sd(bench, tag(1, 2 * settings.reference_distance)) == pytest.approx(
        8 * settings.heading_sd
    )
    assert heading_sd(bench, tag(1, 0.001)) == settings.least_heading_sd


def at(azimuth: float) -> Sighting:
    return Sighting(None, azimuth)  # type: ignore[arg-type]


RIGHT, MIDDLE, LEFT = at(-0.6), at(0.0), at(0.6)
ROW = (RIGHT, MIDDLE, LEFT)


def test_the_followed_board_is_the_nearest_to_where_the_turn_brought_it(bench: Bench) -> None:
    assert followed(bench, ROW, 0.0) is None
    bench.notebook.board_azimuth = 0.1
    assert followed(bench, ROW, 0.0) is MIDDLE
    assert followed(bench, ROW, 0.7) is RIGHT
    assert followed(bench, (), 0.0) is None


def test_a_board_farther_than_half_its_width_is_another_one(bench: Bench) -> None:
    bench.notebook.board_azimuth = 0.0
    assert followed(bench, (at(SAME_BOARD_WITHIN),), 0.0) is not None
    assert followed(bench, (at(SAME_BOARD_WITHIN + 1e-6),), 0.0) is None


def test_the_next_board_lies_in_the_direction_of_the_turn(bench: Bench) -> None:
    bench.notebook.board_azimuth = 0.0
    assert beyond(bench, ROW, CLOCKWISE, 0.0) is RIGHT
    assert beyond(bench, ROW, COUNTERCLOCKWISE, 0.0) is LEFT
    assert beyond(bench, (MIDDLE,), CLOCKWISE, 0.0) is None
    assert beyond(bench, (MIDDLE,), COUNTERCLOCKWISE, 0.0) is None
    bench.notebook.board_azimuth = None
    assert beyond(bench, ROW, CLOCKWISE, 0.0) is LEFT
    assert first_of((), CLOCKWISE) is None
    assert first_of(ROW, COUNTERCLOCKWISE) is RIGHT


@pytest.mark.parametrize("columns", [(), (100.0, 500.0, 300.0)], ids=["none", "three"])
def test_the_boards_of_a_frame_come_from_the_right_to_the_left(bench: Bench, monkeypatch, columns) -> None:
    frame = Frame(np.zeros((4, 4), dtype=np.uint8), 0.0, 0)
    views = [SimpleNamespace(corners_image=np.full((35, 2), column)) for column in columns]
    monkeypatch.setattr(boards, "find_boards", lambda image, board: views)
    found = boards.sightings(bench, frame)
    assert [sighting.view.corners_image[0, 0] for sighting in found] == sorted(columns, reverse=True)
    assert len(bench.frames[0].points_image) == 35 * len(columns)


def test_a_kept_view_is_followed_from_then_on(bench: Bench, monkeypatch) -> None:
    offered = []
    monkeypatch.setattr(boards, "offer_view", lambda bench, view: offered.append(view) or {"kept": True})
    monkeypatch.setattr(boards, "replace", lambda view, **changes: changes)
    frame = Frame(np.zeros((4, 4), dtype=np.uint8), 0.0, 7)
    assert boards.keep_view(bench, LEFT, 2, frame) == {"kept": True}
    assert bench.notebook.board_azimuth == LEFT.azimuth
    assert offered == [{"board": 2, "source": "frame 7"}]


@pytest.mark.parametrize(("values", "sharp"), [((1e9,), True), ((1e9, 1.0), False)])
def test_a_blurred_picture_gives_the_person_time_to_turn_the_lens(
    bench: Bench, monkeypatch, values, sharp
) -> None:
    left = list(values)
    frame = Frame(np.zeros((4, 4), dtype=np.uint8), 0.0, 0)
    monkeypatch.setattr(focusing, "look", lambda bench: frame)
    monkeypatch.setattr(focusing, "sharpness", lambda image: left.pop(0))
    for _ in values:
        outcome = focusing.measure_sharpness(bench)
    assert outcome.evidence == {"sharp": sharp, "sharpness": values[-1], "best": 1e9}
    assert bench.robot.asked == ([] if sharp else [("wait", bench.settings.turn.settle)])


def test_a_lost_frame_and_a_skipped_focus_are_told(bench: Bench) -> None:
    assert focusing.measure_sharpness(bench) is FRAME_MISSING
    bench.settings = replace(bench.settings, camera=replace(bench.settings.camera, skip_focus=True))
    assert focusing.measure_sharpness(bench).trigger == "focus_skipped"


class Eye(Tape):
    """A robot whose camera delivers these pictures, one after the other."""

    def __init__(self, *images: np.ndarray) -> None:
        super().__init__()
        self.images = list(images)

    def capture(self) -> Frame:
        return Frame(self.images.pop(0), 1.0, 4)


def test_a_frame_that_comes_is_handed_on_and_its_size_kept() -> None:
    bench = Bench(Eye(np.arange(12 * 16, dtype=np.uint8).reshape(12, 16)))
    bench.notebook.unseen = True
    frame = look(bench)
    assert isinstance(frame, Frame)
    assert frame.index == 4
    assert bench.notebook.image_size == (16, 12)
    assert not bench.notebook.unseen


def test_a_frame_that_repeats_every_pixel_is_frozen_and_the_move_before_it_unseen() -> None:
    picture = np.arange(12 * 16, dtype=np.uint8).reshape(12, 16)
    bench = Bench(Eye(picture, picture.copy()))
    look(bench)
    assert look(bench) is FRAME_FROZEN
    assert bench.notebook.unseen


def leaves(monkeypatch: pytest.MonkeyPatch, *sights: object) -> None:
    """Let the drive out of the field see these markers, one sight after the other."""
    left = list(sights)
    monkeypatch.setattr(leaving, "look_at_markers", lambda bench: left.pop(0))


def test_a_stretch_out_of_the_field_tells_how_far_markers_reach_ahead(bench: Bench, monkeypatch) -> None:
    leaves(monkeypatch, (tag(1, 0.3), tag(2, 0.45)))
    assert drive_off(bench).evidence == {"markers": 2, "ahead": 0.45}
    drive_settings = bench.settings.drive
    (_, _, duration), _ = bench.robot.asked
    assert duration == pytest.approx(drive_settings.stretch / drive_settings.expected_speed)
    assert [seen.tag_id for seen in bench.notebook.reading.tags] == [1, 2]


def test_a_lost_frame_on_the_way_out_is_told(bench: Bench, monkeypatch) -> None:
    leaves(monkeypatch, FRAME_MISSING)
    assert drive_off(bench) is FRAME_MISSING


def test_after_a_lost_frame_the_robot_looks_again_before_it_drives_on(bench: Bench, monkeypatch) -> None:
    before = (tag(1, 0.3), tag(2, 0.45))
    bench.notebook.reading, bench.notebook.unseen = MarkerReading(before, 0.0, 0.0), True
    leaves(monkeypatch, before)
    assert drive_off(bench).trigger == "marker_seen"
    assert bench.robot.asked == []


@pytest.mark.parametrize(("moved", "is_blocked"), [(0.9, True), (1.1, False)])
def test_markers_that_stay_where_they_were_tell_an_obstacle_on_the_way_out(
    bench: Bench, monkeypatch, moved: float, is_blocked: bool
) -> None:
    least = bench.settings.drive.moved_share * bench.settings.drive.stretch
    before = (tag(1, 0.3), tag(2, 0.45))
    bench.notebook.reading = MarkerReading(before, 0.0, 0.0)
    leaves(monkeypatch, tuple(replace(seen, x=seen.x - moved * least) for seen in before))
    monkeypatch.setattr(leaving, "why_held_up", lambda bench: DRIVE_BLOCKED)
    assert (drive_off(bench) is DRIVE_BLOCKED) is is_blocked


def test_a_robot_that_sees_no_marker_any_more_looks_twice_without_driving_on(
    bench: Bench, monkeypatch
) -> None:
    bench.notebook.reading = MarkerReading((tag(1, 0.3), tag(2, 0.45)), 0.0, 0.0)
    leaves(monkeypatch, (), ())
    assert drive_off(bench) is MARKER_MISSED
    assert drive_off(bench) is MARKER_MISSED
    assert [asked[0] for asked in bench.robot.asked] == ["run", "wait"]
    assert bench.notebook.marker_ahead == pytest.approx(0.45 - bench.settings.drive.stretch)


def test_a_stretch_whose_start_showed_no_marker_goes_on_from_the_last_ones(bench: Bench, monkeypatch) -> None:
    bench.notebook.marker_ahead = 0.4
    leaves(monkeypatch, ())
    drive_off(bench)
    assert bench.notebook.marker_ahead == pytest.approx(0.4 - bench.settings.drive.stretch)


def test_the_robot_is_handed_over_in_the_lane_s_middle_with_its_wheels_at_zero(bench: Bench) -> None:
    bench.notebook.marker_ahead, bench.notebook.field_left = 0.1, True
    way = 0.1 + bench.settings.lane.advance
    assert hand_over(bench).evidence == {"advance": round(way, 3)}
    run, _, stop = bench.robot.asked
    assert run[2] == pytest.approx(way / bench.settings.drive.expected_speed)
    assert stop == ("command", STOP)
    assert (bench.notebook.marker_ahead, bench.notebook.field_left) == (0.0, False)


def test_a_robot_beyond_the_lane_s_middle_stays_where_it_is(bench: Bench) -> None:
    bench.notebook.marker_ahead = -1.0 - bench.settings.lane.advance
    assert hand_over(bench).evidence == {"advance": 0.0}
    assert bench.robot.asked == [("command", STOP)]


def test_a_measured_speed_sets_how_long_the_stretches_are(bench: Bench, monkeypatch) -> None:
    bench.notebook.speed = 0.1
    leaves(monkeypatch, ())
    drive_off(bench)
    assert bench.robot.asked[0][2] == pytest.approx(bench.settings.drive.stretch / 0.1)
