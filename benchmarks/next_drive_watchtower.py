"""Would the planned drive tell the watchtower robot's three explanations apart?

    python3 benchmarks/next_drive_watchtower.py RECORDINGS/duckiebot-watchtower [--draws 40] [--first 0] [--alone] [--jobs 2]

Its laps are explained three times, by each of motor_deadband, tyre_scrub and caster_drag with whatever joins it and
without the other two. The next drive is designed for the three as equals; then each is simulated as fitted to the
laps, on the laps' commands and on the drive, with the laps' estimated noise on speeds (Ornstein-Uhlenbeck) and poses.
Laps and drive are diagnosed together, as `diagnose laps next-drive` does, or the drive alone, by the three and their
company. Right: the answer has the true name, and neither of the others, not as a set either.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from time import perf_counter

import numpy as np

from fsm_calib.diagnosis.design.area import Area
from fsm_calib.diagnosis.design.belief import Belief, Hypothesis
from fsm_calib.diagnosis.design.belief_of import belief_of
from fsm_calib.diagnosis.design.designer import design, played
from fsm_calib.diagnosis.design.foresight import Holds, drive_of
from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.diagnosis.replay.settings import DEFAULT_SETTINGS, Settings
from fsm_calib.recording import read_recording
from fsm_calib.recording.channels import CommandTrack, PoseTrack
from fsm_calib.recording.recording import Recording
from fsm_calib.types import FloatArray, Pose2
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.rollout import Drive, simulate

LAPS = ("b2-run3.recording.yaml", "b2-run5.recording.yaml")
RIVALS = ("motor_deadband", "tyre_scrub", "caster_drag")
STEP = 0.01


def planned(belief: Belief, values: FloatArray, holds: Holds, rng: np.random.Generator) -> Recording:
    """Return the planned drive of a robot with `values` (p,), from rest until it rests again."""
    drive, end = drive_of(holds)
    stamps = np.arange(0.0, end + 0.5, 1.0 / belief.frame_rate)
    return seen(belief, values, drive, stamps, Pose2(), rng)


def driven_again(belief: Belief, values: FloatArray, lap: Recording, rng: np.random.Generator) -> Recording:
    """Return a lap as a robot with `values` (p,) drives it, from where it was seen with the first command."""
    command, seen_at = lap.command, lap.pose.time >= lap.command.time[0]
    stamps, start = lap.pose.time[seen_at], [v[seen_at][0] for v in (lap.pose.x, lap.pose.y, lap.pose.theta)]
    drive = Drive(command.time, command.left, command.right)
    return seen(belief, values, drive, stamps, Pose2(*map(float, start)), rng)


def seen(
    belief: Belief,
    values: FloatArray,
    drive: Drive,
    stamps: FloatArray,
    start: Pose2,
    rng: np.random.Generator,
) -> Recording:
    """Return a drive of a robot with `values` (p,), seen at `stamps` (n,) [s], disturbed and measured with the noise of
    the laps.
    """
    time = np.arange(min(drive.time[0], stamps[0]), max(drive.time[-1] + 1.0, stamps[-1] + STEP), STEP)
    states = simulate(values, drive, time, (start.x, start.y, start.theta), dt=STEP)
    noise, keep = belief.noise, np.exp(-STEP / belief.noise.memory)
    sizes = np.array([noise.forward, noise.sideways, noise.turning])
    error, errors = sizes * rng.standard_normal(3), np.empty((len(time), 3))
    for k in range(len(time)):
        error = keep * error + np.sqrt(1.0 - keep**2) * sizes * rng.standard_normal(3)
        errors[k] = error
    moving = np.clip((np.abs(states[:, 3]) + 0.05 * np.abs(states[:, 5]) - 0.008) / 0.017, 0.0, 1.0)
    v, side, turn = (states[:, [3, 4, 5]] + errors * moving[:, None]).T
    theta = _summed(turn, start.theta)
    x = _summed(v * np.cos(theta) - side * np.sin(theta), start.x)
    y = _summed(v * np.sin(theta) + side * np.cos(theta), start.y)
    poses = np.column_stack([np.interp(stamps, time, column) for column in (x, y, theta)])
    poses += rng.standard_normal(poses.shape) * (noise.position, noise.position, noise.heading)
    command = CommandTrack(drive.time, drive.left, drive.right)
    return Recording(
        robot=belief.robot, command=command, pose=PoseTrack(stamps, *poses.T), source="simulated"
    )


def _summed(rate: FloatArray, start: float) -> FloatArray:
    """Return where something is that begins at `start` and changes at a `rate` (n,) from step to step."""
    return start + np.concatenate([[0.0], np.cumsum(rate[:-1]) * STEP])


def explained_by(name: str, laps: list[Recording], settings: Settings) -> Belief:
    """What the laps leave to believe where the other two of the rivals are no explanation."""
    others = [other for other in RIVALS if other != name]
    return belief_of(diagnose(laps, without=others, settings=settings).decision)


def likeliest(belief: Belief, name: str) -> Hypothesis:
    """The likeliest explanation that has a name."""
    return max((h for h in belief.hypotheses if name in h.names), key=lambda h: h.probability)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--draws", type=int, default=40)
    parser.add_argument("--first", type=int, default=0, help="number of the first draw, to share draws out")
    parser.add_argument("--alone", action="store_true", help="diagnose the drive without the laps")
    parser.add_argument("--jobs", type=int, default=1, help="processes that fit side by side")
    asked = parser.parse_args()
    settings = replace(DEFAULT_SETTINGS, processes=asked.jobs)
    laps = [read_recording(asked.folder / name) for name in LAPS]
    beliefs = {name: explained_by(name, laps, settings) for name in RIVALS}
    truths = {name: likeliest(belief, name) for name, belief in beliefs.items()}
    print("fitted to the laps:", ", ".join(truth.label for truth in truths.values()))
    equal = tuple(replace(truth, probability=1.0 / len(RIVALS)) for truth in truths.values())
    belief = replace(beliefs["tyre_scrub"], hypotheses=equal)
    began = perf_counter()
    plan = design(belief, Area(), Pose2(), np.random.default_rng(0), played(40.0))
    print(f"designed in {perf_counter() - began:.2f} s: {plan.seconds:.1f} s of driving in 2 x 2 m")
    for way in plan.manoeuvres:
        print(f"  {way.start:5.1f} s  {way.name}")
    print(f"sure before {plan.forecast.sureness_before:.2f}, promised after {plan.forecast.sureness:.2f}")
    asked_for = {*RIVALS, *(name for truth in truths.values() for name in truth.names)}
    others = [name for name in registry() if name not in asked_for]
    right = dict.fromkeys(RIVALS, 0)
    for count, draw in enumerate(range(asked.first, asked.first + asked.draws), 1):
        for name in RIVALS:
            rng = np.random.default_rng([RIVALS.index(name), draw])
            values = truths[name].values
            recordings = [planned(beliefs[name], values, plan.holds, rng)]
            if not asked.alone:
                recordings += [driven_again(beliefs[name], values, lap, rng) for lap in laps]
            decision = diagnose(recordings, without=others, settings=settings).decision
            said = set().union(*[set(known.among) for known in decision.named]) & set(RIVALS)
            right[name] += said == {name}
            if said != {name}:
                evidence = [(r.name, round(r.evidence)) for r in decision.ranking]
                print(f"  {name} not told apart: {sorted(said)}, {evidence}")
        told = ", ".join(f"{name} {n}" for name, n in right.items())
        print(f"told apart in {sum(right.values())} of {count * len(RIVALS)} draws: {told}", flush=True)


if __name__ == "__main__":
    main()
