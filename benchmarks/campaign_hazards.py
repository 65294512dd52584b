"""What the campaign of runs does to a run: kills, signals, full disks, bad places, two at once; and what is right."""

from __future__ import annotations

import fcntl
import json
import os
import random
import resource
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import yaml
from campaign_case import Case, Wrong
from campaign_children import Child, command, started
from campaign_faults import faults
from fleet_runs import NO_PICTURES, SCENARIOS

from fsm_calib.errors import DataError
from fsm_calib.journal import CHECKPOINT_NAME, JOURNAL_NAME, read_checkpoint

LONGEST_LINE = 1200  # characters of a sentence
LONGEST_WORDS = 1 << 20  # bytes that a child may say before anybody listens
OWN_TIME = {"wall", "by_part"}
"""Figures of result.json that are the computer's and differ from run to run."""
NOT_COMPARED = {".running", "report.html"}
DISTURBED = (*["wheels_only"] * 4, *["camera_only"] * 3, *["exit"] * 3, "full_calibration")
"""Scenarios that are killed and stopped, the short ones more often."""
FAULTY = ("dead_wheel", "dropped_frames", "frozen_frames", "missing_board", "missing_marker", "wall")
OTHERS = (*["in_lane_refinement", "paper_two_boards"] * 2, "as_published", *(f"fault_{f}" for f in FAULTY))
KILLED = (*DISTURBED, *OTHERS)
"""Scenarios that are killed: every one that a run takes, those that fail by design, too."""
DAMAGED = (CHECKPOINT_NAME, JOURNAL_NAME)
FLIPS = 1000
"""Bits that are flipped in each of them."""


def scenario_file(folder: Path, name: str, seed: int, *, pictures: bool = True) -> Path:
    """Return a scenario's file in `folder`, without film and with its page, or with neither page nor pictures."""
    values = yaml.safe_load((SCENARIOS / f"{name}.yaml").read_text()) | {"seed": seed}
    path = folder / f"{name}-{seed}.yaml"
    path.write_text(yaml.safe_dump(values | ({} if pictures else {"output": NO_PICTURES})))
    return path


def content_of(directory: Path) -> dict[str, bytes]:
    """Return what a run left, file by file; the computer's own times are left out."""
    files = {}
    for path in sorted(directory.rglob("*")):
        name = str(path.relative_to(directory))
        if path.is_dir() or name in NOT_COMPARED:
            continue
        data = path.read_bytes()
        if name == "result.json":
            result = json.loads(data)
            result["seconds"] = {k: v for k, v in result["seconds"].items() if k not in OWN_TIME}
            data = json.dumps(result, sort_keys=True).encode()
        elif name.startswith("calibrations/"):
            data = b"\n".join(line for line in data.splitlines() if b"calibration_time" not in line)
        files[name] = data
    return files


def expect_equal(directory: Path, reference: Path) -> None:
    """Demand the files of an undisturbed run."""
    found, wanted = content_of(directory), content_of(reference)
    differ = sorted(name for name in found.keys() | wanted.keys() if found.get(name) != wanted.get(name))
    if differ:
        raise Wrong(f"other files than an undisturbed run: {', '.join(differ[:6])}")
    if not (directory / "report.html").exists():
        raise Wrong("no report.html")


def expect_sentence(child: Child, codes: tuple[int, ...]) -> None:
    """Demand an exit code, and where it is not 0 a sentence that a terminal can show, and no traceback."""
    said = child.stderr()
    if child.code not in codes:
        raise Wrong(f"exit code {child.code}: {said.strip().splitlines()[-1:]}")
    if "Traceback" in said or "unforeseen" in said:
        raise Wrong(f"traceback: {said.strip().splitlines()[-1]}")
    if child.code:
        lines = [line for line in said.split("\n") if line.startswith("fsm-calib:")]
        if not lines or any(len(line) > LONGEST_LINE or not line.isprintable() for line in lines):
            raise Wrong(f"no readable sentence: {said[-300:]!r}")


def code_of(directory: Path) -> int:
    """Return the exit code with which a run has ended: 0 done, 1 failed."""
    result = json.loads((directory / "result.json").read_text())
    return 0 if result["outcome"] == "done" else 1


def events_in(directory: Path) -> int:
    """Return how many events a run has journaled."""
    path = directory / "journal.jsonl"
    return path.read_bytes().count(b"\n") if path.exists() else 0


def disturbed(child: Child, directory: Path, events: int, delay: float, number: int) -> bool:
    """Send a signal when the journal holds `events` lines and `delay` [s] have passed; False where it had ended."""
    while child.is_running() and events_in(directory) < events:
        time.sleep(0.002)
    until = time.monotonic() + delay
    while child.is_running() and time.monotonic() < until:
        time.sleep(0.002)
    return child.send(number)


def moment_of(case: Case, reference: Path) -> tuple[int, float]:
    """Return after which event, and how long after it [s], a run is disturbed: each fifth time in its last second."""
    last = events_in(reference)
    is_end = case.rng.random() < 0.2
    events = last if is_end else case.rng.randrange(last + 1)
    return events, case.rng.uniform(0.0, 1.0 if is_end else 0.3)


def kill(case: Case) -> None:
    """Kill one to three times at random moments, resume, and demand the files and the end of a run left alone."""
    name, seed = case.only or case.rng.choice(KILLED), case.rng.randrange(3)
    reference, out = case.reference(name, seed), case.folder / "out"
    file, kills = scenario_file(case.folder, name, seed), case.rng.choice((1, 1, 1, 2, 3))
    moments = sorted(moment_of(case, reference) for _ in range(kills))
    case.choose(scenario=name, seed=seed, after=moments)
    arguments = ["run", str(file), "--out", str(out)]
    for events, delay in moments:
        child = started(command(arguments), case.folder / "log")
        disturbed(child, out, events, delay, signal.SIGKILL)
        child.wait()
        if (out / "journal.jsonl").exists():
            arguments = ["run", str(file), "--resume", str(out)]
    finish(case, arguments, file, out, reference)


def finish(case: Case, arguments: list[str], file: Path, out: Path, reference: Path) -> None:
    """Go on with a run that was disturbed (from the beginning where it had not begun) and demand equal files."""
    child = started(command(arguments), case.folder / "log").wait()
    if (
        child.code == 2 and "--resume" in arguments
    ):  # nothing whole was on disk yet: the sentence says to begin again
        expect_sentence(child, (2,))
        arguments = ["run", str(file), "--out", str(out), "--overwrite"]
        child = started(command(arguments), case.folder / "log").wait()
    expect_sentence(child, (code_of(reference),))
    expect_equal(out, reference)


def stop(case: Case) -> None:
    """Send SIGTERM, SIGINT or SIGHUP at a random moment: exit code 1 and a sentence; a resume ends as if nothing was."""
    name, seed = case.rng.choice(DISTURBED), case.rng.randrange(3)
    number = case.rng.choice((signal.SIGTERM, signal.SIGINT, signal.SIGHUP))
    reference, out = case.reference(name, seed), case.folder / "out"
    file, (events, delay) = scenario_file(case.folder, name, seed), moment_of(case, reference)
    case.choose(scenario=name, seed=seed, after=(events, delay), signal=number.name)
    child = started(command(["run", str(file), "--out", str(out)]), case.folder / "log")
    came = disturbed(child, out, events, delay, number)
    child.wait()
    expect_sentence(child, (0, 1) if came else (0,))
    if child.code == 0:
        expect_equal(out, reference)
        return
    begun = (out / "journal.jsonl").exists()
    finish(case, ["run", str(file), *(["--resume"] if begun else ["--out"]), str(out)], file, out, reference)


def full(case: Case) -> None:
    """Let no file grow beyond a random size, as on a full disk: a sentence, nothing half written, and it can go on."""
    name, seed = case.rng.choice(DISTURBED[:-1]), case.rng.randrange(3)
    reference, out = case.reference(name, seed), case.folder / "out"
    largest = max(path.stat().st_size for path in reference.rglob("*") if path.is_file())
    size = int(largest ** case.rng.random())
    case.choose(scenario=name, seed=seed, bytes=size)
    file = scenario_file(case.folder, name, seed)
    words, ear = os.pipe()  # what is said to a person goes to no disk
    limited = command(["run", str(file), "--out", str(out)], lambda: _limit_files(size, ear))
    child = started(limited, case.folder / "log").wait()
    os.close(ear)
    with open(words, "rb") as said:
        child.log.joinpath("stderr").write_bytes(said.read())
    expect_sentence(child, (0, 1, 2))
    for path in (*out.glob("result.json"), *out.glob("calibrations/*/*.yaml")):
        if yaml.safe_load(path.read_text()) is None:
            raise Wrong(f"{path.name} is empty")
    begun = (out / "journal.jsonl").exists()
    if child.code == 0:
        expect_equal(out, reference)
        return
    finish(case, ["run", str(file), *(["--resume"] if begun else ["--out"]), str(out)], file, out, reference)


def _limit_files(size: int, ear: int) -> None:
    """Let no file of this process grow beyond `size` bytes; its standard error goes to the descriptor `ear`."""
    fcntl.fcntl(ear, fcntl.F_SETPIPE_SZ, LONGEST_WORDS)
    os.dup2(ear, 2)
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


def _occupied(name: str, *, folder: bool) -> Callable[[Path], Path]:
    """Return who makes a place where `name` is taken: by a folder where a file belongs, or the other way round."""

    def make(out: Path) -> Path:
        place = out / name
        place.parent.mkdir(parents=True, exist_ok=True)
        if folder:
            (place / "in the way").mkdir(parents=True)
        else:
            place.write_text("in the way")
        return out

    return make


def _file_as_parent(out: Path) -> Path:
    out.write_text("a file")
    return out / "below"


def _link_to_nowhere(out: Path) -> Path:
    out.symlink_to(out.parent / "missing" / "place")
    return out


PLACES: dict[str, Callable[[Path], Path]] = {
    "a file": lambda out: (out.write_text("a file"), out)[1],
    "below a file": _file_as_parent,
    "a link to nowhere": _link_to_nowhere,
    "read only": lambda out: Path("/proc/self/fdinfo/out"),
    "a device": lambda out: Path("/dev/full"),
    "a name too long": lambda out: out / ("x" * 300),
    "control characters": lambda out: Path(f"{out}\x1b[2J"),
    **{
        f"{name} is a folder": _occupied(name, folder=True)
        for name in ("journal.jsonl", "checkpoint.json", "result.json", "report.html", ".running")
    },
    **{
        f"{name} is a file": _occupied(name, folder=False) for name in ("calibrations", "recording", "frames")
    },
}
"""Places where a run's files cannot go."""


def place(case: Case) -> None:
    """Give a place where nothing, or not everything, can be written: a sentence at once, or the whole result."""
    kind = case.rng.choice(sorted(PLACES))
    seed, options = case.rng.randrange(3), case.rng.choice(([], ["--overwrite"]))
    case.choose(scenario="wheels_only", seed=seed, place=kind, options=options)
    file, out = scenario_file(case.folder, "wheels_only", seed), PLACES[kind](case.folder / "out")
    child = started(command(["run", str(file), "--out", str(out), *options]), case.folder / "log").wait()
    expect_sentence(child, (0, 1, 2))
    if child.code == 0 and not list(out.rglob("in the way")):
        expect_equal(out, case.reference("wheels_only", seed))


def pair(case: Case) -> None:
    """Start two runs in one directory: one is refused or both follow each other, and the result is a whole one."""
    seed = case.rng.randrange(3)
    reference, out = case.reference("wheels_only", seed), case.folder / "out"
    delay, overwrite = case.rng.uniform(0.0, 2.0) ** 2, case.rng.random() < 0.5
    case.choose(scenario="wheels_only", seed=seed, delay=delay, overwrite=overwrite)
    file = scenario_file(case.folder, "wheels_only", seed)
    arguments = ["run", str(file), "--out", str(out)]
    first = started(command(arguments), case.folder / "first")
    time.sleep(delay)
    second = started(command(arguments + ["--overwrite"] * overwrite), case.folder / "second")
    for child in (first.wait(), second.wait()):
        expect_sentence(child, (0, 2))
    if (first.code, second.code) == (2, 2):
        raise Wrong("both were refused")
    expect_equal(out, reference)


def damage(case: Case) -> None:
    """Cut a killed run's files at every byte and flip bits of them: refused, or the very same state is gone on with."""
    name, seed = case.rng.choice(DISTURBED), case.rng.randrange(3)
    reference, out = case.reference(name, seed), case.folder / "out"
    event, delay = moment_of(case, reference)
    file = scenario_file(case.folder, name, seed)
    child = started(command(["run", str(file), "--out", str(out)]), case.folder / "log")
    disturbed(child, out, event, delay, signal.SIGKILL)
    child.wait()
    sizes = {path: (out / path).stat().st_size for path in DAMAGED if (out / path).exists()}
    case.choose(scenario=name, seed=seed, after=(event, delay), bytes=sizes)
    if len(sizes) < len(DAMAGED):
        return  # killed before its first event
    sound = taken_up(out)
    for path in DAMAGED:
        whole = (out / path).read_bytes()
        for harmed in damaged(whole, case.rng):
            (out / path).write_bytes(harmed)
            if taken_up(out) not in (None, sound):
                raise Wrong(f"{path}, {len(harmed)} of {len(whole)} bytes, is gone on with otherwise")
        (out / path).write_bytes(whole)
    finish(case, ["run", str(file), "--resume", str(out)], file, out, reference)


def damaged(whole: bytes, rng: random.Random) -> Iterator[bytes]:
    """Yield a file cut at every byte, then with one bit flipped, at random."""
    for length in range(len(whole)):
        yield whole[:length]
    for _ in range(FLIPS):
        harmed, bit = bytearray(whole), rng.randrange(8 * len(whole))
        harmed[bit // 8] ^= 1 << bit % 8
        yield bytes(harmed)


def taken_up(directory: Path) -> tuple[dict[str, Any], bytes] | None:
    """Return what a resumed run would begin with, state and events; None where it refuses."""
    try:
        state = read_checkpoint(directory)
    except DataError:
        return None
    kept = 0 if state is None else state["journal_length"]
    return state or {}, (directory / JOURNAL_NAME).read_bytes()[:kept]


HAZARDS: dict[str, Callable[[Case], None]] = {
    "kill": kill,
    "signal": stop,
    "fault": faults,
    "full disk": full,
    "place": place,
    "two at once": pair,
    "damage": damage,
}
