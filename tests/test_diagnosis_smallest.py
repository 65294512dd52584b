"""The smallest effect that a match would have shown: what is a little larger is named, what is smaller is not."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_robots import drive, judged

from fsm_calib.diagnosis.candidates.hypotheses import catalogue, shown_by
from fsm_calib.diagnosis.proof.gates import DEFAULT_GATES
from fsm_calib.diagnosis.verdict.detectable import smallest_sizes
from fsm_calib.world2d.effects import registry


@pytest.fixture(scope="module")
def sizes():
    matching = judged(["motor_deadband"])
    asked = shown_by(catalogue(), matching.engine.simulators)
    return smallest_sizes(replace(matching, asked=tuple(asked)), DEFAULT_GATES.first)


@pytest.mark.parametrize("name", ["motor_reverse_asymmetry", "motor_deadband", "tyre_scrub"])
def test_twice_the_smallest_size_is_named_and_a_third_is_not(sizes, name):
    parameter, size, _ = sizes[name]
    full = f"{name}__{parameter}"
    assert judged([name], **{full: 2.0 * size}).outcome == "explained"
    assert judged([name], **{full: size / 3.0}).outcome == "match"


def test_a_limit_that_would_be_seen_is_one_that_commands_reach(sizes):
    largest = max(np.abs(drive(np.random.default_rng(seed)).left).max() for seed in (0, 1))
    assert sizes["command_saturation"][1] < largest


def test_every_size_is_one_that_occurs(sizes):
    for name, (parameter, size, _) in sizes.items():
        declared = registry()[name].parameter(parameter)
        assert declared.low <= size <= declared.high


def test_an_effect_that_was_not_asked_has_no_size():
    assert set(smallest_sizes(judged(["motor_deadband"]), DEFAULT_GATES.first)) == {"motor_deadband"}


def test_an_effect_that_no_size_would_show_is_left_out(sizes):
    assert "skid_steer" not in sizes
