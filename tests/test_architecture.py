"""The house: who may know whom, and which library lives where (docs/architecture.md)."""

from __future__ import annotations

import ast
import sys
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import fsm_calib

ROOT = Path(fsm_calib.__file__).parent
sys.path.insert(0, str(ROOT.parent / "benchmarks"))

from house_imports import (  # noqa: E402
    DIAGNOSIS,
    MAY_KNOW,
    House,
    diagnosis,
    files_of,
    problems,
    svg,
    whole_house,
)

HOMES = {
    "pymunk": {"world2d"},
    "transitions": {"statechart"},
    "cv2": {"perception", "world2d"},
    "rosbags": {"recording"},
}
FILES = files_of(ROOT)


def test_no_room_knows_what_it_may_not_and_nothing_goes_in_a_circle() -> None:
    assert problems(FILES) == []


def test_the_plan_itself_has_no_circle_and_no_room_that_is_gone() -> None:
    order = list(TopologicalSorter(MAY_KNOW).static_order())
    assert order.index("types") < order.index("world2d") < order.index("runner") < order.index("cli")
    assert set(MAY_KNOW) == set(whole_house(FILES).rooms)
    assert set(DIAGNOSIS) == set(diagnosis(FILES).rooms)


def figures(house: House) -> str:
    """Return a house's row in the table of docs/architecture.md, without its name."""
    return f"| {len(house.rooms)} | {max(house.floors.values())} | {len(house.arrows)} | {len(house.up)} |"


def test_the_page_of_the_house_shows_the_house_as_it_stands() -> None:
    docs = ROOT.parent / "docs"
    page = (docs / "architecture.md").read_text(encoding="utf-8")
    assert figures(whole_house(FILES)) in page
    assert figures(diagnosis(FILES)) in page
    assert (docs / "pictures" / "house.svg").read_text(encoding="utf-8") == svg(whole_house(FILES))


def test_the_rooms_above_are_unknown_to_those_below() -> None:
    composers = {"scenario", "runner", "journal", "report", "study", "progress", "watch", "commands", "cli"}
    below = (
        "types",
        "errors",
        "ports",
        "outcome",
        "perception",
        "world2d",
        "statechart",
        "machines",
        "actions",
    )
    assert not any(MAY_KNOW[room] & composers for room in (*below, "recording", "robots", "diagnosis"))
    assert not MAY_KNOW["runner"] & {"report", "study", "progress", "watch", "commands", "cli"}
    assert not any("cli" in known for room, known in MAY_KNOW.items() if room != "cli" and room != "commands")


@cache
def libraries(source: str) -> set[str]:
    """The packages that a file imports."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names.add(node.module.split(".")[0])
    return names


def homeless(files: dict[str, str]) -> list[str]:
    """Libraries that are imported away from their home."""
    return [
        f"{path}: {name} lives in {', '.join(sorted(HOMES[name]))}"
        for path, source in files.items()
        for name in sorted(libraries(source) & set(HOMES))
        if path.split("/")[0].removesuffix(".py") not in HOMES[name]
    ]


def test_each_library_is_imported_only_at_home() -> None:
    assert homeless(FILES) == []


@pytest.mark.parametrize(
    ("path", "line"),
    [
        ("types.py", "from fsm_calib.errors import InputError"),
        ("machines/scan.py", "from fsm_calib.actions.bench import Bench"),
        ("statechart/runtime.py", "from fsm_calib.outcome import Outcome"),
        ("perception/focus.py", "import fsm_calib.world2d.scene"),
        ("actions/looking.py", "def late():\n    from fsm_calib.world2d.truth import Truth"),
        ("runner/run.py", "from fsm_calib.report.run_report import run_report"),
        ("report/palette.py", "from ..commands import run"),
        ("journal.py", "from fsm_calib import runner"),
        ("diagnosis/likelihood/noise.py", "from fsm_calib.diagnosis.verdict.decide import decide"),
        ("diagnosis/replay/kinematics.py", "from ..fitting import newton"),
        ("study/load.py", "import fsm_calib.cli"),
        ("machines/limits.py", "from fsm_calib.machines.guards import is_sharp"),
        ("runner/loop.py", "import transitions"),
        ("new_room/new.py", "from fsm_calib.types import Pose2"),
    ],
)
def test_a_wrong_import_is_found(path: str, line: str) -> None:
    planted = FILES | {path: f"{FILES.get(path, '')}\n{line}\n"}
    assert problems(planted) + homeless(planted) != []
