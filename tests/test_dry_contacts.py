"""Dry friction between body and floor: it holds what is too weak, lets go at once, and slides against the motion."""

from __future__ import annotations

import math

import numpy as np
import pytest

from fsm_calib.world2d.dry_contacts import ANY_WAY, IMPULSE, add_contact, brake, slowed
from fsm_calib.world2d.parameters import parameter_table, parameters
from fsm_calib.world2d.rollout import Drive, simulate
from fsm_calib.world2d.slots import BENCH_SIZE, CONTACT, CONTACT_SIZE, INVERSE, STEP

SECONDS = np.arange(0.0, 3.0, 0.005)


def driven(left: float, right: float, **effect: float) -> np.ndarray:
    """Return the poses (n, 3) of a robot that is told (left, right) from 0.5 s on and to stop after 2 s."""
    numbers = {name.replace("__", "."): value for name, value in effect.items()}
    drive = Drive(np.array([0.0, 0.5, 2.0]), np.array([0.0, left, 0.0]), np.array([0.0, right, 0.0]))
    return simulate(parameters(numbers), drive, SECONDS, (0.0, 0.0, 0.0))[:, :3]


def rates(poses: np.ndarray) -> np.ndarray:
    """Return the yaw rates [rad/s] between poses."""
    return np.diff(poses[:, 2]) / np.diff(SECONDS)


def test_a_turn_too_weak_for_the_scrubbing_tyres_stays_undone():
    poses = driven(-0.05, 0.05, tyre_scrub__moment=0.3)
    assert abs(poses[-1, 2]) < 2e-3


def test_a_turn_stronger_than_the_scrubbing_tyres_begins_with_the_next_step():
    free, braked = rates(driven(-0.3, 0.3)), rates(driven(-0.3, 0.3, tyre_scrub__moment=0.02))
    begun = np.searchsorted(SECONDS, 0.5)
    assert 0.5 < braked[begun + 1] / free[begun + 1] < 1.0


def test_scrubbing_tyres_never_turn_the_robot_back():
    assert rates(driven(-0.3, 0.3, tyre_scrub__moment=0.05)).min() > -1e-6  # the motors ring out


def test_a_scrubbed_turn_stops_in_the_time_that_its_moment_takes():
    """Beyond the motors' braking: w' = -(w + reach) / tau, zero after tau log(1 + w / reach)."""
    free, braked = driven(-0.3, 0.3), driven(-0.3, 0.3, tyre_scrub__moment=0.05)
    stop = int(np.searchsorted(SECONDS, 2.0))
    steady, slower = rates(free)[stop - 5], rates(braked)[stop - 5]
    tail = rates(free)[stop + 20] / rates(free)[stop + 40]
    tau = 0.1 / math.log(tail)
    expected = tau * math.log1p(slower / (steady - slower))
    still = int(np.argmax(rates(braked)[stop:] < 1e-6))
    assert still * 0.005 == pytest.approx(expected, abs=0.015)


def test_a_dragging_caster_holds_a_robot_that_its_motors_cannot_move():
    poses = driven(0.02, 0.02, caster_drag__drag=3.0)
    assert np.abs(poses[-1]).max() < 1e-9


def test_a_caster_drags_against_the_motion_of_its_pivot():
    """Spinning in place, its pivot moves sideways: the drag acts as a moment and does not push the robot ahead."""
    poses = driven(-0.3, 0.3, caster_drag__drag=0.5)
    assert np.hypot(poses[-1, 0], poses[-1, 1]) < 0.02
    assert poses[-1, 2] < driven(-0.3, 0.3)[-1, 2]


def test_rolling_resistance_of_wheels_without_play_is_the_motors_friction_by_another_name():
    radius = parameters({})[parameter_table().place("wheel_radius_left")]
    tyres = driven(0.4, 0.3, coulomb_friction__rolling=0.2)
    motors = driven(0.4, 0.3, coulomb_friction__friction=0.2 * radius)
    assert tyres == pytest.approx(motors, abs=2e-3)
    assert np.hypot(*(tyres - driven(0.4, 0.3))[-1, :2]) > 0.03


def test_rolling_resistance_goes_on_where_the_gears_play():
    """Teeth that are apart leave the body alone with it: m dv/dt = 2 F_r, to the step in which they meet again."""
    play = {"gear_backlash.gap": 1.5, "coulomb_friction.rolling": 0.05}
    numbers, table = parameters(play), parameter_table()
    drive = Drive(np.array([0.0]), np.array([0.0]), np.array([0.0]))
    speed = simulate(numbers, drive, SECONDS[:20], (0.0, 0.0, 0.0, -0.3, 0.0, 0.0))[:, 3]
    assert np.diff(speed[3:15]) / 0.005 == pytest.approx(2.0 * 0.05 / numbers[table.place("mass")], rel=1e-6)


@pytest.mark.parametrize("creep", [0.0, 1e-3, 0.2])
@pytest.mark.parametrize("free", [-3.0, -0.01, 0.004, 0.5])
def test_the_slowed_speed_solves_its_equation(free, creep):
    reach = 0.03
    x = slowed(free, reach, creep, creep, 0.0)
    if creep == 0.0:
        assert x == pytest.approx(math.copysign(max(abs(free) - reach, 0.0), free))
    else:
        assert x + reach * x / math.hypot(x, creep) == pytest.approx(free, abs=1e-8)


@pytest.mark.parametrize("guess", [0.0, 0.1, 5.0])
def test_a_tread_of_two_creep_speeds_is_slowed_by_half_of_each_wherever_the_search_begins(guess):
    x = slowed(0.3, 0.2, 0.0, 0.2, guess)
    assert x + 0.1 * (1.0 + x / math.hypot(x, 0.2)) == pytest.approx(0.3, abs=1e-8)


@pytest.mark.parametrize("before", [-2e-3, 3e-4, 1e-2])
def test_contacts_leave_the_same_twist_whatever_their_impulses_were_in_the_step_before(before):
    """The search begins with those of the step before: it saves rounds and decides nothing."""

    def braked(impulse: float) -> tuple[float, float, float]:
        bench = np.zeros(BENCH_SIZE)
        bench[STEP] = 0.01
        bench[INVERSE : INVERSE + 9] = np.diag([0.9, 0.8, 400.0]).ravel()
        add_contact(bench, 0.05, 1.0, 0.0, -0.05, 0.0, 0.0)
        add_contact(bench, 0.05, 1.0, 0.0, 0.05, 0.0, 0.0)
        add_contact(bench, 0.02, 0.0, 0.0, 1.0, 0.1, 0.4)
        add_contact(bench, 0.3, -0.075, 0.0, 0.0, ANY_WAY, ANY_WAY)
        for contact in range(4):
            bench[CONTACT + contact * CONTACT_SIZE + IMPULSE] = impulse
        return brake(bench, 0.3, 0.01, 0.6)

    assert braked(before) == pytest.approx(braked(0.0), abs=1e-7)
