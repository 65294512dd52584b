"""Runs one scenario on many robots, a process each core, and keeps every result as a line, so that it can go on."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

from fsm_calib.study.orphans import end_with

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

ROOT = Path(__file__).parent.parent
SCENARIOS = ROOT / "scenarios"
OUT = ROOT / "out" / "benchmarks"
"""Where results are kept; not part of the repository."""
NO_PICTURES = {"report": False, "recording": False, "frames": 0}
Task = tuple[str, int, dict[str, Any]]
"""Label, seed, and what is changed in the scenario."""


def one_run(scenario: str, task: Task) -> dict[str, Any]:
    """Return the result of one robot, with the label and the seed of the task; a run that was stopped has none."""
    import cv2

    from fsm_calib.runner.run import run_scenario
    from fsm_calib.scenario.load import load_scenario
    from fsm_calib.scenario.models import Scenario

    cv2.setNumThreads(1)
    label, seed, changes = task
    values = load_scenario(SCENARIOS / f"{scenario}.yaml").model_dump(exclude_unset=True)
    merged = _merged(values, {"seed": seed, "output": NO_PICTURES} | changes)
    with tempfile.TemporaryDirectory() as folder:
        result = run_scenario(Scenario.model_validate(merged), Path(folder)).result
    if result["outcome"] == "aborted":
        raise SystemExit(f"{label}, seed {seed}: stopped by a signal")
    return {"label": label, "seed": seed, **result}


def workers(jobs: int) -> ProcessPoolExecutor:
    """Return processes that end soon after this one, whatever ended it."""
    return ProcessPoolExecutor(jobs, initializer=end_with, initargs=(os.getpid(),))


def run_all(
    name: str, scenario: str, tasks: list[Task], jobs: int, tell: Callable[[Mapping[str, Any]], None]
) -> list[dict[str, Any]]:
    """Return the results of all tasks in their order; those already kept under `name` are not run again."""
    path = OUT / f"{name}.jsonl"
    path.parent.mkdir(parents=True, exist_ok=True)
    done = {(row["label"], row["seed"]): row for row in _kept(path)}
    left = [task for task in tasks if task[:2] not in done]
    print(
        f"{len(tasks) - len(left)} of {len(tasks)} results are kept in {path.relative_to(ROOT)}", flush=True
    )
    with path.open("a") as file, workers(jobs) as pool:
        for row in pool.map(one_run, [scenario] * len(left), left):
            file.write(json.dumps(row) + "\n")
            file.flush()
            done[(row["label"], row["seed"])] = row
            tell(row)
    return [done[task[:2]] for task in tasks]


def _kept(path: Path) -> Iterator[dict[str, Any]]:
    """Yield the results of an earlier, perhaps interrupted, call; a torn last line is left out."""
    if path.exists():
        yield from (
            json.loads(line) for line in path.read_text().splitlines(keepends=True) if line.endswith("\n")
        )


def _merged(values: dict[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return `values` with `changes`, section by section."""
    merged = dict(values)
    for name, change in changes.items():
        both = isinstance(change, Mapping) and isinstance(merged.get(name), Mapping)
        merged[name] = _merged(merged[name], change) if both else change
    return merged


def ended(row: Mapping[str, Any]) -> str:
    """Return how a run ended: `done`, or the name of its failure and the state it came from."""
    failure = row["failure"]
    return row["outcome"] if failure is None else f"{failure['name']} in {failure['state']}"
