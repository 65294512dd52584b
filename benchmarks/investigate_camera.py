"""How well do floor tags place a robot whose camera looks a little elsewhere than it is known to? With and without levelling.

    python3 benchmarks/investigate_camera.py [--robots 3] [--budget 60] [--diagnose]

Each robot hides a dead zone of 0.05 and drives random manoeuvres over the calibration area's markers by its own camera, whose
pitch, roll and yaw are known wrongly by some milliradians. Errors are against the world's truth, in the robot's frame: their
scatter, and their steps from one frame to the next, where other tags are seen and where the same are. --diagnose
also tells what the drives are taken for.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from itertools import compress, pairwise
from pathlib import Path

import numpy as np
from investigate import PLACES
from investigate_bounds import Ignorant, unpromised_drive

from fsm_calib.actions.investigating import Field
from fsm_calib.diagnosis.design.belief_of import belief_of
from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.runner.investigation import own_camera
from fsm_calib.runner.investigation import session as runs
from fsm_calib.runner.investigation.thinking import recording_of
from fsm_calib.runner.loop import run_to_end
from fsm_calib.runner.progress import Silent
from fsm_calib.scenario.models import Scenario
from fsm_calib.scenario.world import world_of

WRONG = 0.002
"""Standard deviation of what is wrong with the camera's pitch and roll [rad]; twice that of the yaw."""
MILLI = 1e3


def scenario(number: int, budget: float) -> Scenario:
    return Scenario.model_validate(
        {
            "name": f"camera-{number}",
            "seed": 3 + number,
            "robot": {
                "source": "nominal",
                "wheel_ratio": 1.06,
                "effects": {"motor_deadband": {"offset": 0.05}},
                **PLACES["camera"]["robot"],
            },
            "investigate": {"budget": budget, **PLACES["camera"]["investigate"]},
        }
    )


def driven(number: int, budget: float) -> runs.Investigation:
    """Return an investigation that drove by a camera that is known a little wrongly."""
    pitch, roll, yaw = np.random.default_rng([number, 4]).normal(0.0, (WRONG, WRONG, 2.0 * WRONG))
    with tempfile.TemporaryDirectory() as folder:
        before = runs.Before()
        going = runs.session(
            scenario(number, budget), Path(folder), before, False, Silent(), unpromised_drive
        )
        true, book = going.connection.world.truth.mount, going.bench.notebook
        book.mount = replace(true, pitch=true.pitch + pitch, roll=true.roll + roll, yaw=true.yaw + yaw)
        book.mount_known = "all"
        run_to_end(going.run)
        going.run.journal.close()
    print(f"{number}: pitch {MILLI * pitch:+.1f}, roll {MILLI * roll:+.1f}, yaw {MILLI * yaw:+.1f} mrad")
    return going


def errors(poses: Sequence[Sequence[float]], trace: np.ndarray) -> np.ndarray:
    """Return errors (n, 3) of poses in the robot's frame [mm, mm, mrad]."""
    rows = np.array(poses)
    x, y, theta = (np.interp(rows[:, 0], trace[:, 0], np.unwrap(trace[:, k])) for k in (1, 2, 3))
    c, s = np.cos(theta), np.sin(theta)
    dx, dy = rows[:, 1] - x, rows[:, 2] - y
    turn = np.remainder(rows[:, 3] - theta + np.pi, 2.0 * np.pi) - np.pi
    return MILLI * np.column_stack([c * dx + s * dy, c * dy - s * dx, turn])


def told(
    label: str, drives: Sequence[Field], rows: Sequence[Sequence], trace: np.ndarray, size: float
) -> None:
    """Print scatter and steps of the poses `rows` of drives over markers of side `size` [m]."""
    off = [errors(row, trace) for row in rows]
    steps = np.vstack([np.diff(e, axis=0) for e in off])
    same = np.concatenate(
        [
            [{t[0] for t in a} == {t[0] for t in b} for a, b in pairwise(compress(d.seen, good))]
            for d, good in zip(drives, own_camera.well_told(drives, size), strict=True)
        ]
    )
    scatter = np.vstack(off).std(axis=0)
    parts = (scatter, steps[same].std(axis=0), steps[~same].std(axis=0))
    print(f"  {label:9s}" + "; ".join(f"{x:.2f} {y:.2f} mm {t:.2f} mrad" for x, y, t in parts))


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--robots", type=int, default=3)
    parser.add_argument("--budget", type=float, default=60.0)
    parser.add_argument("--diagnose", action="store_true")
    asked = parser.parse_args()
    runs.Mind = Ignorant  # type: ignore[misc]
    levelled = own_camera.levelled
    print("           scatter; steps, same tags; steps, other tags")
    for number in range(asked.robots):
        going = driven(number, asked.budget)
        drives, trace = going.bench.findings.drives, going.connection.world.truth.trace
        for label, level in (("as known", lambda frames, *_: frames), ("levelled", levelled)):
            own_camera.levelled = level
            scene, mount = world_of(going.scenario).scene, going.bench.notebook.mount
            rows = own_camera.corrected(drives, scene, mount, (0.0, 0.0, 0.0, 0.0))
            told(label, drives, rows, trace, own_camera.tag_size(scene))
            if asked.diagnose:
                kept = [replace(drive, poses=row) for drive, row in zip(drives, rows, strict=True)]
                found = diagnose([recording_of(d, going.mind.facts, k) for k, d in enumerate(kept, 1)])
                belief = belief_of(found.decision)
                print(f"           taken for {belief.leader.label}, {belief.sureness:.2f} sure", flush=True)
        own_camera.levelled = levelled


if __name__ == "__main__":
    main()
