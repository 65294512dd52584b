"""Diagnose every concealed robot, seal the verdicts, then open the key and print the table.

    python3 benchmarks/concealed/run.py OUT [--jobs 2] [--loo 60]

Resumable: a robot whose verdict is written is not diagnosed again. Order of events, each written before the next:
key.sha256 (by generate.py), verdicts/*.json, verdicts.sha256, and only then the passphrase is read. The workers are
handed OUT/robots alone. `--loo N` adds N runs with the robot's true effect taken out of the catalogue: their list is
made after the plain verdicts are sealed, since it needs the key.
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
from concealed.score import report


def diagnose(folder: Path, out: Path, without: tuple[str, ...] = ()) -> str:
    """Run the command as a user would, in this worker process; write its JSON, or the error, to `out`."""
    from fsm_calib.cli import main

    started = time.perf_counter()
    part = out.with_suffix(".part")
    arguments = [
        "diagnose",
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
    part.rename(out)
    return out.name


def all_verdicts(out: Path, jobs: int) -> None:
    """Diagnose what is not yet diagnosed and record the hash of all verdicts."""
    verdicts = out / "verdicts"
    verdicts.mkdir(exist_ok=True)
    todo = [p for p in sorted((out / "robots").iterdir()) if not (verdicts / f"{p.name}.json").exists()]
    print(f"{len(todo)} robots to diagnose", file=sys.stderr)
    Parallel(n_jobs=jobs, verbose=10)(delayed(diagnose)(p, verdicts / f"{p.name}.json") for p in todo)
    digest = hashlib.sha256(b"".join(p.read_bytes() for p in sorted(verdicts.glob("*.json")))).hexdigest()
    seal = out / "verdicts.sha256"
    if not seal.exists():
        seal.write_text(digest + "\n")
    elif seal.read_text().strip() != digest:
        raise SystemExit("the verdicts differ from those that were sealed: use a fresh folder")


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


def leave_one_out(out: Path, key: list[dict], count: int, jobs: int) -> None:
    """Diagnose again with the true effect (and its exact twin) taken out of the catalogue."""
    folder = out / "verdicts-without"
    folder.mkdir(exist_ok=True)
    single = [
        k
        for k in key
        if k["label"] != "none"
        and "+" not in k["label"]
        and ":" not in k["label"]
        and k["level"] != "faint"
        and not k["poor"]
    ]
    twins = {
        "command_delay": ("command_delay", "observation_delay"),
        "observation_delay": ("command_delay", "observation_delay"),
    }
    chosen = sorted(single, key=lambda k: hashlib.sha256(k["name"].encode()).hexdigest())[:count]
    todo = [k for k in chosen if not (folder / f"{k['name']}.json").exists()]
    Parallel(n_jobs=jobs, verbose=10)(
        delayed(diagnose)(
            out / "robots" / k["name"], folder / f"{k['name']}.json", twins.get(k["label"], (k["label"],))
        )
        for k in todo
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--loo", type=int, default=0)
    a = parser.parse_args()
    all_verdicts(a.out, a.jobs)
    key = open_key(a.out)
    if a.loo:
        leave_one_out(a.out, key, a.loo, a.jobs)
    text = report(a.out, key)
    (a.out / "table.md").write_text(text)
    print(text)


if __name__ == "__main__":
    main()
