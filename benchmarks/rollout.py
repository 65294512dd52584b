"""How fast the roll-out is, how accurate its step, how well pymunk agrees: `python3 benchmarks/rollout.py`.

Speed: processor time of one core for a drive of 60 s (random legs of 0.6 s), best of 200 (100 with an effect), compiled before. Accuracy: the
same drive against steps of 0.1 ms. Agreement: the pymunk body and the roll-out, both with steps of 2 ms, no contact.
"""

from __future__ import annotations

import time

import numpy as np
import pymunk

from fsm_calib.types import WheelCommand
from fsm_calib.world2d.body import RobotBody
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import null_parameters, typical_parameters
from fsm_calib.world2d.rollout import FIT_STEP, WORLD_STEP, Drive, simulate

SECONDS = 60.0


def random_drive() -> Drive:
    rng = np.random.default_rng(0)
    starts = np.arange(0.0, SECONDS, 0.6)
    return Drive(starts, rng.uniform(-0.5, 0.5, starts.size), rng.uniform(-0.5, 0.5, starts.size))


def best_time(parameters: np.ndarray, dt: float, repeats: int = 30) -> float:
    drive, samples = random_drive(), np.arange(0.0, SECONDS, 0.05)
    times = []
    for _ in range(repeats):
        begin = time.process_time()
        simulate(parameters, drive, samples, (0, 0, 0), dt=dt)
        times.append(time.process_time() - begin)
    return min(times)


def print_speed() -> None:
    begin = time.perf_counter()
    simulate(null_parameters(), random_drive(), np.arange(0.0, 1.0, 0.05), (0, 0, 0))
    print(
        f"first call (compiles, or loads what an earlier process compiled): {time.perf_counter() - begin:.1f} s"
    )
    print("effect                        M steps/s   (one core, 60 s at 2 ms)")
    base = best_time(null_parameters(), WORLD_STEP, 200)
    print(f"{'base robot':28s} {SECONDS / WORLD_STEP / base / 1e6:10.1f}")
    for effect in registry().values():
        seconds = best_time(typical_parameters(effect), WORLD_STEP, 100)
        print(f"{effect.name:28s} {SECONDS / WORLD_STEP / seconds / 1e6:10.1f}")


def print_accuracy() -> None:
    drive, samples = random_drive(), np.arange(0.0, SECONDS, 0.05)
    exact = simulate(null_parameters(), drive, samples, (0, 0, 0), dt=1e-4)[:, :3]
    for dt in (WORLD_STEP, FIT_STEP):
        error = simulate(null_parameters(), drive, samples, (0, 0, 0), dt=dt)[:, :3] - exact
        over_2s = np.sqrt(np.mean((error[40:] - error[:-40]) ** 2, axis=0))
        print(
            f"step {dt * 1e3:.0f} ms: error over 2 s {over_2s[:2].max() * 1e3:.3f} mm, {over_2s[2] * 1e3:.3f} mrad rms"
        )


def print_agreement() -> None:
    drive, count = random_drive(), 5000
    robot = RobotBody(pymunk.Space(), null_parameters())
    begin = time.process_time()
    for i in range(count):
        row = int(np.searchsorted(drive.time, i * WORLD_STEP + 1e-9, side="right")) - 1
        robot.step(WheelCommand(drive.left[row], drive.right[row]), WORLD_STEP)
    speed = count / (time.process_time() - begin)
    end = simulate(null_parameters(), drive, np.arange(count + 1) * WORLD_STEP, (0, 0, 0), dt=WORLD_STEP)[
        -1, :3
    ]
    gap = np.abs(end - [robot.pose.x, robot.pose.y, robot.pose.theta]).max()
    print(f"pymunk body: {speed:.0f} steps/s; differs from the roll-out by {gap:.1e} after {count} steps")


if __name__ == "__main__":
    print_speed()
    print_accuracy()
    print_agreement()
