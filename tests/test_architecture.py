"""The house: who may know whom, and which library lives where (docs/design)."""

import ast
from pathlib import Path

import pytest

import fsm_calib

ROOT = Path(fsm_calib.__file__).parent
GROUND = {"types", "errors"}
ROOMS = {
    "types": set(),
    "errors": set(),
    "ports": GROUND,
    "outcome": GROUND,
    "perception": GROUND,
    "world2d": GROUND | {"ports", "python_file"},
    "python_file": {"errors"},
    "statechart": {
        "errors",
        "python_file",
    },  # knows no robot; of ours only errors and how files are loaded
    "machines": GROUND | {"outcome", "statechart"},
    "actions": GROUND | {"ports", "perception", "outcome"},
    "recording": GROUND | {"perception"},
    "robots": GROUND | {"ports", "recording", "world2d"},
    "diagnosis": GROUND | {"recording", "world2d"},
}
COMPOSERS = {
    "scenario",
    "runner",
    "journal",
    "report",
    "study",
    "cli",
    "commands",
    "shipped",
    "demo",
    "targets",
    "watch",
}
HOMES = {
    "pymunk": {"world2d"},
    "transitions": {"statechart"},
    "cv2": {"perception", "world2d"},
    "rosbags": {"recording"},
}


def room_of(path: Path) -> str:
    parts = path.relative_to(ROOT).parts
    return parts[0] if len(parts) > 1 else path.stem


def imported_names(path: Path) -> list[str]:
    names: list[str] = []
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.append(node.module)
            if node.module == "fsm_calib":
                names += [f"fsm_calib.{alias.name}" for alias in node.names]
    return names


FILES = sorted(ROOT.rglob("*.py"))


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(ROOT)))
def test_file_imports_only_what_its_room_may_know(path: Path) -> None:
    room = room_of(path)
    if room not in ROOMS:
        return
    for name in imported_names(path):
        parts = name.split(".")
        if parts[0] == "fsm_calib" and len(parts) > 1 and parts[1] in ROOMS.keys() | COMPOSERS:
            assert parts[1] in ROOMS[room] | {room}, f"{room} may not import {parts[1]}"


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(ROOT)))
def test_library_is_imported_only_at_home(path: Path) -> None:
    room = room_of(path)
    for name in imported_names(path):
        homes = HOMES.get(name.split(".")[0])
        assert homes is None or room in homes, f"{name} lives in {sorted(homes or ())}, not in {room}"
