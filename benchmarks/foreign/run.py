"""Diagnose a set of sealed robots by the public command, one JSON for each robot; a stopped run goes on.

    python benchmarks/foreign/run.py --in DIR [--jobs 2] [--answers NAME] [--loo] [--diagnose-args "--seed 1"]

Answers are written to DIR/answers (DIR/answers-loo with --loo, where each robot with one name is diagnosed without that
name in the catalogue). The keys are read for --loo alone.
"""

from __future__ import annotations

import argparse
import json
import os
import shlex
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
ENTRY = "from fsm_calib.cli import main; main()"


def diagnose(robot: Path, answer: Path, extra: list[str], limit: float) -> dict[str, Any]:
    """Run `diagnose` on one robot; the answer with exit code, seconds and the last lines of what it said."""
    raw = answer.with_suffix(".raw")
    runs = [str(robot / name) for name in ("run-a", "run-b")]
    command = [
        sys.executable,
        "-c",
        ENTRY,
        "diagnose",
        "--jobs=1",  # robots run side by side, each on a core of its own
        *runs,
        "--holdout",
        str(robot / "run-h"),
        "--json",
        str(raw),
        *extra,
    ]
    paths = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH", "")]))
    environment = {**os.environ, "PYTHONPATH": paths, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    start = time.perf_counter()
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, env=environment, timeout=limit, check=False
        )
        code, said = done.returncode, done.stderr[-2000:]
    except subprocess.TimeoutExpired:
        code, said = -1, f"no answer within {limit:g} s"
    result = {
        "name": robot.name,
        "exit": code,
        "seconds": time.perf_counter() - start,
        "said": said,
        "answer": None,
    }
    if raw.exists():
        result["answer"] = json.loads(raw.read_text())
        raw.unlink()
    return result


def one(robot: Path, folder: Path, extra: list[str], limit: float) -> None:
    """Diagnose one robot unless its answer is there."""
    answer = folder / f"{robot.name}.json"
    if answer.exists():
        return
    result = diagnose(robot, answer, extra, limit)
    part = answer.with_suffix(".part")
    part.write_text(json.dumps(result, indent=1) + "\n")
    part.replace(answer)
    told = (result["answer"] or {}).get("effects", [])
    names = " + ".join(f"{e['name']} {e['confidence']:.2f}" for e in told)
    print(
        f"{robot.name} {(result['answer'] or {}).get('verdict', 'no answer')} {names} ({result['seconds']:.0f} s)",
        file=sys.stderr,
    )


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--in", dest="folder", type=Path, required=True)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--answers", default="", help="name of the folder of answers below DIR")
    parser.add_argument("--loo", action="store_true", help="leave the true name out of the catalogue")
    parser.add_argument("--only", default="", help="robots by name, separated by commas")
    parser.add_argument("--limit", type=float, default=900.0, help="seconds for one robot")
    parser.add_argument("--diagnose-args", default="", help="further arguments of diagnose, in quotes")
    args = parser.parse_args()
    robots = sorted(path for path in args.folder.glob("robot-*") if (path / "run-h").is_dir())
    if args.only:
        robots = [path for path in robots if path.name in args.only.split(",")]
    extra = {path.name: shlex.split(args.diagnose_args) for path in robots}
    if args.loo:
        single = {
            k["name"]: k["labels"][0]
            for k in json.loads((args.folder / "keys.json").read_text())
            if len(k["labels"]) == 1
        }
        robots = [path for path in robots if path.name in single]
        extra = {path.name: [*extra[path.name], "--without", single[path.name]] for path in robots}
    answers = args.folder / (args.answers or ("answers-loo" if args.loo else "answers"))
    answers.mkdir(parents=True, exist_ok=True)
    with ThreadPoolExecutor(args.jobs) as pool:
        for future in [pool.submit(one, path, answers, extra[path.name], args.limit) for path in robots]:
            future.result()


if __name__ == "__main__":
    main()
