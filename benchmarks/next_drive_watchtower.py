"""Would the planned drive tell the watchtower robot's three explanations apart?

    python3 benchmarks/next_drive_watchtower.py RECORDINGS/duckiebot-watchtower [--draws 40]

Its laps alone leave motor_deadband, tyre_scrub and caster_drag open. The next drive is designed from them; then each
of the three is simulated on it as fitted to the laps, with the laps' estimated noise on speeds (Ornstein-Uhlenbeck)
and poses; and laps and new drive are diagnosed together, by the three alone. Right: the true name leads, and beats the
next so surely that it would stand without it (`proof/gap.py`).
"""

from __future__ import annotations

import argparse
from pathlib import Path
from time import perf_counter

import numpy as np

from fsm_calib.diagnosis.design.area import Area
from fsm_calib.diagnosis.design.belief_of import belief_of
from fsm_calib.diagnosis.design.designer import design, played
from fsm_calib.diagnosis.design.foresight import drive_of
from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.diagnosis.proof.gap import TOLD_APART, gap_between
from fsm_calib.recording import read_recording
from fsm_calib.recording.channels import CommandTrack, PoseTrack
from fsm_calib.recording.recording import Recording
from fsm_calib.types import Pose2
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.rollout import simulate

LAPS = ("b2-run3.recording.yaml", "b2-run5.recording.yaml")
RIVALS = ("motor_deadband", "tyre_scrub", "caster_drag")
STEP = 0.01


def driven(belief, values, holds, rng) -> Recording:
    """The planned drive of a robot with `values`, disturbed and measured with the laps' noise."""
    drive, end = drive_of(holds)
    time = np.arange(0.0, end + 1.0, STEP)
    states = simulate(values, drive, time, np.zeros(3), dt=STEP)
    noise, keep = belief.noise, np.exp(-STEP / belief.noise.memory)
    sizes = np.array([noise.forward, noise.sideways, noise.turning])
    error, errors = sizes * rng.standard_normal(3), np.empty((len(time), 3))
    for k in range(len(time)):
        error = keep * error + np.sqrt(1.0 - keep**2) * sizes * rng.standard_normal(3)
        errors[k] = error
    moving = np.clip((np.abs(states[:, 3]) + 0.05 * np.abs(states[:, 5]) - 0.008) / 0.017, 0.0, 1.0)
    v, side, turn = (states[:, [3, 4, 5]] + errors * moving[:, None]).T
    theta = np.concatenate([[0.0], np.cumsum(turn[:-1]) * STEP])
    x = np.concatenate([[0.0], np.cumsum((v * np.cos(theta) - side * np.sin(theta))[:-1]) * STEP])
    y = np.concatenate([[0.0], np.cumsum((v * np.sin(theta) + side * np.cos(theta))[:-1]) * STEP])
    stamps = np.arange(0.0, end + 0.5, 1.0 / belief.frame_rate)
    poses = np.column_stack([np.interp(stamps, time, column) for column in (x, y, theta)])
    poses += rng.standard_normal(poses.shape) * (noise.position, noise.position, noise.heading)
    command = CommandTrack(drive.time, drive.left, drive.right)
    return Recording(robot=belief.robot, command=command, pose=PoseTrack(stamps, *poses.T), source="planned")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--draws", type=int, default=40)
    asked = parser.parse_args()
    laps = [read_recording(asked.folder / name) for name in LAPS]
    belief = belief_of(diagnose(laps).decision)
    print("after the laps:", ", ".join(f"{h.label} {h.probability:.3f}" for h in belief.hypotheses))
    began = perf_counter()
    plan = design(belief, Area(), Pose2(), np.random.default_rng(0), played(40.0))
    print(f"designed in {perf_counter() - began:.2f} s: {plan.seconds:.1f} s of driving in 2 x 2 m")
    for way in plan.manoeuvres:
        print(f"  {way.start:5.1f} s  {way.name}")
    print(f"sure before {plan.forecast.sureness_before:.2f}, promised after {plan.forecast.sureness:.2f}")
    total = 0
    for name in reversed(RIVALS):
        truth = max((h for h in belief.hypotheses if name in h.names), key=lambda h: h.probability)
        others = [n for n in registry() if n not in {*RIVALS, *truth.names}]
        right, gaps = 0, []
        for draw in range(asked.draws):
            rng = np.random.default_rng([RIVALS.index(name), draw])
            recording = driven(belief, truth.values, plan.holds, rng)
            decision = diagnose([*laps, recording], without=others).decision
            first, second = decision.ranking[:2]
            gap = gap_between(decision.engine, first.fit, second.fit)
            gaps.append(gap.evidence if first.name == name else -gap.evidence)
            is_right = first.name == name and gap.probability >= TOLD_APART
            right += is_right
            if not is_right:
                print("   not told apart:", [(r.name, round(r.evidence)) for r in decision.ranking])
        total += right
        print(f"{name}: told apart in {right} of {asked.draws} draws, median gap {np.median(gaps):.0f}")
    print(f"in all: {total} of {asked.draws * len(RIVALS)}")


if __name__ == "__main__":
    main()
