"""Kills workers and the command of a real fleet at random, gives the command again, and compares with no kill.

    python benchmarks/study_kill.py [--robots 4] [--kills 4]

Each round ends one worker process or the whole command by SIGKILL after a random time; the last round runs to the
end. The bar: nothing lost, nothing run twice, and the same results bit for bit as a fleet that nobody disturbed.
"""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np
from kept_rows import kept_rows

from fsm_calib.study.store import result_of_row

STUDY = """
name: kill
seed: 31
parts: [test_2]
scenario:
  plan: [orientation, wheels]
  robot: {known: {camera: true}}
"""
LONGEST_WAIT = 25.0
"""A kill comes within this time of the command's start [s]."""


def start(file: Path, out: Path, robots: int) -> subprocess.Popen:
    code = "from fsm_calib.cli import main; main()"
    arguments = ["study", str(file), "--out", str(out), "--robots", str(robots), "--jobs", "2"]
    return subprocess.Popen(
        [sys.executable, "-c", code, *arguments], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )


def workers_of(process: subprocess.Popen) -> list[int]:
    """Return the numbers of the worker processes of a command."""
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    numbers = [int(number) for number in children.read_text().split()] if children.exists() else []
    return [number for number in numbers if b"loky" in Path(f"/proc/{number}/cmdline").read_bytes()]


def rows_in(out: Path) -> list[dict]:
    return kept_rows(out / "results.jsonl")


def as_text(rows: list[dict]) -> list[str]:
    return sorted(json.dumps(result_of_row(row), sort_keys=True) for row in rows)


def disturb(process: subprocess.Popen, kind: str, wait: float) -> None:
    """Kill a worker, or the command, after `wait` [s]."""
    time.sleep(wait)
    if process.poll() is not None:
        return
    if kind == "command":
        process.kill()
    elif found := workers_of(process):
        os.kill(found[0], signal.SIGKILL)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--robots", type=int, default=4)
    parser.add_argument("--kills", type=int, default=4)
    arguments = parser.parse_args()
    rng = np.random.default_rng(1)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "kill.yaml"
        file.write_text(STUDY)
        calm, out = Path(folder) / "calm", Path(folder) / "killed"
        start(file, calm, arguments.robots).wait()
        kept: list[dict] = []
        for number in range(arguments.kills):
            kind = ("worker", "command")[number % 2]
            process = start(file, out, arguments.robots)
            wait = float(rng.uniform(4.0, LONGEST_WAIT))
            disturb(process, kind, wait)
            if kind == "worker":
                time.sleep(5.0)
                process.kill()
            process.wait()
            now = rows_in(out)
            assert_kept(kept, now)
            kept = now
            print(
                f"killed a {kind} after {wait:.1f} s: {len(kept)} of {arguments.robots} robots on disk",
                flush=True,
            )
        start(file, out, arguments.robots).wait()
        rows = rows_in(out)
        counts = Counter(row["robot"] for row in rows)
        print(
            f"lost: {arguments.robots - len(counts)}, twice: {sum(n > 1 for n in counts.values())}, ", end=""
        )
        print(f"equal to the undisturbed fleet: {as_text(rows) == as_text(rows_in(calm))}")


def assert_kept(before: list[dict], now: list[dict]) -> None:
    if now[: len(before)] != before:
        raise SystemExit("rows that were on disk have changed")


if __name__ == "__main__":
    main()
