"""What is gone of a decay after a step: the series and the exponential are one function."""

from __future__ import annotations

import math

import pytest

from fsm_calib.world2d.decay import SMALL, gone


@pytest.mark.parametrize("time", [0.0, 1e-9, 1e-4, 0.5 * SMALL, SMALL, 1.0001 * SMALL, 0.3, 5.0, -0.01])
def test_what_is_gone_is_one_less_an_exponential_to_the_last_digits(time):
    assert gone(time) == pytest.approx(-math.expm1(-time), rel=1e-14, abs=0.0)
