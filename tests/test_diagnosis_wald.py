"""How clearly numbers of a fit leave those that change nothing."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_robots import engine_of, recording

from fsm_calib.diagnosis.fitting.base import fit_base, slot_of
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.diagnosis.fitting.wald import strengths_of, wald

CHANGED = {"motor_deadband.offset": 0.02, "command_delay.delay": 0.03}


@pytest.fixture(scope="module")
def fit():
    """A base robot with a dead zone of 0.02 and a delay of 0.03 s in the last two rows, their covariance as given."""
    engine = engine_of(recording(0))
    base = fit_base(engine)
    slots = (*base.slots, *map(slot_of, CHANGED))
    free = engine.fit(with_values(base.values, CHANGED), slots, base.noise, steps=0)
    covariance = np.eye(len(slots))
    covariance[-2:, -2:] = [[0.01**2, 0.5 * 0.01 * 0.02], [0.5 * 0.01 * 0.02, 0.02**2]]
    return replace(free, covariance=covariance)


@pytest.mark.parametrize(("name", "expected"), [("motor_deadband", 4.0), ("command_delay", 2.25)])
def test_one_number_counts_by_its_deviation(fit, name, expected):
    assert wald(fit, strengths_of(fit, name)) == pytest.approx(expected)


def test_two_numbers_count_by_their_correlation(fit):
    a, b, r = 2.0, 1.5, 0.5
    expected = (a * a + b * b - 2.0 * r * a * b) / (1.0 - r * r)
    assert wald(fit, fit.slots[-2:]) == pytest.approx(expected)


def test_of_no_numbers_it_is_nothing(fit):
    assert strengths_of(fit, "caster_drag") == []
    assert wald(fit, []) == 0.0
