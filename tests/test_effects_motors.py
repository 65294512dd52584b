"""Motors as they are: windings heated by their current, another constant backwards, bridges that let them coast."""

from functools import partial

import diagnosis_robots
import numpy as np
import pytest
from diagnosis_robots import judged

from fsm_calib.world2d.parameters import parameter_table

GAIN, LAG = 0.6, 0.15
HEAT = {"motor_warmup__heat": 8.0, "motor_warmup__effort": 20.0}
FLUX = {"motor_reverse_asymmetry__flux_left": 0.15, "motor_reverse_asymmetry__flux_right": 0.1}
MOTOR_RIVALS = ("motor_warmup", "battery_sag", "motor_asymmetric_lag", "motor_reverse_asymmetry")
speeds = partial(diagnosis_robots.speeds, gain_left=GAIN, gain_right=GAIN, tau_forward=LAG)


def rise(speed, grid, start):
    """Return the time [s] after `start` in which 63 % of a step of the speed are done."""
    part = speed[(grid >= start) & (grid < start + 1.5)]
    share = (part - part[0]) / (part[-1] - part[0])
    return float(np.interp(1.0 - np.exp(-1.0), share, grid[: len(part)]))


def shuttling(seconds):
    """Return times and levels of a robot that reverses all the time, then rests and goes once more."""
    times = np.arange(0.0, seconds, 0.5)
    levels = np.where(np.arange(len(times)) % 2, -0.6, 0.6)
    return [*times, seconds, seconds + 2.0], [*levels, 0.0, 0.6]


def test_a_robot_that_runs_free_stays_cool():
    grid = np.arange(0.0, 33.0, 0.01)
    drive = [0.0, 30.0, 31.0], [0.6, 0.0, 0.6]
    speed = speeds(*drive, grid, **HEAT)
    assert rise(speed, grid, 31.0) == pytest.approx(rise(speed, grid, 0.0), rel=0.05)
    assert speed[2900] == pytest.approx(speeds(*drive, grid)[2900], rel=1e-3)


def test_one_that_reverses_all_the_time_has_slower_motors_and_cools_again():
    grid = np.arange(0.0, 100.0, 0.01)
    times, levels = shuttling(30.0)
    times, levels = [*times, 34.0, 94.0], [*levels, 0.0, 0.6]
    speed = speeds(times, levels, grid, **HEAT)
    cold, hot, cooled = (
        rise(speeds([0.0], [0.6], grid), grid, 0.0),
        rise(speed, grid, 32.0),
        rise(speed, grid, 94.0),
    )
    assert hot > 1.3 * cold
    assert cooled < 1.05 * cold


def test_weak_magnets_make_it_faster():
    grid = np.arange(0.0, 34.0, 0.01)
    speed = speeds(*shuttling(30.0), grid, motor_warmup__magnet=0.5, **HEAT)
    assert speed[-1] > 1.05 * speeds(*shuttling(30.0), grid)[-1]


def test_backwards_another_constant_is_slower_and_stiffer():
    """No-load speed by 1 / k; stiffer by k^2: the time constant falls as 1 / k^2."""
    grid = np.arange(0.0, 3.0, 0.01)
    options = dict.fromkeys(FLUX, 0.2)
    ahead, back = (speeds([0.0], [level], grid, **options) for level in (0.5, -0.5))
    assert back[-1] == pytest.approx(-ahead[-1] / 1.2, rel=2e-3)
    assert rise(back, grid, 0.0) == pytest.approx(rise(ahead, grid, 0.0) / 1.2**2, rel=0.05)


def test_a_bridge_that_coasts_is_fast_at_small_commands_and_lets_the_robot_roll_out():
    """T u / b with b = 1 - c (1 - u); at rest the motor brakes by 1 - c of its slope, and takes so much longer."""
    grid = np.arange(0.0, 8.0, 0.01)
    speed = speeds([0.0, 4.0], [0.2, 0.0], grid, motor_gain_curve__coasting=0.5)
    braked = speeds([0.0, 4.0], [0.2, 0.0], grid)
    assert speed[390] == pytest.approx(GAIN * 0.2 / (1.0 - 0.5 * 0.8), rel=2e-3)
    assert rise(speed, grid, 4.0) == pytest.approx(2.0 * rise(braked, grid, 4.0), rel=0.05)


def test_at_full_command_no_bridge_coasts():
    grid = np.arange(0.0, 4.0, 0.01)
    full = [0.0], [1.0], grid
    assert speeds(*full, motor_gain_curve__coasting=0.5) == pytest.approx(speeds(*full), abs=1e-9)


def test_a_bridge_that_coasts_is_named_by_its_size():
    rivals = ("motor_gain_curve", "motor_deadband", "motor_asymmetric_lag", "command_saturation")
    decision = judged(rivals, motor_gain_curve__coasting=0.4)
    assert [belief.name for belief in decision.named] == ["motor_gain_curve"]
    assert decision.model.effects[0].hypothesis.closure == "coasting"
    place = parameter_table().place("motor_gain_curve.coasting")
    assert decision.model.fit.values[0, place] == pytest.approx(0.4, rel=0.1)


def test_windings_heated_by_their_current_are_named():
    decision = judged(MOTOR_RIVALS, duration=40.0, **HEAT)
    assert [belief.name for belief in decision.named] == ["motor_warmup"]
    assert decision.model.effects[0].hypothesis.closure == "heat of the current"
    place = parameter_table().place("motor_warmup.heat")
    assert decision.model.fit.values[0, place] == pytest.approx(8.0, rel=0.25)


def test_another_constant_backwards_is_named_with_its_sizes():
    decision = judged(MOTOR_RIVALS, **FLUX)
    assert [belief.name for belief in decision.named] == ["motor_reverse_asymmetry"]
    assert decision.model.effects[0].hypothesis.closure == "another constant"
    for name, size in FLUX.items():
        place = parameter_table().place(name.replace("__", "."))
        assert decision.model.fit.values[0, place] == pytest.approx(size, rel=0.1)
