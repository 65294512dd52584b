"""A campaign against every reader: damaged input by kind, each answer judged, each finding shrunk to a small repro.

    python benchmarks/campaign.py [--inputs 1000000] [--seconds 3600] [--seed 0] [--out out/campaign] [--kind NAME ...]
    python benchmarks/campaign.py --doors [--inputs 1000] ...     the same inputs given to commands, in a child process each
    python benchmarks/campaign.py --sample            the first inputs of seed 1, for continuous integration

An answer is right when the input is read, or refused with one of the project's errors in printable lines of at most
1,200 characters. A finding is anything else: another exception, an answer that takes more than 20 s, more than 1 GB of memory, a
journal taken up that was changed, a file that reading made, changed or removed. Inputs are written to folders in memory where
the system has a place for them: to make and remove one on a disk takes longer than most answers. The campaign goes on where it was when the command is given again (--out holds how far each
kind is, the findings, and a folder with the input for each); `report.md` there is the table. Exit code 1 where
anything was found.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import math
import random
import resource
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

from campaign_readers import DOORS, KINDS, Files, Kind

from fsm_calib.errors import FsmCalibError

LONGEST_ANSWER = 20.0  # s
LARGEST_MEMORY = 1 << 20  # KiB, by which the process's largest resident size may grow
LONGEST_LINE = 1200  # characters of a sentence
SHRINKING = 4.0  # s for the repro of one finding
SAMPLE_TURNS = 10  # of each kind: the same inputs on every machine, less than a minute
MEMORY = Path("/dev/shm")  # files that are on no disk, on Linux


class Hang(BaseException):
    """An answer took too long."""


@contextmanager
def within(seconds: float) -> Iterator[None]:
    """Raise `Hang` where the block takes longer; of the process's own time, so that a busy machine is no finding."""

    def late(number: int, frame: object) -> None:
        raise Hang

    before = signal.signal(signal.SIGPROF, late)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def place_of(error: BaseException) -> str:
    """Return where an exception came from: the last line of the project's own code that it passed."""
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if "fsm_calib" in frame.filename] or frames[-1:]
    return f"{type(error).__name__} at {Path(own[-1].filename).name}:{own[-1].lineno}"


def judge(kind: Kind, contents: Files) -> tuple[str, str]:
    """Return ("read" or "refused" or "finding", what was said or found) for one input."""
    with tempfile.TemporaryDirectory(dir=MEMORY if MEMORY.is_dir() else None) as name:
        folder = Path(name)
        for file, data in contents.items():
            (folder / file).write_bytes(data)
        answer = answer_of(kind, folder)
        touched = touched_in(folder, contents)
    return ("finding", touched) if touched and answer[0] != "finding" else answer


def answer_of(kind: Kind, folder: Path) -> tuple[str, str]:
    """Return what `judge` does, for an input in a folder."""
    try:
        with within(LONGEST_ANSWER):
            kind.read(folder)
    except Hang:
        return "finding", "hang"
    except FsmCalibError as error:
        lines = str(error).split("\n")
        sound = all(line.isprintable() and 0 < len(line) <= LONGEST_LINE for line in lines)
        return ("refused", lines[0]) if sound else ("finding", f"unreadable sentence, {place_of(error)}")
    except Exception as error:  # what the campaign looks for
        return "finding", place_of(error)
    return "read", ""


def touched_in(folder: Path, contents: Files) -> str:
    """Return what is otherwise in a folder than what was written to it; nothing where reading only read."""
    now = {path.name: path.read_bytes() if path.is_file() else b"" for path in folder.iterdir()}
    names = {f"{name} was made": name not in contents for name in now}
    names |= {f"{name} was changed or removed": now.get(name) != data for name, data in contents.items()}
    return ", ".join(sorted(said for said, is_so in names.items() if is_so))


def shrunk(kind: Kind, contents: Files, found: str, seconds: float = SHRINKING) -> Files:
    """Return a smaller input with the same finding: pieces are left out as long as it stays."""
    until = time.monotonic() + seconds
    best = dict(contents)
    for name in sorted(best):
        size = max(len(best[name]) // 2, 1)
        while size >= 1 and time.monotonic() < until:
            start = 0
            while start < len(best[name]) and time.monotonic() < until:
                trial = best | {name: best[name][:start] + best[name][start + size :]}
                if judge(kind, trial) == ("finding", found):
                    best = trial
                else:
                    start += size
            size //= 2
    return best


def largest_held() -> int:
    """Return the largest resident size that this process has had [KiB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


@dataclass
class Campaign:
    """How far each kind is, and what was found."""

    out: Path
    seed: int
    done: dict[str, int] = field(default_factory=dict)
    counts: dict[str, dict[str, int]] = field(default_factory=dict)
    findings: dict[str, dict[str, object]] = field(default_factory=dict)
    seconds: float = 0.0
    held_before: int = field(default_factory=largest_held)

    @classmethod
    def opened(cls, out: Path, seed: int) -> Campaign:
        """Return the campaign of this seed in a folder, new or from where it was."""
        out.mkdir(parents=True, exist_ok=True)
        path = out / "state.json"
        known = json.loads(path.read_text()) if path.exists() else {}
        if known.get("seed", seed) != seed:
            sys.exit(f"{out} holds a campaign of seed {known['seed']}: give it, or another --out")
        return cls(
            out,
            seed,
            *(known.get(name, {}) for name in ("done", "counts", "findings")),
            known.get("seconds", 0.0),
        )

    def save(self) -> None:
        """Write how far it is, and the report."""
        state = {
            "seed": self.seed,
            "done": self.done,
            "counts": self.counts,
            "findings": self.findings,
            "seconds": self.seconds,
        }
        (self.out / "state.json").write_text(json.dumps(state, indent=1))
        (self.out / "report.md").write_text(self.report())

    def run(self, name: str, kind: Kind, sound: Files, cases: int) -> None:
        """Judge the next cases of a kind."""
        first, counts = self.done.get(name, 0), self.counts.setdefault(name, {})
        for case in range(first, first + cases):
            contents = kind.damaged(sound, random.Random(f"{self.seed}/{name}/{case}"))
            verdict, said = judge(kind, contents)
            if largest_held() - self.held_before > LARGEST_MEMORY and "memory" not in str(self.findings):
                verdict, said = "finding", "memory above 1 GB"
            counts[verdict] = counts.get(verdict, 0) + 1
            if verdict == "finding":
                self.note(name, kind, case, said, contents)
        self.done[name] = first + cases

    def note(self, name: str, kind: Kind, case: int, said: str, contents: Files) -> None:
        """Keep a finding once, with its repro."""
        key = hashlib.sha256(f"{name}/{said}".encode()).hexdigest()[:8]
        known = self.findings.setdefault(key, {"kind": name, "found": said, "case": case, "times": 0})
        known["times"] = int(str(known["times"])) + 1
        folder = self.out / "repro" / key
        if not folder.exists():
            folder.mkdir(parents=True)
            for file, data in (contents if said == "hang" else shrunk(kind, contents, said)).items():
                (folder / file).write_bytes(data)

    def report(self) -> str:
        """Return the table of kinds and of findings."""
        lines = [f"seed {self.seed}, {sum(self.done.values())} inputs, {self.seconds:.0f} s", ""]
        lines += ["| kind | inputs | read | refused | findings |", "|---|---|---|---|---|"]
        for name, done in self.done.items():
            counts = [self.counts[name].get(verdict, 0) for verdict in ("read", "refused", "finding")]
            lines.append(f"| {name} | {done} | {' | '.join(map(str, counts))} |")
        lines += ["", "| finding | kind | what | first case | times |", "|---|---|---|---|---|"]
        lines += [
            f"| repro/{k} | {f['kind']} | {f['found']} | {f['case']} | {f['times']} |"
            for k, f in self.findings.items()
        ]
        return "\n".join(lines) + "\n"


def fuzz(campaign: Campaign, kinds: list[str], inputs: int, seconds: float, turns: float = math.inf) -> None:
    """Give every kind its turn until all together have had `inputs`, or each its `turns`, or the time is over."""
    began, before = time.monotonic(), campaign.seconds
    known = KINDS | DOORS
    sound = {name: known[name].sound() for name in kinds}
    while time.monotonic() - began < seconds and turns > 0:
        turns -= 1
        for name in kinds:
            left = inputs - sum(campaign.done.values())
            if left > 0 and time.monotonic() - began < seconds:
                campaign.run(name, known[name], sound[name], min(known[name].turn, left))
        campaign.seconds = before + time.monotonic() - began
        campaign.save()
        if sum(campaign.done.values()) >= inputs:
            break


def options_of(about: str, kinds: Iterable[str], out: Path) -> argparse.ArgumentParser:
    """Return the options that every campaign has: which kinds, how long, from which seed, kept where."""
    parser = argparse.ArgumentParser(description=about.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=3600.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=out)
    parser.add_argument("--kind", action="append", choices=list(kinds))
    return parser


def main() -> int:
    parser = options_of(__doc__, KINDS | DOORS, Path("out/campaign"))
    parser.add_argument("--doors", action="store_true", help="every kind that a command reads, through it")
    parser.add_argument("--inputs", type=int, default=1_000_000, help="of all kinds together")
    parser.add_argument("--sample", action="store_true", help="the first inputs of seed 1")
    options = parser.parse_args()
    if options.sample:
        options.seed, options.out = 1, options.out.with_name("campaign-sample")
        shutil.rmtree(options.out, ignore_errors=True)
    campaign = Campaign.opened(options.out, options.seed)
    fuzz(
        campaign,
        options.kind or list(DOORS if options.doors else KINDS),
        options.inputs,
        options.seconds,
        SAMPLE_TURNS if options.sample else math.inf,
    )
    print(campaign.report(), end="")
    return int(bool(campaign.findings))


if __name__ == "__main__":
    sys.exit(main())
