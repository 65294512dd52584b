"""A supply that ends behind a speed loop: what it cuts, and that it is found by its size."""

from functools import partial

import diagnosis_robots
import numpy as np
import pytest
from diagnosis_robots import fitted_number, judged

GAIN, LAG, VOLTAGE, LOOP = 0.6, 0.1, 0.5, 3.0
ENDING = {"command_saturation__voltage": VOLTAGE, "command_saturation__loop": LOOP}
speeds = partial(diagnosis_robots.speeds, gain_left=GAIN, gain_right=GAIN, tau_forward=LAG, slip_speed=1e-4)


def by_voltage(wanted, grid, step=1e-4):
    """Return speeds [m/s] towards a set point [m/s] by the voltage, cut where it ends, in steps of 0.1 ms."""
    speed, expected = 0.0, [0.0]
    for _ in range(round(grid[-1] / step)):
        voltage = speed + (1.0 + LOOP) * (wanted - speed)
        voltage = min(max(voltage, -VOLTAGE * GAIN), VOLTAGE * GAIN)
        speed += step * (voltage - speed) / ((1.0 + LOOP) * LAG)
        expected.append(speed)
    return np.array(expected)[np.rint(grid / step).astype(int)]


@pytest.mark.parametrize("command", [0.1, 0.3, -0.45, 0.9])
def test_a_start_is_that_of_a_loop_whose_voltage_is_cut(command):
    grid = np.arange(0.0, 2.0, 0.01)
    assert speeds([0.0], [command], grid, **ENDING) == pytest.approx(
        by_voltage(GAIN * command, grid), abs=4e-3
    )


def test_no_set_point_gives_more_than_the_supply():
    grid = np.arange(0.0, 6.0, 0.01)
    tops = [speeds([0.0], [u], grid, **ENDING)[-1] for u in (0.4, 0.8, 1.0)]
    assert tops == pytest.approx([0.4 * GAIN, VOLTAGE * GAIN, VOLTAGE * GAIN], rel=1e-3)


def test_an_integral_does_not_grow_where_the_supply_has_ended():
    """After three seconds at the end of the supply a smaller set point is met as soon as after one."""
    grid = np.arange(0.0, 6.0, 0.01)
    held = {**ENDING, "speed_controller__hold": 5.0}
    short, long = (speeds([0.0, t], [1.0, 0.3], grid, **held) for t in (1.0, 3.0))
    assert long[350] == pytest.approx(short[150], abs=5e-3)
    assert long[-1] == pytest.approx(0.3 * GAIN, rel=1e-2)


def test_it_is_named_with_where_the_supply_ends():
    names = (
        "command_saturation",
        "battery_sag",
        "motor_gain_curve",
        "motor_asymmetric_lag",
        "coulomb_friction",
    )
    decision = judged(names, command_saturation__voltage=0.4, command_saturation__loop=LOOP)
    assert [b.name for b in decision.named] == ["command_saturation"]
    assert decision.model.effects[0].hypothesis.closure == "end of supply"
    found = [fitted_number(decision.model.fit, f"command_saturation.{n}") for n in ("voltage", "loop")]
    assert found == pytest.approx([0.4, LOOP], rel=0.1)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_limit_of_one_driver_is_found_on_its_side(side):
    names = ("command_saturation", "motor_gain_curve", "motor_deadband", "motor_fault")
    decision = judged(names, command_saturation__limit=0.4, command_saturation__limit_side=side)
    assert [b.name for b in decision.named] == ["command_saturation"]
    found = [fitted_number(decision.model.fit, f"command_saturation.{n}") for n in ("limit", "limit_side")]
    assert found == pytest.approx([0.4, side], rel=0.02)
