"""A cell near its end loses ever more by what is drawn, and a computer empties it at rest, too."""

import numpy as np
import pytest
from diagnosis_robots import judged, speeds

from fsm_calib.world2d.parameters import parameter_table


def strength(command, at, **changes):
    """Return the speed [1] at a time [s], steady driving at one command, over that of a robot with a full cell."""
    grid = np.array([0.0, at])
    full = speeds([0.0], [command], grid)[-1]
    return (
        speeds([0.0], [command], grid, **{f"battery_sag__{name}": v for name, v in changes.items()})[-1]
        / full
    )


@pytest.mark.parametrize("seconds", [10.0, 30.0])
def test_the_loss_follows_shepherds_polarisation(seconds):
    """Charge Q = (2 u + idle) t, loss beta Q / (1 - Q / Q_0)."""
    charge = (2.0 * 0.5 + 0.4) * seconds
    lost = 0.003 * charge / (1.0 - 0.015 * charge)
    found = strength(0.5, seconds, per_charge=0.003, emptying=0.015, idle=0.4)
    assert found == pytest.approx(1.0 - lost, abs=0.005)


def test_an_idle_computer_empties_it_at_rest():
    grid = np.array([0.0, 45.0])
    late = [
        speeds([0.0, 40.0], [0.0, 0.5], grid, battery_sag__per_charge=0.004, battery_sag__idle=i)[-1]
        for i in (0, 1)
    ]
    assert late[1] / late[0] == pytest.approx(1.0 - 0.004 * 45.0, abs=0.01)


def test_an_empty_cell_gives_nothing_and_breaks_nothing():
    assert strength(0.5, 60.0, per_charge=0.01, emptying=0.1) == pytest.approx(0.0, abs=1e-6)


def test_a_cell_near_its_end_is_named_by_its_law():
    rivals = ("battery_sag", "motor_warmup", "motor_fault", "motor_gain_curve")
    decision = judged(
        rivals, battery_sag__per_charge=0.002, battery_sag__emptying=0.018, battery_sag__idle=0.5
    )
    assert [belief.name for belief in decision.named] == ["battery_sag"]
    assert decision.model.effects[0].hypothesis.closure == "near its end"
    place = parameter_table().place("battery_sag.emptying")
    assert decision.model.fit.values[0, place] == pytest.approx(0.018, rel=0.4)
