"""k from all drives together: its standard error follows from the headings' noise and from how drives scatter."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from fsm_calib.actions import Bench, ratio
from fsm_calib.actions.notebook import WheelRun
from fsm_calib.actions.ratio import combined_ratio

LENGTH = 1.2  # m of each drive


class Turns:
    """Headings that say how far each drive turned [rad], all with one standard deviation."""

    def __init__(self, turned: list[float], sd: float) -> None:
        self.all, self.sd = turned, sd

    def turned(self, first: int, second: int) -> tuple[float, float]:
        assert second == first + 1
        return self.all[first // 2], self.sd


@pytest.fixture
def bench() -> Bench:
    return Bench(object())  # type: ignore[arg-type]


def drives(monkeypatch: pytest.MonkeyPatch, bench: Bench, turned: list[float], sd: float) -> None:
    """Give the bench one drive a turn, all with k = 1."""
    bench.notebook.runs = [WheelRun(1.0, 6.0, LENGTH, one, sd, 1.0) for one in turned]
    monkeypatch.setattr(ratio, "adjusted", lambda bench, readings: Turns(turned, sd))


def error_of(bench: Bench, count: int, sd: float, scatter: float) -> float:
    """The error of the mean of so many drives with a heading's deviation [rad] and a variance of the drive over 1 m."""
    noise = sd * bench.settings.ratio.axle_length / LENGTH
    return math.sqrt((noise**2 + scatter / LENGTH) / count)


def test_drives_that_agree_are_taken_to_scatter_less_than_expected(bench: Bench, monkeypatch) -> None:
    drives(monkeypatch, bench, [0.0] * 5, 0.05)
    scatter = 4.0 * bench.settings.ratio.run_scatter**2 / (4.0 + 5.0 - 1.0)
    assert combined_ratio(bench).error == pytest.approx(error_of(bench, 5, 0.05, scatter))


def test_drives_that_scatter_beyond_their_headings_noise_know_k_less_well(bench: Bench, monkeypatch) -> None:
    turned, sd = [0.2, -0.2, 0.2, -0.2], 0.01
    drives(monkeypatch, bench, turned, sd)
    scale = bench.settings.ratio.axle_length / LENGTH
    excess = LENGTH * float(np.sum((np.array(turned) * scale) ** 2 - (sd * scale) ** 2))
    scatter = (4.0 * bench.settings.ratio.run_scatter**2 + excess) / (4.0 + 4.0 - 1.0)
    assert combined_ratio(bench).error == pytest.approx(error_of(bench, 4, sd, scatter), rel=0.01)


def test_the_combined_k_drives_straight_where_each_drive_turned_the_same(bench: Bench, monkeypatch) -> None:
    drives(monkeypatch, bench, [0.12, 0.12], 0.01)
    mismatch = 0.12 * bench.settings.ratio.axle_length / LENGTH
    assert combined_ratio(bench).ratio == pytest.approx((2.0 - mismatch) / (2.0 + mismatch))


def test_a_drive_far_from_straight_does_not_count(bench: Bench, monkeypatch) -> None:
    limit = bench.settings.ratio.combine_within * LENGTH / bench.settings.ratio.axle_length
    drives(monkeypatch, bench, [0.0, 0.0, 1.01 * limit], 0.01)
    assert combined_ratio(bench).ratio == pytest.approx(1.0)
    drives(monkeypatch, bench, [0.0, 0.0, 0.99 * limit], 0.01)
    assert combined_ratio(bench).ratio < 0.99


def test_no_drive_near_straight_leaves_k_unknown(bench: Bench, monkeypatch) -> None:
    drives(monkeypatch, bench, [1.0], 0.01)
    bench.notebook.wheel_ratio = 1.07
    found = combined_ratio(bench)
    assert (found.ratio, found.error) == (1.07, math.inf)


def test_drives_at_several_k_tell_how_much_of_a_mismatch_each_shows(bench: Bench, monkeypatch) -> None:
    """A robot whose axle is a tenth longer than the nominal one shows nine tenths of each mismatch."""
    shown, true_ratio, ratios = 0.9, 1.01, (0.97, 1.0, 1.03)
    scale = LENGTH / bench.settings.ratio.axle_length
    turned = [-shown * (true_ratio - ratio) * scale for ratio in ratios]
    drives(monkeypatch, bench, turned, 0.001)
    bench.notebook.runs = [
        replace(run, wheel_ratio=ratio) for run, ratio in zip(bench.notebook.runs, ratios, strict=True)
    ]
    assert combined_ratio(bench).ratio == pytest.approx(true_ratio, abs=1e-3)
