"""One quantity for each label, of a robot with and without a law: its sign shows what the law does."""

from __future__ import annotations

import math

import numpy as np

from benchmarks.box2d_robots.checks_drives import (
    DRAW,
    Check,
    Found,
    both,
    compared,
    driven,
    slower,
    speed,
    steps,
    turns_less,
    winding,
)
from benchmarks.box2d_robots.machine import Machine, Now
from benchmarks.box2d_robots.parts import Hook, Pair, Setup
from benchmarks.box2d_robots.simulate import simulate
from benchmarks.robot_sets.driving import Poses
from benchmarks.robot_sets.laws import Law
from benchmarks.robot_sets.sensing import report


def _later(law: Law) -> Found:
    """Speed late over speed early: it changes."""

    def quantity(setup: Setup) -> float:
        drive = driven(setup, 0.7, 0.7, 14.0, (-2.0, 0.0, 0.0))
        return speed(drive, 14.0) / speed(drive, 3.0)

    if law.name in ("booster_at_its_limit", "polarised_cells"):  # they hinder most while the robot speeds up
        return slower(1.0, 1.0, 1.0)(law)
    return compared(law, quantity, lambda a, b: b < a - 0.003)


def _worked(law: Law) -> Found:
    """Speed to and fro late over speed early."""

    def quantity(setup: Setup) -> float:
        def told(t: float) -> Pair:
            return (0.8, 0.8) if t % 0.6 < 0.3 else (-0.8, -0.8)

        v = np.abs(steps(setup, told, 15.0, lambda m: float(m.now.motion[0])))
        return float(v[-900:].mean() / v[:900].mean())

    sign = -1.0 if law.name == "hot_copper" else 1.0
    return compared(law, quantity, lambda a, b: sign * (b - a) > 0.01)


def _nap(law: Law) -> Found:
    at = DRAW.between(0, -math.pi, math.pi)

    def quantity(setup: Setup) -> float:
        along, against = (speed(driven(setup, 0.5, 0.5, 3.0, (0, 0, at + t)), 3.0) for t in (0.0, math.pi))
        return along - against

    return compared(law, quantity, lambda a, b: b > a + 0.002)


def _downhill(law: Law) -> Found:
    at = DRAW.between(1 if law.name == "towards_a_drain" else 0, -math.pi, math.pi)

    def quantity(setup: Setup) -> float:
        down, up = (speed(driven(setup, 0.4, 0.4, 1.6, (0, 0, at + t)), 1.6) for t in (0.0, math.pi))
        return down - up

    return compared(law, quantity, lambda a, b: b > a + 0.002)


def _first_move(law: Law) -> Found:
    def quantity(setup: Setup) -> float:
        return float(np.argmax(driven(setup, 0.6, 0.6, 3.0).x > 0.003)) * 0.01

    return compared(law, quantity, lambda a, b: b > a)


def _point(law: Law) -> Found:
    """Speed on an arc; straight ahead nothing changes."""
    plain, other = both(law)
    ahead = [speed(driven(s, 0.5, 0.5, 2.0), 2.0) for s in (plain, other)]
    a, b, _ = compared(law, lambda s: speed(driven(s, 0.3, 0.7, 2.0), 2.0), lambda a, b: True)
    return a, b, abs(ahead[0] - ahead[1]) < 1e-6 and abs(a - b) > 0.002


def _limit(law: Law) -> Found:
    low = [speed(driven(s, 0.1, 0.1, 2.0), 2.0) for s in both(law)]
    a, b, good = slower(1.0, 1.0)(law)
    return a, b, good and abs(low[0] - low[1]) < 1e-4


def _pushed(law: Law) -> Found:
    def quantity(setup: Setup) -> float:
        drive = driven(setup, 0.0, 0.0, 12.0)
        return float(np.abs(drive.x - drive.x[100]).max() + np.abs(drive.yaw - drive.yaw[100]).max())

    return compared(law, quantity, lambda a, b: b > a + 1e-3)


def _play(law: Law) -> Found:
    """How far motor and wheel turn against each other [rad]."""

    def quantity(setup: Setup) -> float:
        def told(t: float) -> Pair:
            return (0.4, 0.4) if t < 1.0 else (-0.4, -0.4)

        gap = steps(setup, told, 2.0, lambda m: float(m.now.turned[0] - m.now.angle[0]))
        return float(np.ptp(gap))

    size = math.sqrt(law.low * law.high)
    return compared(law, quantity, lambda a, b: a == 0.0 and 0.4 * size < b < 2.0 * size)


def _outwards(law: Law) -> Found:
    """Sideways speed of the axle's middle on a left curve; outwards is negative."""

    def quantity(setup: Setup) -> float:
        return float(steps(setup, lambda t: (0.4, 0.9), 3.0, lambda m: float(m.now.motion[1]))[-500:].mean())

    return compared(law, quantity, lambda a, b: b < 1.1 * a)


def _slip(law: Law) -> Found:
    """How far the wheels roll beyond the way driven, by speeding up and braking [m]."""

    def quantity(setup: Setup) -> float:
        def told(t: float) -> Pair:
            return (0.9, 0.9) if t % 0.8 < 0.4 else (-0.9, -0.9)

        def see(machine: Machine) -> float:
            return abs(float(machine.now.rate[0]) * machine.plant.radius[0] - float(machine.now.motion[0]))

        return float(steps(setup, told, 3.0, see).mean()) * 3.0

    return compared(law, quantity, lambda a, b: b > 1.1 * a)


def _lag(law: Law) -> Found:
    """Time of slowing down over time of speeding up, to the half."""

    def quantity(setup: Setup) -> float:
        def told(t: float) -> Pair:
            return (0.7, 0.7) if t < 4.0 else (0.0, 0.0)

        v = steps(setup, told, 9.0, lambda m: float(m.now.motion[0]))
        top = v[1999]
        return float((np.argmax(v[2000:] < 0.5 * top) + 1) / (np.argmax(v > 0.5 * top) + 1))

    sign = -1.0 if law.name == "soft_start" else 1.0
    return compared(law, quantity, lambda a, b: sign * (b - a) > 0.1 * a)


def _dead(law: Law) -> Found:
    sign = 1.0 if law.name == "overcompensated" else -1.0
    return compared(law, lambda s: speed(driven(s, 0.2, 0.2, 3.0), 3.0), lambda a, b: sign * (b - a) > 0.002)


def _bend(law: Law) -> Found:
    def quantity(setup: Setup) -> float:
        return speed(driven(setup, 0.3, 0.3, 3.0), 3.0) / speed(driven(setup, 0.9, 0.9, 3.0), 3.0)

    return compared(
        law, quantity, lambda a, b: (b < 0.95 * a) == (law.name == "stick_expo") and abs(b - a) > 0.01
    )


def _backwards(law: Law) -> Found:
    def quantity(setup: Setup) -> float:
        return -speed(driven(setup, -0.6, -0.6, 3.0), 3.0) / speed(driven(setup, 0.6, 0.6, 3.0), 3.0)

    return compared(law, quantity, lambda a, b: abs(b / a - 1.0) > 0.01)


def _steps_of_speed(law: Law) -> Found:
    """How many speeds twelve near duties give."""

    def quantity(setup: Setup) -> float:
        speeds = {round(speed(driven(setup, u, u, 2.0), 2.0), 4) for u in np.linspace(0.4, 0.5, 12)}
        return float(len(speeds))

    return compared(law, quantity, lambda a, b: b < a - 3)


def _turned(law: Law) -> Found:
    """Heading after half a minute of driving straight."""
    return compared(
        law,
        lambda s: float(np.abs(driven(s, 0.2, 0.2, 26.0, (-2.5, 0.0, 0.0)).yaw).max()),
        lambda a, b: b > a + 0.02,
    )


def _seen(law: Law) -> Found:
    """How far what is seen is from what was, in metres and radians."""
    plain, other = both(law)
    drive = driven(plain, 0.25, 0.35, 40.0, (0.02, -0.3, 0.0))
    stamps = np.arange(1.0, 39.0, 0.1)
    one, two = (report(s, drive, stamps, 0)[0] for s in (plain, other))  # type: ignore[arg-type]

    def off(k: int) -> float:
        return float(np.abs(two[k] - one[k]).max())

    found = off(2) if law.label in ("sensor_yaw",) else off(0)
    return 0.0, found, found > 1e-3 and (law.label != "sensor_yaw" or off(0) == 0.0)


def _payload(law: Law) -> Found:
    """How far the centre of mass lies from the axle's middle; the robot turns on the spot with more
    trouble.
    """
    plain, other = both(law)
    a, b = (math.hypot(*s.plant.centre[:2]) for s in (plain, other))
    turns = [
        float(steps(s, lambda t: (-0.5, 0.5), 0.1, lambda m: float(m.now.motion[2]))[-1])
        for s in (plain, other)
    ]
    return a, b, b > a + 0.01 and turns[1] < turns[0]


def _stiff(law: Law) -> Found:
    """Wheel rate that is lost to a load on the wheels, as a share."""

    def quantity(setup: Setup) -> float:
        def braked(machine: Machine, run: int) -> Hook:
            def hook(now: Now) -> None:
                now.torque[:] = -0.25 * setup.plant.stall()

            return hook

        free = speed(driven(setup, 0.5, 0.5, 3.0), 3.0)
        setup.motor.append(braked)
        held = speed(driven(setup, 0.5, 0.5, 3.0), 3.0)
        setup.motor.pop()
        return 1.0 - held / free

    return compared(law, quantity, lambda a, b: b < 0.95 * a)


def _wobble(law: Law) -> Found:
    """Unevenness of the turn rate and speed while driving straight."""

    def quantity(setup: Setup) -> float:
        v = steps(setup, lambda t: (0.3, 0.3), 4.0, lambda m: float(m.now.motion[0] + 0.1 * m.now.motion[2]))
        return float(v[1000:].std() / v[1000:].mean())

    return compared(law, quantity, lambda a, b: b > a + 0.002)


def _unlike(law: Law) -> Found:
    """Way and turn of a winding drive: other than without."""
    plain, other = both(law)

    def poses(setup: Setup) -> Poses:
        drive = simulate(setup, winding(), 26.0, 0, (0.0, -0.1, 0.0))
        return drive.x, drive.y, drive.yaw

    one, two = poses(plain), poses(other)
    off = float(np.sqrt(np.mean((one[0] - two[0]) ** 2 + (one[1] - two[1]) ** 2)))
    return 0.0, off, off > 2e-3


CHECKS: dict[str, Check] = {
    "battery_sag": _later,
    "carpet_nap": _nap,
    "caster_drag": slower(0.3, 0.5),
    "clock_drift": _seen,
    "command_delay": _first_move,
    "command_point": _point,
    "command_saturation": _limit,
    "coulomb_friction": slower(0.5, 0.5),
    "external_push": _pushed,
    "floor_tilt": _downhill,
    "gear_backlash": _play,
    "lateral_slip": _outwards,
    "low_friction_patch": _slip,
    "misplaced_marker": _seen,
    "motor_asymmetric_lag": _lag,
    "motor_deadband": _dead,
    "motor_fault": _turned,
    "motor_gain_curve": _bend,
    "motor_reverse_asymmetry": _backwards,
    "motor_warmup": _worked,
    "observation_delay": _seen,
    "outside": _unlike,
    "payload_offset": _payload,
    "pwm_steps": _steps_of_speed,
    "rough_floor_patch": slower(0.3, 0.3, 1.4),
    "sensor_offset": _seen,
    "sensor_yaw": _seen,
    "skid_steer": turns_less,
    "speed_controller": _stiff,
    "tyre_scrub": turns_less,
    "wheel_eccentricity": _wobble,
    "wheel_slip": _slip,
}
