"""Diagnose every concealed robot, seal the verdicts, then open the key and print the table.

    python3 benchmarks/concealed/run.py OUT [--jobs 2] [--loo 60]
    python3 benchmarks/concealed/run.py OUT --score             # open the key now: the table of what there is

Resumable: a robot whose verdict is written is not diagnosed again. Order of events, each written before the next:
key.sha256 (by generate.py), verdicts/*.json with their hashes in verdicts.sha256, and only then the passphrase is
read. The workers are handed OUT/robots alone. `--loo N` adds N runs with an effect taken out of the catalogue: after
every few robots, the name that one of them was given is left out. No key is needed for that: where the name was
right, the true effect is missing, and only those runs are counted. When the key is open, robots whose true effect was
not named are run without it, too, as many as their share asks for. Robots stand in an order that tells nothing, so
that any part of the run is a fair sample.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
import time
from pathlib import Path

from joblib import Parallel, delayed

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from concealed.generate import keystream
from concealed.score import is_left_out, is_single, load, report, right

TWINS = {name: ("command_delay", "observation_delay") for name in ("command_delay", "observation_delay")}
"""Names that are left out together: without encoders nothing tells them apart."""

SHARES = 4  # of robots, each with one run without a name, between two seals

Task = tuple[Path, Path, tuple[str, ...]]
"""A robot's folder, the file for its verdict, and the names that are left out of the catalogue."""


def diagnose(folder: Path, out: Path, without: tuple[str, ...] = ()) -> str:
    """Run the command as a user would, in this worker process; write its JSON, or the error, to `out`."""
    from fsm_calib.cli import main

    started = time.perf_counter()
    part = out.with_suffix(".part")
    part.unlink(missing_ok=True)
    arguments = [
        "diagnose",
        "--jobs=1",  # seconds are those of one core
        str(folder / "run-a"),
        str(folder / "run-b"),
        "--holdout",
        str(folder / "run-h"),
        "--json",
        str(part),
    ]
    for name in without:
        arguments += ["--without", name]
    keep, sys.argv = sys.argv, ["fsm-calib", *arguments]
    try:
        main()
        code = 0
    except SystemExit as stop:
        code = stop.code
    finally:
        sys.argv = keep
    if not part.exists():
        part.write_text(
            json.dumps(
                {
                    "verdict": "error",
                    "effects": [],
                    "exit": str(code),
                    "seconds": time.perf_counter() - started,
                }
            )
        )
    if without:
        verdict = json.loads(part.read_text()) | {"without": list(without)}
        part.write_text(json.dumps(verdict))
    part.rename(out)
    return out.name


def all_verdicts(out: Path, jobs: int, loo: int) -> None:
    """Diagnose what is not yet diagnosed, block by block; seal each block; then leave one of its names out."""
    verdicts, left_out = out / "verdicts", out / "verdicts-without"
    verdicts.mkdir(exist_ok=True)
    left_out.mkdir(exist_ok=True)
    robots = sorted((out / "robots").iterdir())
    share = max(1, len(robots) // loo) if loo else 0
    block = SHARES * share or 10 * jobs
    left: list[Task] = []
    for first in range(0, len(robots), block):
        some = robots[first : first + block]
        tasks = [(p, verdicts / f"{p.name}.json", ()) for p in some]
        todo = [task for task in tasks if not task[1].exists()]
        Parallel(n_jobs=jobs)(delayed(diagnose)(*task) for task in left + todo)
        seal(out)
        shares = [some[i : i + share] for i in range(0, len(some), share)] if loo else []
        left = [task for few in shares for task in name_to_leave_out(few, verdicts, left_out)]
        print(f"{first + len(some)} of {len(robots)} robots", file=sys.stderr, flush=True)
    Parallel(n_jobs=jobs)(delayed(diagnose)(*task) for task in left)


def seal(out: Path) -> None:
    """Write the hash of each verdict beside those that were written before; none of these may have changed."""
    path = out / "verdicts.sha256"
    sealed = dict(line.split()[::-1] for line in path.read_text().splitlines()) if path.exists() else {}
    for verdict in sorted((out / "verdicts").glob("*.json")):
        digest = hashlib.sha256(verdict.read_bytes()).hexdigest()
        if sealed.setdefault(verdict.name, digest) != digest:
            raise SystemExit(f"{verdict.name} differs from the verdict that was sealed: use a fresh folder")
    path.write_text("".join(f"{digest}  {name}\n" for name, digest in sorted(sealed.items())))


def name_to_leave_out(robots: list[Path], verdicts: Path, left_out: Path) -> list[Task]:
    """Return the task to diagnose one of the robots again without its name, if any has a single one; else none."""
    if any((left_out / f"{p.name}.json").exists() for p in robots):
        return []
    for robot in sorted(robots, key=lambda p: hashlib.sha256(p.name.encode()).hexdigest()):
        named = json.loads((verdicts / f"{robot.name}.json").read_text())["effects"]
        if len(named) == 1:
            name = named[0]["name"]
            return [(robot, left_out / f"{robot.name}.json", TWINS.get(name, (name,)))]
    return []


def open_key(out: Path) -> list[dict]:
    """Decipher the key after the verdicts are sealed, and check that it is the one that was promised."""
    if (out / "key.json").exists():
        text = (out / "key.json").read_bytes()
    else:
        sealed = (out / "key.sealed").read_bytes()
        passphrase = (out.with_name(out.name + "-vault") / "passphrase").read_text()
        text = bytes(x ^ y for x, y in zip(sealed, keystream(passphrase, len(sealed))))
    if hashlib.sha256(text).hexdigest() != (out / "key.sha256").read_text().strip():
        raise SystemExit("the key is not the one whose hash was published")
    return json.loads(text)


def leave_out_the_truth(out: Path, key: list[dict], jobs: int) -> None:
    """Diagnose the robots whose true effect was not named without it, as many as their share asks for."""
    folder = out / "verdicts-without"
    pairs = [
        pair for pair in load(out / "verdicts", key) if is_single(pair[0]) and pair[0]["level"] != "faint"
    ]
    missed = [line for line, verdict in pairs if not right((line, verdict))]
    done = {line["name"] for line, verdict in load(folder, key) if is_left_out((line, verdict))}
    counted = len(done - {line["name"] for line in missed})
    wanted = round(counted * len(missed) / max(len(pairs) - len(missed), 1))
    Parallel(n_jobs=jobs)(
        delayed(diagnose)(
            out / "robots" / line["name"],
            folder / f"{line['name']}.json",
            TWINS.get(line["label"], (line["label"],)),
        )
        for line in missed[:wanted]
        if line["name"] not in done
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--loo", type=int, default=0)
    parser.add_argument("--score", action="store_true", help="diagnose nothing more")
    a = parser.parse_args()
    if not a.score:
        all_verdicts(a.out, a.jobs, a.loo)
    seal(a.out)
    key = open_key(a.out)
    if a.loo and not a.score:
        leave_out_the_truth(a.out, key, a.jobs)
    text = report(a.out, key)
    (a.out / "table.md").write_text(text)
    print(text)


if __name__ == "__main__":
    main()
