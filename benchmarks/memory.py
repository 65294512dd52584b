"""How much memory a diagnosis takes at most: `python benchmarks/memory.py [--case NAME ...] [--folder DIR]`.

Writes pairs of simulated drives with poses and encoders as manifests and gives each pair to `fsm-calib diagnose` in a
process of its own. Printed: the largest resident size of that process [MB of 10^6 bytes, as the bar counts them, and KiB as
`/usr/bin/time -v` does], its processor time and what it named. What an installation compiles once is compiled before.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from diagnosis_robots import HEADING_NOISE, POSITION_NOISE, START, drive, robot

from fsm_calib.recording.channels import CommandTrack, PoseTrack, WheelPair
from fsm_calib.recording.recording import Recording, RobotFacts
from fsm_calib.recording.writers import write_recording
from fsm_calib.world2d.observation import predict

BAR = 500.0  # MB
TICK = 2.0 * np.pi / 135  # rad of a Duckiebot's encoder


@dataclass(frozen=True)
class Case:
    """Two drives of one robot: their length [s], the rate of poses and encoders [Hz], and what the robot has."""

    seconds: float = 60.0
    rate: float = 30.0
    physics: dict[str, float] = field(default_factory=dict)


DEAD_ZONE = {"motor_deadband__offset": 0.03}
SEVERAL = {**DEAD_ZONE, "payload_offset__x": -0.02, "command_delay__delay": 0.08, "tyre_scrub__moment": 0.02}
PATCH = {
    "rough_floor_patch__drag": 1.0,
    "rough_floor_patch__half_x": 0.2,
    "rough_floor_patch__half_y": 0.2,
    "rough_floor_patch__roundness": 1.0,
}
CASES = {
    "clean": Case(),
    "dead zone": Case(physics=DEAD_ZONE),
    "four effects": Case(physics=SEVERAL),
    "rough patch": Case(physics=PATCH),
    "75 s at 50 Hz": Case(75.0, 50.0),
    "75 s at 50 Hz, dead zone": Case(75.0, 50.0, DEAD_ZONE),
}


def write(case: Case, seed: int, folder: Path) -> Path:
    """Write one drive of the case as a manifest; return its path."""
    rng = np.random.default_rng(seed)
    commands, stamps = drive(rng, case.seconds), np.arange(0.0, case.seconds, 1.0 / case.rate)
    seen = predict(robot(**case.physics), commands, stamps, START, wheel_times=stamps)
    noise = rng.normal(size=seen.poses.shape) * [POSITION_NOISE, POSITION_NOISE, HEADING_NOISE]
    angles = TICK * np.round(seen.wheel_angles / TICK)
    return write_recording(
        Recording(
            robot=RobotFacts(name="simulated", wheel_radius=0.0318, axle_length=0.1, max_wheel_rate=20.0),
            command=CommandTrack(commands.time, commands.left, commands.right),
            pose=PoseTrack(stamps, *(seen.poses + noise).T),
            wheel_angle=WheelPair(stamps, *angles.T, "rad", TICK),
            source=f"drive-{seed}",
        ),
        folder / f"drive-{seed}",
    )


def diagnose(drives: list[Path], verdict: Path) -> tuple[int, float]:
    """Diagnose in a process of its own; return its largest resident size [KiB] and its processor time [s]."""
    entry = "from fsm_calib.cli import main; main()"
    places = [str(place) for place in drives]
    process = subprocess.Popen(
        [sys.executable, "-c", entry, "diagnose", "--jobs=1", *places, "--json", str(verdict)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"fsm-calib diagnose ended with {process.returncode}")
    return usage.ru_maxrss, usage.ru_utime + usage.ru_stime


def main() -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--case", action="append", choices=CASES)
    parser.add_argument("--folder", type=Path, help="keep recordings and verdicts here")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        for name in options.case or CASES:
            folder = (options.folder or Path(scratch)) / name.replace(" ", "-")
            drives = [write(CASES[name], seed, folder) for seed in (0, 1)]
            size, seconds = diagnose(drives, folder / "verdict.json")
            answer = json.loads((folder / "verdict.json").read_text(encoding="utf-8"))
            named = ", ".join(effect["name"] for effect in answer["effects"]) or answer["verdict"]
            megabytes = size * 1024 / 1e6
            print(
                f"{name:26s} {megabytes:4.0f} MB ({size} KiB) {'' if megabytes <= BAR else 'over the bar, '}"
                f"{seconds:5.1f} s  {named}",
                flush=True,
            )


if __name__ == "__main__":
    main()
