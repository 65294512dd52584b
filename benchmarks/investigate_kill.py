"""Kills investigations with SIGKILL at random moments, resumes them, and compares the answers with ones left alone.

    python benchmarks/investigate_kill.py [--kills 20] [--robots 4] [--budget 40] [--seed 0] [--out out/investigate_kill.jsonl]

Robots are those of `investigate.py --drawn`. Each is investigated once by a process that nobody disturbs; then again and
again by one that dies up to `LATER` after a random event, whatever it does then, and is taken up with --resume. Everything
but the wall times must be equal, and the journals byte for byte. A second call goes on with the next robot.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import yaml
from investigate import drawn, robot
from kept_rows import kept_rows

TIMES = ("seconds", "seconds_by_part")
LATER = 1.0
"""A kill comes up to so much after its event [s]: an event may be followed by seconds of thought."""
POLL = 0.005
"""Time between two looks at the journal [s]."""


def command(*arguments: str) -> list[str]:
    return [sys.executable, "-m", "fsm_calib.cli", "investigate", *arguments]


def answer(directory: Path) -> dict | None:
    """Return what an investigation says, without wall times; None where it did not end."""
    file = directory / "investigation.json"
    if not file.exists():
        return None
    return {name: value for name, value in json.loads(file.read_text()).items() if name not in TIMES}


def events(directory: Path) -> int:
    journal = directory / "journal.jsonl"
    return journal.read_bytes().count(b"\n") if journal.exists() else 0


def killed(given: list[str], directory: Path, event: int, later: float) -> int:
    """Run a command, kill it `later` [s] after its journal has so many events, and return how many it has then."""
    process = subprocess.Popen(given, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while process.poll() is None and events(directory) < event:
        time.sleep(POLL)
    try:
        process.wait(later)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
    return events(directory)


def kills(number: int, count: int, budget: float, seed: int, folder: Path) -> list[dict]:
    """Investigate one robot undisturbed, and `count` times with a kill; return how each kill went."""
    kind, *names = drawn(seed, number)
    scenario = robot(number, kind, tuple(names), budget, seed)
    file, whole = folder / "scenario.yaml", folder / "whole"
    file.write_text(yaml.safe_dump(scenario.model_dump(mode="json", exclude_unset=True)))
    subprocess.run(command(str(file), "--out", str(whole)), capture_output=True, check=False)
    expected, journal = answer(whole), (whole / "journal.jsonl").read_bytes()
    rng, rows = np.random.default_rng([seed, number, 2]), []
    for kill in range(count):
        directory, event = folder / f"killed{kill}", int(rng.integers(1, events(whole)))
        given = command(str(file), "--out", str(directory))
        at = killed(given, directory, event, float(rng.uniform(0.0, LATER)))
        resumed = command(str(file), "--resume", str(directory))
        subprocess.run(resumed, capture_output=True, check=False)
        rows.append(
            {
                "robot": number,
                "truth": [kind, *names],
                "killed_at": at,
                "of": events(whole),
                "same_answer": expected is not None and answer(directory) == expected,
                "same_journal": (directory / "journal.jsonl").read_bytes() == journal,
            }
        )
        print(json.dumps(rows[-1]), flush=True)
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--robots", type=int, default=4)
    parser.add_argument("--budget", type=float, default=40.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("out/investigate_kill.jsonl"))
    asked = parser.parse_args()
    asked.out.parent.mkdir(parents=True, exist_ok=True)
    rows = kept_rows(asked.out)
    for number in range(asked.robots):
        if number in [row["robot"] for row in rows]:
            continue
        with tempfile.TemporaryDirectory() as folder:
            rows += kills(number, asked.kills // asked.robots, asked.budget, asked.seed, Path(folder))
        asked.out.write_text("".join(json.dumps(row) + "\n" for row in rows))
    same = sum(row["same_answer"] and row["same_journal"] for row in rows)
    print(f"{same} of {len(rows)} end with the answer and the journal of the one left alone")


if __name__ == "__main__":
    main()
