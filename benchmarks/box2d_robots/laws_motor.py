"""Laws of motors and gears: dry friction, play, faults, and motors unlike backwards."""

from __future__ import annotations

import math

import numpy as np

from benchmarks.box2d_robots.laws import law
from benchmarks.box2d_robots.machine import Machine, Now
from benchmarks.box2d_robots.parts import Hook, Setup
from benchmarks.robot_sets.laws import Draw

DUTY = ("duty",)


@law(
    "coulomb_friction",
    "stiff_seals",
    (0.002, 0.5),
    "1",
    "seals and bushings: dry torque, more to break away than to keep going (Stribeck; "
    "Armstrong-Helouvry 1991)",
    DUTY,
)
def stiff_seals(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    torque, slow = size * setup.plant.stall(), 0.05 * setup.plant.free()

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            for k in (0, 1):
                x = float(now.rate[k]) / slow
                now.dry[k] += torque * (1.0 + 0.5 * math.exp(-x * x))

        return hook

    setup.motor.append(make)
    return {"torque_Nm": torque}


@law(
    "coulomb_friction",
    "worm_gear",
    (0.01, 0.8),
    "1",
    "a worm's teeth slide: dry torque from its preload and in proportion to the torque it passes (Shigley)",
    DUTY,
)
def worm_gear(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    preload = 0.25 * setup.plant.stall()

    def make(machine: Machine, run: int) -> Hook:
        passed = [0.0, 0.0]

        def hook(now: Now) -> None:
            for k in (0, 1):
                torque = abs(float(now.torque_const[k] * now.amps[k]))
                passed[k] += 0.15 * (torque - passed[k])
                now.dry[k] += size * (preload + 0.6 * passed[k])

        return hook

    setup.motor.append(make)
    return {"friction": size}


@law(
    "coulomb_friction",
    "dragging_brake",
    (0.002, 0.5),
    "1",
    "parking brakes that do not come free drag on both wheels, on one more than on the other",
    DUTY,
)
def dragging_brake(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    torque, share = size * setup.plant.stall(), draw.between(0, 0.6, 1.4)

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            now.dry[0] += torque * share
            now.dry[1] += torque * (2.0 - share)

        return hook

    setup.motor.append(make)
    return {"left_Nm": torque * share, "right_Nm": torque * (2.0 - share)}


@law(
    "gear_backlash",
    "worn_teeth",
    (0.004, 0.9),
    "rad",
    "worn teeth: rotor and wheel are two bodies that meet at the ends of a gap (dead-zone spring, "
    "Nordin 2002)",
)
def worn_teeth(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            now.play[:] = 0.5 * size

        return hook

    setup.motor.append(make)
    return {"play_rad": size}


@law(
    "gear_backlash",
    "loose_hub",
    (0.004, 1.2),
    "rad",
    "set screws have worn flats on the shafts: wheels rock on them, one more than the other (maker forums)",
)
def loose_hub(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    share = draw.between(0, 0.25, 0.6)
    left, right = (size, share * size) if draw.numbers[1] < 0.5 else (share * size, size)

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            now.play[0], now.play[1] = 0.5 * left, 0.5 * right

        return hook

    setup.motor.append(make)
    return {"left_rad": left, "right_rad": right}


@law(
    "gear_backlash",
    "eccentric_pinion",
    (0.004, 0.9),
    "rad",
    "a pinion off its centre: the play opens and closes as the gear turns (AGMA 2002, composite error)",
)
def eccentric_pinion(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    phase = draw.between(0, 0.0, 2.0 * math.pi)

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            for k in (0, 1):
                now.play[k] = 0.5 * size * (1.0 + 0.6 * math.cos(float(now.angle[k]) + phase + k))

        return hook

    setup.motor.append(make)
    return {"mean_play_rad": size}


def spells(seed: int, run: int, seconds: float, length: tuple[float, float]) -> list[tuple[float, float]]:
    """Return when something happens in a run: about every 12 s, for a time within `length` [s]."""
    rng, begin, found = np.random.default_rng([seed, run, 7]), 4.0, []
    while begin < seconds - 6.0:
        start = begin + float(rng.uniform(0.0, 6.0))
        end = start + float(rng.uniform(*length))
        found.append((start, end))
        begin = max(begin + 12.0, end + 4.0)
    return found


def _during(now: Now, times: list[tuple[float, float]]) -> bool:
    while times and now.t > times[0][1]:
        times.pop(0)
    return bool(times) and now.t >= times[0][0]


@law(
    "motor_fault",
    "bouncing_brush",
    (0.004, 0.99),
    "1",
    "a worn brush lifts off for milliseconds: for a while the winding's circuit is broken again and again",
    DUTY,
    local=True,
)
def bouncing_brush(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    side = int(draw.numbers[0] < 0.5)

    def make(machine: Machine, run: int) -> Hook:
        rng, times, off = (
            np.random.default_rng([draw.seed, run]),
            spells(draw.seed, run, 70.0, (2.5, 5.0)),
            [0.0, 0.0],
        )

        def hook(now: Now) -> None:
            if not _during(now, times):
                return
            now.touched = True
            if now.t >= off[1]:
                off[0] = float(rng.random() < size)
                off[1] = now.t + float(rng.exponential(0.02))
            if off[0]:
                now.winding[side] *= 20.0

        return hook

    setup.motor.append(make)
    return {"share_off": size, "right": float(side)}


@law(
    "motor_fault",
    "thermal_foldback",
    (0.004, 0.97),
    "1",
    "the driver chip of one motor gets hot and folds its current back until it has cooled (TI, "
    "DRV8871 data sheet)",
    DUTY,
    local=True,
)
def thermal_foldback(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    side = int(draw.numbers[0] < 0.5)

    def make(machine: Machine, run: int) -> Hook:
        times, left = spells(draw.seed, run, 70.0, (3.0, 6.0)), [1.0]

        def hook(now: Now) -> None:
            inside = _during(now, times)
            left[0] += now.step / 0.3 * ((1.0 - size if inside else 1.0) - left[0])
            if inside or left[0] < 0.98:
                now.touched = True
                now.duty[side] *= left[0]

        return hook

    setup.drive.append(make)
    return {"lost": size, "right": float(side)}


@law(
    "motor_reverse_asymmetry",
    "advanced_brushes",
    (0.01, 0.6),
    "1",
    "brushes set ahead of the neutral plane for one sense of turning (timing of model-car motors): "
    "the other sense has"
    " less torque and less speed",
    DUTY,
)
def advanced_brushes(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    sense = draw.sign(0)  # the worse one: -1 is backwards

    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            for k in (0, 1):
                bad = 0.5 - 0.5 * math.tanh(-sense * float(now.rate[k]) / 0.3)
                now.torque_const[k] *= 1.0 - 0.5 * size * bad
                now.emf_const[k] *= 1.0 + 0.7 * size * bad

        return hook

    setup.motor.append(make)
    return {"worse": size, "sense": sense}


@law(
    "motor_reverse_asymmetry",
    "tired_half_bridge",
    (0.02, 4.0),
    "1",
    "the transistors of one diagonal have burnt to a higher resistance: in series with the winding "
    "one way only",
    DUTY,
)
def tired_half_bridge(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    def make(machine: Machine, run: int) -> Hook:
        def hook(now: Now) -> None:
            for k in (0, 1):
                if now.duty[k] < 0.0:
                    now.winding[k] *= 1.0 + size
                    now.volts[k] *= 1.0 - 0.08 * size / (1.0 + size)

        return hook

    setup.motor.append(make)
    return {"ohm_over_winding": size}
