"""Intervals by an independent route: Student's t, exact binomial coverage, scipy's own figures."""

import math

import numpy as np
import pytest
from scipy import stats

from fsm_calib.study.statistics import estimate, mean_of, median_of, rank_correlation, share


def test_the_bootstrap_of_a_mean_is_students_interval():
    rng = np.random.default_rng(1)
    values = rng.normal(2.0, 1.0, 200)
    found = estimate(values, mean_of, rng)
    low, high = stats.t.interval(0.95, 199, values.mean(), stats.sem(values))
    assert found.value == pytest.approx(values.mean())
    assert (found.low, found.high) == pytest.approx((low, high), abs=0.02)


def test_intervals_of_the_median_hold_the_truth_in_about_95_of_100_samples():
    rng = np.random.default_rng(2)
    held = [
        found.low <= 0.0 <= found.high
        for found in (estimate(rng.normal(size=30), median_of, rng) for _ in range(120))
    ]
    assert 0.89 <= np.mean(held) <= 1.0


def test_robots_without_a_result_are_left_out_and_few_values_have_no_interval():
    found = estimate(np.array([1.0, math.nan, 3.0]), mean_of, np.random.default_rng(0))
    assert (found.value, found.count) == (2.0, 2)
    assert math.isnan(found.low)


@pytest.mark.parametrize(("hits", "count"), [(0, 10), (10, 10), (3, 10), (199, 200)])
def test_a_share_has_wilsons_interval(hits, count):
    found = share(hits, count)
    wanted = stats.binomtest(hits, count).proportion_ci(method="wilson")
    assert (found.low, found.high) == pytest.approx((wanted.low, wanted.high), abs=1e-6)


def test_the_rank_correlation_is_scipys_also_with_ties():
    rng = np.random.default_rng(3)
    x = rng.integers(0, 8, 60).astype(float)
    y = x + rng.normal(0.0, 4.0, 60)
    found = rank_correlation(x, y, rng)
    assert found.value == pytest.approx(stats.spearmanr(x, y).statistic)
    assert found.low < found.value < found.high
    assert found.excludes_zero


def test_a_correlation_of_few_pairs_is_not_told():
    found = rank_correlation(np.arange(5.0), np.arange(5.0), np.random.default_rng(0))
    assert math.isnan(found.value)
    assert not found.excludes_zero
