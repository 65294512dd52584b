"""The run report's figures: values land where the axes say, and the page says what it draws."""

from __future__ import annotations

import re

import numpy as np
import pytest

from fsm_calib.report.plot import Axes, Box, figure
from fsm_calib.report.plot_scale import Scale, limits, round_step, tick_label
from fsm_calib.report.run_camera import heat_picture
from fsm_calib.report.run_plan import thinned


def test_the_ends_of_the_axes_are_the_corners_of_the_box() -> None:
    axes = Axes(Box(10.0, 20.0, 300.0, 200.0), (0.0, 640.0), (480.0, 0.0))
    assert (float(axes.x(0.0)), float(axes.x(640.0))) == (10.0, 310.0)
    assert (float(axes.y(480.0)), float(axes.y(0.0))) == (220.0, 20.0)


@pytest.mark.parametrize(
    ("low", "high"), [(0.0, 17.0), (0.958, 1.003), (480.0, 0.0), (-0.14, 0.14), (3e-7, 5e-7)]
)
def test_ticks_are_round_inside_the_axis_and_labelled_by_their_value(low: float, high: float) -> None:
    ticks = Scale(low, high, 0.0, 100.0).ticks()
    values = np.array([value for value, _ in ticks])
    assert 3 <= len(ticks) <= 7
    assert values.min() >= min(low, high) - 1e-9
    assert values.max() <= max(low, high) + 1e-9
    np.testing.assert_allclose([float(label.replace("−", "-")) for _, label in ticks], values, atol=1e-12)


def test_a_step_is_the_next_round_number() -> None:
    assert [round_step(least) for least in (0.9, 1.0, 1.1, 2.2, 3.0, 7.0)] == [1.0, 1.0, 2.0, 2.5, 5.0, 10.0]


def test_zero_has_no_sign() -> None:
    assert tick_label(-0.0, 0.5) == "0.0"
    assert tick_label(-0.25, 0.25) == "−0.25"


def test_whole_ticks_can_be_asked_for() -> None:
    assert [label for _, label in Scale(-0.3, 2.3, 0.0, 1.0).ticks(least_step=1.0)] == ["0", "1", "2"]


def test_one_value_has_room_around_it() -> None:
    low, high = limits(np.array([2.0]))
    assert low < 2.0 < high


def test_a_shrunk_box_has_one_scale_both_ways() -> None:
    box = Box(0.0, 0.0, 300.0, 200.0).shrunk((0.0, 640.0), (480.0, 0.0))
    assert box.width / 640.0 == pytest.approx(box.height / 480.0)
    assert box.width <= 300.0
    assert box.height <= 200.0


def test_a_line_passes_through_its_points() -> None:
    axes = Axes(Box(0.0, 0.0, 100.0, 100.0), (0.0, 1.0), (0.0, 1.0))
    axes.line(np.array([(0.0, 0.0), (0.5, 1.0)]), "#000000")
    assert 'd="M0.0 100.0L50.0 0.0"' in axes.svg("a")


def test_an_arrow_points_up_where_y_grows_up() -> None:
    axes = Axes(Box(0.0, 0.0, 100.0, 100.0), (0.0, 1.0), (0.0, 1.0))
    axes.arrows(np.array([(0.5, 0.0)]), np.array([0.5 * np.pi]), 0.5, "#000000")
    path = re.search(r'd="(M50\.0 100\.0L50\.0 50\.0[^"]*)"', axes.svg("a"))
    assert path is not None
    barbs = re.findall(r"l(-?[\d.]+) (-?[\d.]+)", path[1])
    assert all(float(down) > 0.0 for _, down in barbs)


def test_words_and_labels_are_escaped() -> None:
    axes = Axes(Box(0.0, 0.0, 100.0, 100.0), (0.0, 1.0), (0.0, 1.0))
    axes.words(0.5, 0.5, "a < b & c")
    axes.frame("<x>", "y")
    text = figure(120.0, 120.0, 'a "plan"', axes)
    assert "a &lt; b &amp; c" in text
    assert "&lt;x&gt;" in text
    assert 'aria-label="a &quot;plan&quot;"' in text


def test_the_names_of_a_figures_parts_are_its_own() -> None:
    axes = [Axes(Box(0.0, 0.0, 10.0, 10.0), (0.0, 1.0), (0.0, 1.0)) for _ in range(2)]
    text = figure(20.0, 20.0, "Floor plan", *axes)
    assert re.findall(r'clipPath id="([^"]+)"', text) == ["floor-plan-0", "floor-plan-1"]


def test_a_thinned_path_keeps_its_ends_and_strays_by_less_than_a_step() -> None:
    turn = np.linspace(0.0, 3.0, 2000)
    path = np.column_stack([np.cos(turn), np.sin(turn)])
    thin = thinned(path, 0.01)
    assert len(thin) < 320
    np.testing.assert_array_equal(thin[[0, -1]], path[[0, -1]])
    nearest = np.hypot(*(path[:, None] - thin[None]).transpose(2, 0, 1)).min(axis=1)
    assert nearest.max() < 0.01


def test_a_path_of_a_robot_that_stands_is_its_ends() -> None:
    assert len(thinned(np.zeros((50, 2)), 0.01)) == 2


def test_the_heat_picture_runs_from_the_first_colour_to_the_last() -> None:
    import base64

    import cv2

    url = heat_picture(np.array([[0.0, 1.0], [0.0, 1.0]]))
    coded = np.frombuffer(base64.b64decode(url.split(",")[1]), np.uint8)
    picture = cv2.imdecode(coded, cv2.IMREAD_COLOR)
    assert picture[0, 0].tolist() == [0x54, 0x01, 0x44]
    assert picture[-1, -1].tolist() == [0x25, 0xE7, 0xFD]
