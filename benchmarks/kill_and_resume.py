"""Kills a run with SIGKILL at random events, resumes it, and compares result.json with that of a run left alone.

    python benchmarks/kill_and_resume.py [SCENARIO] [--kills 20] [--seed 0]

Everything but the wall times must be equal. The journals must be equal, too, byte for byte.
"""

from __future__ import annotations

import argparse
import json
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parent.parent
POLL = 0.005
"""Time between two looks at the journal [s]."""


def command(scenario: Path, *arguments: str) -> list[str]:
    return [sys.executable, "-c", "from fsm_calib.cli import main; main()", "run", str(scenario), *arguments]


def result_without_times(directory: Path) -> dict:
    result = json.loads((directory / "result.json").read_text())
    result["seconds"] = {"simulated": result["seconds"]["simulated"]}
    return result


def lines(path: Path) -> int:
    return path.read_bytes().count(b"\n") if path.exists() else 0


def kill_at(scenario: Path, directory: Path, event: int) -> int:
    """Start a run, kill it when its journal holds `event` lines, return how many it holds then."""
    journal = directory / "journal.jsonl"
    with subprocess.Popen(command(scenario, "--out", str(directory)), stderr=subprocess.DEVNULL) as process:
        while process.poll() is None and lines(journal) < event:
            time.sleep(POLL)
        process.send_signal(signal.SIGKILL)
    return lines(journal)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenario", nargs="?", type=Path, default=ROOT / "scenarios/full_calibration.yaml")
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    rng = np.random.default_rng(options.seed)
    with tempfile.TemporaryDirectory() as folder:
        whole = Path(folder, "whole")
        subprocess.run(command(options.scenario, "--out", str(whole)), capture_output=True, check=False)
        expected, journal = result_without_times(whole), (whole / "journal.jsonl").read_bytes()
        events = sorted(rng.integers(0, expected["events"], options.kills).tolist())
        different = 0
        for number, event in enumerate(events):
            directory = Path(folder, f"killed{number}")
            reached = kill_at(options.scenario, directory, event)
            resumed = command(options.scenario, "--resume", str(directory))
            subprocess.run(resumed, capture_output=True, check=False)
            same_result = result_without_times(directory) == expected
            same_journal = (directory / "journal.jsonl").read_bytes() == journal
            different += not (same_result and same_journal)
            print(f"killed at event {reached:4d}: result {same_result}, journal {same_journal}", flush=True)
    print(f"{options.kills - different} of {options.kills} resumed runs end as the run left alone")
    return int(different > 0)


if __name__ == "__main__":
    sys.exit(main())
