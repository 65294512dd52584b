"""Slips of the hand in the code, one at a time: which of them do the tests of their room notice?

    python benchmarks/mutants.py [--room journal ...] [--count 60] [--seconds 1800] [--seed 0]

Each mutant changes one place of one file (a call left out, a comparison turned, a condition negated, a number moved, a
return without its value) in a copy of the package, and the room's tests run against the copy, at most three times as
long as they need for the sound one. A mutant is *killed* when they fail. EQUAL lists mutants that no test can kill, because they
do the same. Run it when one of these rooms changes. Exit code 1 where fewer than 90 % are killed.
"""

from __future__ import annotations

import argparse
import ast
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parent.parent
BAR = 0.9
ROOMS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "journal": (("journal.py", "sealed.py"), ("test_journal.py",)),
    "recording": (
        ("recording/checks.py", "recording/oddities.py", "recording/inside.py", "recording/channels.py"),
        ("test_recording_checks.py", "test_recording_inside.py", "test_recording_type.py", "test_recording_manifest.py"),
    ),
    "actions": (
        ("actions/stopping.py", "actions/moving.py", "actions/markers.py", "actions/turning.py", "actions/boards.py",
         "actions/looking.py", "actions/ratio.py", "actions/wheel_runs.py", "actions/focusing.py", "actions/leaving.py"),
        ("test_action_slips.py", "test_action_turning.py", "test_action_estimates.py", "test_action_wheel_runs.py"),
    ),
    "machines": (("machines/books.py", "machines/bookkeeping.py", "machines/guards.py"), ("test_machine_transitions.py", "test_machine_guards.py")),
    "verdicts": (("diagnosis/verdict/decide.py", "diagnosis/verdict/posterior.py"), ("test_diagnosis_verdict.py",)),
}  # fmt: skip
EQUAL: dict[str, str] = {
    "journal.py: leave out kept.unlink(missing_ok=True)": "only a left-over of a killed process is removed",
    "journal.py: leave out file.flush()": "fsync of a closed file's twin: closing flushes, only a power cut tells",
}
"""Mutants that do the same, or what no test can see, and why."""
TURNED: dict[type, type] = {ast.Lt: ast.GtE, ast.LtE: ast.Gt, ast.Gt: ast.LtE, ast.GtE: ast.Lt, ast.Eq: ast.NotEq,
                            ast.NotEq: ast.Eq, ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In}  # fmt: skip


@dataclass(frozen=True)
class Mutant:
    """One slip: where, what, and the file's text with it."""

    file: str
    line: int
    what: str
    text: str

    @property
    def name(self) -> str:
        """What `EQUAL` calls it."""
        return f"{self.file}: {self.what}"


def mutants_of(file: str, source: str) -> Iterator[Mutant]:
    """Yield every mutant of a file."""
    count = sum(1 for _ in ast.walk(ast.parse(source)))
    for number in range(count):
        tree = ast.parse(source)
        for parent in ast.walk(tree):
            for child in ast.iter_child_nodes(parent):
                child.parent = parent  # type: ignore[attr-defined]
        node = next(node for i, node in enumerate(ast.walk(tree)) if i == number)
        for what in changed(node):
            yield Mutant(file, getattr(node, "lineno", 0), what, ast.unparse(ast.fix_missing_locations(tree)))


def changed(node: ast.AST) -> Iterator[str]:
    """Change a node in place and yield what was done, where a slip is possible at it."""
    before = ast.unparse(node)[:60].split("\n")[0] if isinstance(node, ast.expr | ast.stmt) else ""
    if isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
        node.value = ast.Constant(None)
        yield f"leave out {before}"
    elif isinstance(node, ast.Compare) and type(node.ops[0]) in TURNED:
        node.ops[0] = TURNED[type(node.ops[0])]()
        yield f"turn {before}"
    elif isinstance(node, ast.If | ast.IfExp | ast.While) and not isinstance(node.test, ast.Compare):
        said = ast.unparse(node.test)[:60]
        node.test = ast.UnaryOp(ast.Not(), node.test)
        yield f"negate {said}"
    elif isinstance(node, ast.BoolOp):
        node.op = ast.Or() if isinstance(node.op, ast.And) else ast.And()
        yield f"and for or in {before}"
    elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub):
        node.op = ast.Sub() if isinstance(node.op, ast.Add) else ast.Add()
        yield f"plus for minus in {before}"
    elif isinstance(node, ast.AugAssign):
        node.op = ast.Sub() if isinstance(node.op, ast.Add) else ast.Add()
        yield f"other sign in {before}"
    elif isinstance(node, ast.Return) and node.value is not None and not isinstance(node.value, ast.Constant):
        node.value = ast.Constant(None)
        yield f"nothing for {before}"


def run_tests(folder: Path, tests: tuple[str, ...], seconds: float) -> bool:
    """Tell whether the tests pass against the package in a folder; too long is a failure."""
    paths = [str(folder / "tests" / name) for name in tests if (folder / "tests" / name).exists()]
    environment = os.environ | {
        "PYTHONPATH": f"{folder}{os.pathsep}{os.environ.get('PYTHONPATH', '')}",
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    call = [sys.executable, "-m", "pytest", "-x", "-q", "-n", "0", "-p", "no:cacheprovider", *paths]
    try:
        return (
            subprocess.run(
                call, cwd=folder, env=environment, capture_output=True, timeout=seconds, check=False
            ).returncode
            == 0
        )
    except subprocess.TimeoutExpired:
        return False


def judge(room: str, count: int, until: float, rng: random.Random) -> tuple[int, list[Mutant]]:
    """Return how many mutants of a room were tried, and those that survived."""
    files, tests = ROOMS[room]
    found = [
        m
        for f in files
        if (ROOT / "fsm_calib" / f).exists()
        for m in mutants_of(f, (ROOT / "fsm_calib" / f).read_text())
    ]
    chosen = [m for m in rng.sample(found, len(found)) if m.name not in EQUAL][:count]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for part in ("fsm_calib", "tests", "benchmarks", "scenarios", "diagrams"):
            shutil.copytree(ROOT / part, folder / part, ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copy(ROOT / "pyproject.toml", folder)
        began = time.monotonic()
        if not run_tests(folder, tests, 600.0):
            sys.exit(f"the tests of {room} fail on the sound code")
        limit = max(3.0 * (time.monotonic() - began), 20.0)
        tried, survivors = 0, []
        for mutant in chosen:
            if time.monotonic() > until:
                break
            path = folder / "fsm_calib" / mutant.file
            sound = path.read_text()
            path.write_text(mutant.text)
            if run_tests(folder, tests, limit):
                survivors.append(mutant)
                print(f"  survives: {mutant.file}:{mutant.line}: {mutant.what}", flush=True)
            path.write_text(sound)
            tried += 1
    return tried, survivors


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--room", action="append", choices=list(ROOMS))
    parser.add_argument("--count", type=int, default=60, help="mutants of each room at most")
    parser.add_argument("--seconds", type=float, default=1800.0, help="shared by the rooms")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    rooms = options.room or list(ROOMS)
    share = options.seconds / len(rooms)
    rows = []
    for room in rooms:
        print(room, flush=True)
        tried, survivors = judge(room, options.count, time.monotonic() + share, random.Random(options.seed))
        rows.append((room, tried, tried - len(survivors)))
    print("\n| room | mutants | killed | share |\n|---|---|---|---|")
    for room, tried, killed in rows:
        print(f"| {room} | {tried} | {killed} | {killed / max(tried, 1):.0%} |")
    return int(any(killed < BAR * tried for _, tried, killed in rows))


if __name__ == "__main__":
    sys.exit(main())
