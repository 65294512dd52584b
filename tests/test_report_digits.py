"""Numbers as text: as many digits as their deviation leaves."""

import pytest

from fsm_calib.report import digits


@pytest.mark.parametrize(
    ("value", "sd", "text"),
    [
        (0.623748, 0.0015, "0.6237 ± 0.0015 m"),
        (0.0329922, 1.3e-05, "0.032992 ± 0.000013 m"),
        (12.3456, 0.0996, "12.35 ± 0.10 m"),
        (1234.5, 27.0, "1234 ± 27 m"),
        (1.0, 0.0, "1 ± 0 m"),
        (0.623748, None, "0.623748 m"),
        (0.623748, float("inf"), "0.623748 m"),
    ],
)
def test_a_number_ends_where_its_deviation_does(value, sd, text):
    assert digits.estimate(value, sd, "m") == text


def test_a_number_without_a_unit_has_none():
    assert digits.estimate(0.885405, 0.0063, "1", "+-") == "0.8854 +- 0.0063"
