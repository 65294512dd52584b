"""A campaign against runs: killed, stopped, with faults, on full disks, in bad places, two at once; each judged.

    python benchmarks/campaign_runs.py [--cases 200] [--seconds 3600] [--seed 0] [--out out/campaign-runs] [--kind NAME ...]
    python benchmarks/campaign_runs.py --kind kill --case 17          one case again, its folder kept

| kind | is done to a run | is right |
|---|---|---|
| kill | SIGKILL at one to three random moments, each fifth in the last second | resumed, every file equals that of a run left alone |
| signal | SIGTERM, SIGINT, SIGHUP at a random moment | exit code 1 and a sentence; resumed as above |
| fault | one or two faults that begin in states drawn evenly, some in bad light | ended by name, wheels at zero, in time; what is done is good |
| full disk | no file may grow beyond a random size | a sentence, nothing half written; with room again as above |
| place | a place where nothing, or not everything, can be written | a sentence |
| two at once | two runs in one directory | one is refused; the result is whole |
| damage | a killed run's checkpoint and journal cut at every byte, 2,000 bits of either flipped | refused, or gone on with from nothing but what was written |

The campaign goes on where it was when the command is given again: --out holds a line for each case (`cases.jsonl`: what was
decided, how it ended), `report.md`, and the folder of every case that was not right. Exit code 1 where there was one.
"""

from __future__ import annotations

import json
import random
import shutil
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

from campaign import options_of
from campaign_case import Case, Wrong
from campaign_children import Hang, command, started
from campaign_hazards import HAZARDS, KILLED, code_of, scenario_file


class Campaign:
    """The cases of one seed, as far as they have been judged."""

    def __init__(self, out: Path, seed: int, only: str = "") -> None:
        self.out, self.seed, self.only = out, seed, only
        out.mkdir(parents=True, exist_ok=True)
        self._path = out / "cases.jsonl"
        lines = self._path.read_text().splitlines(keepends=True) if self._path.exists() else []
        self.rows: list[dict[str, Any]] = [json.loads(line) for line in lines if line.endswith("\n")]
        if any(row["campaign"] != seed for row in self.rows):
            sys.exit(f"{out} holds a campaign of another seed: give it, or another --out")

    def reference(self, name: str, seed: int, *, pictures: bool = True) -> Path:
        """Return the directory of a run of this scenario and seed that nobody disturbed."""
        directory = self.out / "undisturbed" / f"{name}-{seed}{'' if pictures else '-bare'}"
        if not (directory / "result.json").exists():
            shutil.rmtree(directory, ignore_errors=True)
            directory.parent.mkdir(parents=True, exist_ok=True)
            file = scenario_file(directory.parent, name, seed, pictures=pictures)
            made = self.out / "undisturbed" / "new"
            shutil.rmtree(made, ignore_errors=True)
            child = started(command(["run", str(file), "--out", str(made)]), self.out / "log").wait()
            if not (made / "result.json").exists() or child.code != code_of(made):
                raise SystemExit(f"{name}, seed {seed}, does not end by itself: {child.stderr()}")
            made.rename(directory)
        return directory

    def judge(self, kind: str, number: int) -> dict[str, Any]:
        """Return the row of one case; its folder stays where it was not right."""
        began = time.monotonic()
        folder = Path(tempfile.mkdtemp(prefix="campaign-"))
        case = Case(folder, random.Random(f"{self.seed}/{kind}/{number}"), self.reference, self.only)
        try:
            HAZARDS[kind](case)
            found = ""
        except (Wrong, Hang) as wrong:
            found = str(wrong)
            kept = self.out / "repro" / f"{kind.replace(' ', '-')}-{number}"
            shutil.rmtree(kept, ignore_errors=True)
            shutil.copytree(folder, kept, symlinks=True)
        finally:
            shutil.rmtree(folder, ignore_errors=True)
        row = {"campaign": self.seed, "kind": kind, "case": number, "found": found, "plan": case.plan}
        return row | {"seconds": round(time.monotonic() - began, 1)}

    def add(self, row: dict[str, Any]) -> None:
        """Keep a row and the report."""
        self.rows.append(row)
        with self._path.open("a") as file:
            file.write(json.dumps(row) + "\n")
        (self.out / "report.md").write_text(self.report())

    def next_case(self, kind: str) -> int:
        """Return the number of the next case of a kind."""
        return sum(row["kind"] == kind for row in self.rows)

    def turns(self, kinds: list[str], cases: int) -> Iterator[str]:
        """Yield the kinds in turn until each has had `cases`; every one that is yielded is to be judged."""
        while pending := [kind for kind in kinds if self.next_case(kind) < cases]:
            yield from pending

    def report(self) -> str:
        """Return the tables of kinds, of how faults ended, and of what was found."""
        lines = [
            f"seed {self.seed}, {len(self.rows)} cases",
            "",
            "| kind | cases | not right |",
            "|---|---|---|",
        ]
        for kind in HAZARDS:
            rows = [row for row in self.rows if row["kind"] == kind]
            lines.append(f"| {kind} | {len(rows)} | {sum(bool(row['found']) for row in rows)} |")
        ends = Counter(row["plan"].get("ended", "") for row in self.rows if row["kind"] == "fault")
        lines += ["", "| runs with faults ended | times |", "|---|---|"]
        lines += [f"| {name or 'not at all'} | {count} |" for name, count in ends.most_common()]
        began = Counter(
            (fault["kind"], state or "after the end")
            for row in self.rows
            if row["kind"] == "fault"
            for fault, state in zip(row["plan"]["faults"], row["plan"].get("began", ()), strict=False)
        )
        lines += ["", "| fault | began in | times |", "|---|---|---|"]
        lines += [f"| {fault} | {state} | {count} |" for (fault, state), count in sorted(began.items())]
        lines += ["", "| not right | found | plan |", "|---|---|---|"]
        lines += [
            f"| --kind '{row['kind']}' --case {row['case']} | {row['found']} | {json.dumps(row['plan'])} |"
            for row in self.rows
            if row["found"]
        ]
        return "\n".join(lines) + "\n"


def warm() -> None:
    """Import what a run imports, so that a child starts at once."""
    import cv2

    import fsm_calib.cli
    import fsm_calib.report.run_report
    import fsm_calib.runner.run
    import fsm_calib.scenario.load  # noqa: F401

    cv2.setNumThreads(1)


def main() -> int:
    parser = options_of(__doc__, HAZARDS, Path("out/campaign-runs"))
    parser.add_argument("--cases", type=int, default=200, help="of each kind")
    parser.add_argument("--case", type=int, help="this one alone, again")
    parser.add_argument("--scenario", choices=sorted(set(KILLED)), default="", help="the one that is killed")
    options = parser.parse_args()
    campaign, kinds = Campaign(options.out, options.seed, options.scenario), options.kind or list(HAZARDS)
    warm()
    if options.case is not None:
        row = campaign.judge(kinds[0], options.case)
        print(json.dumps(row, indent=1))
        return int(bool(row["found"]))
    until = time.monotonic() + options.seconds
    for kind in campaign.turns(kinds, options.cases):
        if time.monotonic() > until:
            break
        row = campaign.judge(kind, campaign.next_case(kind))
        campaign.add(row)
        print(
            f"{kind} {row['case']}: {row['found'] or 'right'} ({row['seconds']} s) {row['plan']}", flush=True
        )
    print(campaign.report(), end="")
    return int(any(row["found"] for row in campaign.rows))


if __name__ == "__main__":
    sys.exit(main())
