"""Slips of the hand in the code, one at a time: which of them do the tests of their room notice?

    python benchmarks/mutants.py [--room journal ...] [--count 60] [--seconds 1800] [--seed 0]

Each mutant changes one place of one file (a call left out, a comparison turned, a condition negated, a sign turned, a
return without its value) in a copy of the package, and the room's tests run with it, for at most three times the processor
time that they need for the sound one. A mutant is *killed* when they fail. EQUAL lists mutants that no test can kill, because they
do the same. Run it when one of these rooms changes. Exit code 1 where fewer than 90 % are killed.
"""

from __future__ import annotations

import argparse
import ast
import importlib
import itertools
import math
import multiprocessing
import os
import random
import resource
import shutil
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from types import FunctionType, ModuleType

ROOT = Path(__file__).parent.parent
BAR = 0.9
BUSY = 10.0  # times as long by the clock as by the processor
ROOMS: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "journal": (("journal.py", "sealed.py"), ("test_journal.py",)),
    "recording": (
        ("recording/checks.py", "recording/oddities.py", "recording/inside.py", "recording/channels.py"),
        ("test_recording_oddities.py", "test_recording_checks.py", "test_recording_inside.py", "test_recording_type.py",
         "test_recording_manifest.py"),
    ),
    "actions": (
        ("actions/stopping.py", "actions/moving.py", "actions/markers.py", "actions/turning.py", "actions/boards.py",
         "actions/looking.py", "actions/ratio.py", "actions/wheel_runs.py", "actions/focusing.py", "actions/leaving.py"),
        ("test_action_slips.py", "test_action_turning.py", "test_action_estimates.py", "test_action_wheel_runs.py",
         "test_action_wheel_drives.py", "test_action_combined_ratio.py", "test_action_tilt.py"),
    ),
    "machines": (
        ("machines/books.py", "machines/bookkeeping.py", "machines/guards.py", "machines/limits.py", "machines/investigate_books.py"),
        ("test_machine_guards.py", "test_machine_transitions.py", "test_machine_investigate.py", "test_machine_runtime.py"),
    ),
    "statechart": (
        ("statechart/activity.py", "statechart/books.py", "statechart/compile.py", "statechart/exhaustive.py",
         "statechart/explore.py", "statechart/from_file.py", "statechart/machinery.py", "statechart/partition.py",
         "statechart/probe.py", "statechart/runtime.py", "statechart/spec.py", "statechart/validate.py"),
        ("test_machine_tables.py", "test_machine_check.py", "test_machine_runtime.py", "test_machine_negative.py", "test_machine_partition.py",
         "test_machine_resume.py", "test_machine_transitions.py", "test_machine_investigate.py", "test_own_machine.py"),
    ),
    "runner": (
        ("runner/loop.py", "runner/session.py", "runner/record.py", "runner/hold.py", "runner/knowledge.py",
         "runner/logged.py", "runner/parts.py", "runner/gallery.py", "runner/result.py", "runner/lane_doubt.py"),
        ("test_runner_values.py", "test_runner_result.py", "test_runner_parts.py", "test_stops.py", "test_runner_recording.py", "test_runner_run.py", "test_lane_doubt.py"),
    ),
    "verdicts": (
        ("diagnosis/verdict/decide.py", "diagnosis/verdict/posterior.py", "diagnosis/verdict/support.py",
         "diagnosis/verdict/model.py", "diagnosis/verdict/systematic_error.py", "diagnosis/proof/gap.py",
         "diagnosis/proof/gates.py"),
        ("test_diagnosis_belief.py", "test_diagnosis_support.py", "test_diagnosis_verdict.py"),
    ),
}  # fmt: skip
EQUAL: dict[str, str] = {
    "journal.py: leave out kept.unlink(missing_ok=True)": "only a left-over of a killed process is removed",
    "journal.py: leave out file.flush()": "fsync of a closed file's twin: closing flushes, only a power cut tells",
    "actions/turning.py: and for or in before is None or after is None": "a look leaves a picture: either both or none",
    "actions/markers.py: plus for minus in x + y": "asked for is whether both are finite",
    "runner/result.py: plus for minus in run.wheel_ratio + run.k_i - 1.0": "a scatter does not know where numbers begin",
}
"""Mutants that do the same, or what no test can see, and why."""
SLIPS = (
    ast.Expr,
    ast.Compare,
    ast.If,
    ast.IfExp,
    ast.While,
    ast.BoolOp,
    ast.BinOp,
    ast.AugAssign,
    ast.Return,
)
"""Where a slip is possible, as `changed` knows them."""
PRELOADED = (
    "numpy",
    "scipy.optimize",
    "scipy.stats",
    "scipy.sparse",
    "cv2",
    "yaml",
    "pydantic",
    "pymunk",
    "transitions",
    "pytest",
)
"""What rooms need and no mutant changes: read once, so that a mutant's tests begin at once in a fork."""
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

    @property
    def module(self) -> str:
        """The module that the file is."""
        return "fsm_calib." + self.file.removesuffix(".py").replace("/", ".")


def mutants_of(file: str, source: str) -> Iterator[Mutant]:
    """Yield every mutant in a function of a file; what a module or a factory of functions does once stays out."""
    tree = ast.parse(source)
    owned = set(_in_functions(tree))
    places = [
        number for number, node in enumerate(ast.walk(tree)) if isinstance(node, SLIPS) and node in owned
    ]
    for number in places:
        tree = ast.parse(source)
        node = next(itertools.islice(ast.walk(tree), number, None))
        for what in changed(node):
            yield Mutant(file, getattr(node, "lineno", 0), what, ast.unparse(ast.fix_missing_locations(tree)))


def _in_functions(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes in bodies of functions and methods, without functions that functions make."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.ClassDef):
            yield from _in_functions(node)
        elif isinstance(node, ast.FunctionDef) and not any(
            isinstance(inner, ast.FunctionDef) for inner in ast.walk(node) if inner is not node
        ):
            for line in node.body:
                yield from ast.walk(line)


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


def run_tests(folder: Path, tests: tuple[str, ...], seconds: float, mutant: Mutant | None = None) -> int:
    """Return the tests' exit code against the package in a folder; a negative one where they took more processor time.

    The package is imported already, sound; in a fork of this process the functions of the mutant's file get its code.
    What waits for ever ends by the clock, which a busy machine needs many times as long for.
    """
    process = multiprocessing.get_context("fork").Process(
        target=_tests_end, args=(folder, tests, math.ceil(seconds), mutant)
    )
    process.start()
    process.join(BUSY * seconds)
    if process.is_alive():
        process.kill()
        process.join()
    return process.exitcode or 0


def _tests_end(folder: Path, tests: tuple[str, ...], seconds: int, mutant: Mutant | None) -> None:
    """Run the tests in this process, which is theirs alone, and leave with their exit code."""
    import pytest

    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    os.chdir(folder)
    sys.path[:0] = [str(folder), str(folder / "tests")]
    os.environ["PYTHONPATH"] = f"{folder}{os.pathsep}{os.environ.get('PYTHONPATH', '')}"
    for stream in (1, 2):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream)
    if mutant is not None:
        exchange(importlib.import_module(mutant.module), mutant.text)
    paths = [str(folder / "tests" / name) for name in tests if (folder / "tests" / name).exists()]
    os._exit(int(pytest.main(["-x", "-q", "-n", "0", "-p", "no:cacheprovider", *paths])))


def exchange(module: ModuleType, text: str) -> None:
    """Give the functions and methods of an imported module the code that they have in a text of it."""
    other = ModuleType(module.__name__)
    other.__dict__.update({"__file__": module.__file__, "__package__": module.__package__})
    sys.modules[module.__name__] = other  # dataclasses look their module up
    exec(compile(text, str(module.__file__), "exec"), other.__dict__)
    sys.modules[module.__name__] = module
    for name, new in list(vars(other).items()):
        if getattr(new, "__module__", None) == module.__name__:
            _exchange_code(vars(module).get(name), new)


def _exchange_code(old: object, new: object) -> None:
    if isinstance(new, type):
        for name, member in list(vars(new).items()):
            _exchange_code(vars(old).get(name), member)
        return
    old, new = _plain(old), _plain(new)
    if isinstance(old, FunctionType) and isinstance(new, FunctionType):
        old.__code__ = new.__code__


def _plain(member: object) -> object:
    """Return the function below what wraps it: a property, a class method, a decorator that says what it wraps."""
    for name in ("fget", "__func__", "func", "__wrapped__"):
        member = getattr(member, name, None) or member
    return member


def imported_by(tests: tuple[str, ...]) -> set[str]:
    """Return the package's modules that test files import."""
    trees = [ast.parse((ROOT / "tests" / name).read_text()) for name in tests]
    nodes = [node for tree in trees for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    return {node.module for node in nodes if node.module and node.module.startswith("fsm_calib.")}


def _processor_time() -> float:
    """Return what the processes that have ended took of the processor [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


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
        for part in ("fsm_calib", "tests", "benchmarks", "scenarios", "diagrams", "docs"):
            shutil.copytree(ROOT / part, folder / part, ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copy(ROOT / "pyproject.toml", folder)
        for module in {mutant.module for mutant in chosen} | imported_by(tests):
            importlib.import_module(module)
        before = _processor_time()
        if run_tests(folder, tests, 600.0) != 0:
            sys.exit(f"the tests of {room} fail on the sound code")
        limit = max(3.0 * (_processor_time() - before), 20.0)
        tried, survivors = 0, []
        for mutant in chosen:
            if time.monotonic() > until:
                break
            path = folder / "fsm_calib" / mutant.file
            sound = path.read_text()
            path.write_text(mutant.text)
            code = run_tests(folder, tests, limit, mutant)
            if code == 0:
                survivors.append(mutant)
            if code <= 0:
                said = "too long" if code else "survives"
                print(f"  {said}: {mutant.file}:{mutant.line}: {mutant.what}", flush=True)
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
    for name in PRELOADED:
        importlib.import_module(name)
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
