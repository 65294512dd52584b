"""Commands that are read off a table of few entries, some of them wrong: what it gives, and that it is named."""

from functools import partial

import diagnosis_robots
import numpy as np
import pytest
from diagnosis_robots import fitted_number, judged

GAIN = 0.6
TABLE = {"table_quarter": 0.1, "table_half": -0.06, "table_three_quarters": 0.04}
WRONG = {f"motor_gain_curve__{entry}": error for entry, error in TABLE.items()}
RIVALS = ("motor_gain_curve", "motor_deadband", "command_saturation", "coulomb_friction")
speeds = partial(diagnosis_robots.speeds, gain_left=GAIN, gain_right=GAIN, tau_forward=0.05, slip_speed=1e-4)


@pytest.mark.parametrize("command", [0.1, 0.25, 0.4, 0.5, 0.7, 0.75, 0.9, 1.0, -0.4])
def test_a_command_is_read_off_straight_between_the_entries(command):
    places = np.arange(5) / 4
    entries = places * (1.0 + np.array([0.0, *TABLE.values(), 0.0]))
    expected = np.sign(command) * GAIN * np.interp(abs(command), places, entries)
    assert speeds([0.0], [command], np.array([0.0, 3.0]), **WRONG)[-1] == pytest.approx(expected, abs=1e-4)


def test_beyond_full_command_it_goes_on_as_before_it():
    speed = [speeds([0.0], [u], np.array([0.0, 3.0]), **WRONG)[-1] for u in (0.8, 1.0)]
    assert (speed[1] - speed[0]) / 0.2 == pytest.approx(GAIN * 4.0 * (1.0 - 0.75 * 1.04), rel=1e-3)


def test_it_is_named_with_its_entries_and_its_side():
    """These drives hardly command more than a half: of the entries up to there the ratio is told, not the scale."""
    decision = judged(RIVALS, **WRONG, motor_gain_curve__table_side=1.0)
    assert [belief.name for belief in decision.named] == ["motor_gain_curve"]
    assert decision.model.effects[0].hypothesis.closure == "table"
    quarter, half, whose = (
        fitted_number(decision.model.fit, f"motor_gain_curve.{name}")
        for name in ("table_quarter", "table_half", "table_side")
    )
    assert (1.0 + quarter) / (1.0 + half) == pytest.approx(1.1 / 0.94, rel=0.015)
    assert whose == 1.0


def test_a_bend_keeps_its_plain_equation():
    decision = judged(RIVALS, motor_gain_curve__curvature=0.2)
    assert decision.model.effects[0].hypothesis.closure == "both alike"
