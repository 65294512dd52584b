"""Draws who imports whom: the rooms of the house and of the diagnosis, their floors, the arrows between them.

    python3 benchmarks/house_imports.py [--svg FILE] [--mermaid FILE] [--check]

A floor is one more than the highest floor that a room stands on. An arrow runs up when it leads to a room that the
plan (`MAY_KNOW`, `DIAGNOSIS`) does not put below. Arrows count every import, circles those that run at loading. `--check` fails on circles, on arrows that run up and on bars broken.
"""

from __future__ import annotations

import argparse
import ast
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from html import escape
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGE = "fsm_calib"
Files = Mapping[str, str]
"""Source text by path below the package, with `/`."""
Import = ast.Import | ast.ImportFrom
Arrows = dict[tuple[str, str], list[str]]
"""What makes each arrow: ``file -> module``."""

GROUND = {"types", "errors"}
PHYSICS = GROUND | {"ports", "python_file"}
BELOW_RUNNER = GROUND | {
    "actions", "calibration_files", "diagnosis", "journal", "machines", "outcome", "perception", "ports",
    "recording", "robots", "scenario", "statechart", "stops", "workers", "world2d",
}  # fmt: skip
MAY_KNOW: dict[str, set[str]] = {
    "types": set(),
    "errors": set(),
    "python_file": {"errors"},
    "stops": GROUND,
    "workers": {"stops"},
    "sealed": GROUND,
    "shipped": GROUND,
    "ports": GROUND,
    "outcome": GROUND,
    "perception": GROUND,
    "world2d": PHYSICS,
    "statechart": {"errors", "python_file"},
    "machines": GROUND | {"outcome", "statechart"},
    "actions": GROUND | {"ports", "perception", "outcome"},
    "recording": GROUND | {"perception"},
    "robots": GROUND | {"ports", "recording", "world2d"},
    "diagnosis": GROUND | {"recording", "workers", "world2d"},
    "targets": GROUND | {"perception", "world2d"},
    "demo": GROUND | {"recording", "world2d"},
    "journal": GROUND | {"sealed"},
    "scenario": GROUND | {"actions", "machines", "robots", "statechart", "world2d"},
    "calibration_files": GROUND | {"journal", "scenario"},
    "runner": BELOW_RUNNER,
    "study": BELOW_RUNNER | {"runner"},
    "fleet": GROUND | {"diagnosis", "journal", "recording", "study"},
    "report": BELOW_RUNNER | {"runner", "study"},
    "progress": GROUND | {"outcome", "runner", "study"},
    "answers": GROUND | {"diagnosis", "perception", "report"},
    "watch": GROUND | {"journal", "report", "scenario", "shipped", "world2d"},
}
"""Which room may know which. `commands` may know all of these, `cli` all of these and `commands`."""
MAY_KNOW["commands"] = set(MAY_KNOW)
MAY_KNOW["api"] = set(MAY_KNOW)
MAY_KNOW["cli"] = set(MAY_KNOW)
TOP = "top"
"""The room of the files that lie beside the rooms of the diagnosis and put them together."""
DIAGNOSIS = (
    "replay", "likelihood", "fitting", "identify", "shapes", "candidates", "proof", "verdict", "design", TOP,
)  # fmt: skip
"""The rooms of the diagnosis in the order in which its data flows: each may know those before it."""
MOST_ROOMS, MOST_FLOORS, MOST_ARROWS = 12, 8, 40
"""Bars of the diagnosis."""


@dataclass(frozen=True)
class House:
    """Rooms, the arrows between them, and the plan: which room may know which."""

    name: str
    rooms: tuple[str, ...]
    arrows: Arrows
    plan: Mapping[str, set[str]]

    @property
    def floors(self) -> dict[str, int]:
        """The floor of each room, from 1; rooms in a circle share one."""
        below = {room: {dest for source, dest in self.arrows if source == room} for room in self.rooms}
        floors = dict.fromkeys(self.rooms, 1)
        for _ in self.rooms:
            for room in self.rooms:
                floors[room] = 1 + max((floors[dest] for dest in below[room]), default=0)
        return {room: min(floor, len(self.rooms)) for room, floor in floors.items()}

    @property
    def up(self) -> list[str]:
        """The imports that the plan does not allow, and rooms that it does not know."""
        strangers = [
            f"{room}: no such room in the plan of {self.name}; give it a row in benchmarks/house_imports.py"
            for room in self.rooms
            if room not in self.plan
        ]
        return strangers + [
            f"{said}: {source} may not know {dest}"
            for (source, dest), found in self.arrows.items()
            for said in found
            if dest not in self.plan.get(source, set())
        ]


def files_of(root: Path = ROOT / PACKAGE) -> dict[str, str]:
    """Return the package's source text by path."""
    return {str(path.relative_to(root).as_posix()): path.read_text() for path in sorted(root.rglob("*.py"))}


def imports(files: Files, *, at_load: bool = False) -> Iterator[tuple[str, str]]:
    """Yield (file, imported module below the package) of every import, or of those that run when a file is loaded."""
    modules = {module_name(path) for path in files}
    for path, text in files.items():
        for node in _import_statements(text, at_load):
            for name in _named(node, path):
                while name and name not in modules:
                    name = name.rpartition(".")[0]
                if name and name != module_name(path):
                    yield path, name


@cache
def _import_statements(text: str, at_load: bool) -> tuple[Import, ...]:
    """Return a file's imports; kept, since a test asks of the whole house once for each wrong import that it plants."""
    tree = ast.parse(text)
    nodes = _loaded(tree) if at_load else ast.walk(tree)
    return tuple(node for node in nodes if isinstance(node, Import))


def _loaded(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield the parts of a file that run when it is loaded: no functions, nothing for the type checker alone."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
            continue
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
            continue
        yield node
        yield from _loaded(node)


def module_name(path: str) -> str:
    """Return a file's module below the package: ``machines/scan.py`` is ``machines.scan``."""
    return path.removesuffix(".py").removesuffix("/__init__").replace("/", ".")


def _named(node: Import, path: str) -> Iterable[str]:
    """Return the modules that an import names, below the package."""
    if isinstance(node, ast.Import):
        return [a.name.removeprefix(f"{PACKAGE}.") for a in node.names if a.name.startswith(f"{PACKAGE}.")]
    if node.level:
        around = ["", *path.split("/")[:-1]][: -(node.level - 1) or None]
        base = ".".join([*filter(None, around), *filter(None, [node.module])])
    elif node.module == PACKAGE:
        base = ""
    elif node.module and node.module.startswith(f"{PACKAGE}."):
        base = node.module.removeprefix(f"{PACKAGE}.")
    else:
        return []
    return [f"{base}.{alias.name}".removeprefix(".") for alias in node.names]


def room_of(path: str) -> str:
    """Return the room of a file in the house; a file at the top of the package is a room by itself."""
    return path.split("/")[0].removesuffix(".py")


def inner_room_of(path: str) -> str:
    """Return the room of a file inside the diagnosis; empty for files elsewhere."""
    first, _, rest = path.partition("/")
    if first != "diagnosis" or rest == "__init__.py":
        return ""
    return rest.split("/")[0] if "/" in rest else TOP


def whole_house(files: Files) -> House:
    """Return the house: the rooms of the package."""
    return _house("the house", files, room_of, MAY_KNOW)


def diagnosis(files: Files) -> House:
    """Return the rooms inside `diagnosis`."""
    plan = {room: set(DIAGNOSIS[:number]) for number, room in enumerate(DIAGNOSIS)}
    return _house("diagnosis", files, inner_room_of, plan)


def _house(name: str, files: Files, room: Callable[[str], str], plan: Mapping[str, set[str]]) -> House:
    path_of = {module_name(path): path for path in files}
    arrows: Arrows = {}
    for path, module in sorted(set(imports(files))):
        ends = room(path), room(path_of[module])
        if all(ends) and ends[0] != ends[1]:
            arrows.setdefault(ends, []).append(f"{path} -> {module}")
    rooms = {room(path) for path in files} - {"", "__init__"}
    return House(name, tuple(sorted(rooms)), arrows, plan)


def circles(files: Files) -> list[list[str]]:
    """Return the circles among the modules of the package: each a list of modules that load each other."""
    graph: dict[str, set[str]] = {module_name(path): set() for path in files}
    for path, module in imports(files, at_load=True):
        if not _is_around(module, module_name(path)):
            graph[module_name(path)].add(module)
    return [sorted(group) for group in _components(graph) if len(group) > 1]


def _is_around(outer: str, inner: str) -> bool:
    """Whether `outer` is a package around `inner`, which Python imports first in any case."""
    return inner.startswith(f"{outer}.")


def _components(graph: Mapping[str, set[str]]) -> list[set[str]]:
    """Return the strongly connected parts of a graph (Kosaraju)."""
    order: list[str] = []
    _walk(graph, list(graph), order)
    back: dict[str, set[str]] = {node: set() for node in graph}
    for node, dests in graph.items():
        for dest in dests:
            back[dest].add(node)
    groups: list[set[str]] = []
    seen: set[str] = set()
    for node in reversed(order):
        if node not in seen:
            found: list[str] = []
            _walk(back, [node], found, seen)
            groups.append(set(found))
    return groups


def _walk(
    graph: Mapping[str, set[str]], starts: list[str], order: list[str], seen: set[str] | None = None
) -> None:
    """Append the nodes reached from `starts` to `order`, each after those that it leads to."""
    seen = set() if seen is None else seen
    for start in starts:
        stack = [(start, iter(sorted(graph[start])))] if start not in seen else []
        seen.add(start)
        while stack:
            node, dests = stack[-1]
            fresh = next((dest for dest in dests if dest not in seen), None)
            if fresh is None:
                order.append(node)
                stack.pop()
            else:
                seen.add(fresh)
                stack.append((fresh, iter(sorted(graph[fresh]))))


def problems(files: Files) -> list[str]:
    """Return everything that is wrong: arrows that run up, circles, bars of the diagnosis broken."""
    house, inner = whole_house(files), diagnosis(files)
    found = house.up + inner.up
    found += [f"circle: {' -> '.join(group)}" for group in circles(files)]
    figures = (len(inner.rooms), max(inner.floors.values(), default=0), len(inner.arrows))
    for figure, most, what in zip(
        figures, (MOST_ROOMS, MOST_FLOORS, MOST_ARROWS), ("rooms", "floors", "arrows"), strict=True
    ):
        if figure > most:
            found.append(f"diagnosis has {figure} {what}, {most} at most")
    return found


def text(house: House) -> str:
    """Return a house as text: from the top floor down, each room with those that it knows."""
    floors = house.floors
    lines = [
        f"{house.name}: {len(house.rooms)} rooms, {max(floors.values())} floors, {len(house.arrows)} arrows, {len(house.up)} run up"
    ]
    for floor in range(max(floors.values()), 0, -1):
        for room in (room for room in house.rooms if floors[room] == floor):
            known = sorted(dest for source, dest in house.arrows if source == room)
            lines.append(f"  {floor:2d}  {room:18s} {' '.join(known)}".rstrip())
    return "\n".join(lines)


def mermaid(house: House) -> str:
    """Return a house as a Mermaid flow chart; arrows lead to what a room knows, those that run on are left out."""
    lines = ["flowchart TB"]
    floors = house.floors
    for floor in range(max(floors.values()), 0, -1):
        names = "; ".join(f"{room}" for room in house.rooms if floors[room] == floor)
        lines.append(f"    subgraph floor{floor} [{floor}]\n        {names}\n    end")
    lines += [f"    {source} --> {dest}" for source, dest in direct(house)]
    return "\n".join(lines) + "\n"


def direct(house: House) -> list[tuple[str, str]]:
    """Return the arrows that no way over other rooms stands for."""
    below = {room: {dest for source, dest in house.arrows if source == room} for room in house.rooms}

    def reaches(room: str, goal: str, seen: set[str]) -> bool:
        fresh = below[room] - seen
        return goal in fresh or any(reaches(dest, goal, seen | fresh) for dest in fresh)

    return [
        (source, dest)
        for source, dest in sorted(house.arrows)
        if not any(reaches(other, dest, {source}) for other in below[source] - {dest})
    ]


BOX, GAP, ROW, MARGIN = (132, 30), 14, 74, 20
"""Size of a room [px], the gaps between rooms and between floors."""


def svg(house: House) -> str:
    """Return a house as a picture: floors above each other, direct arrows from room to room."""
    floors = house.floors
    rows = [
        [room for room in house.rooms if floors[room] == floor]
        for floor in range(max(floors.values()), 0, -1)
    ]
    width = max(len(row) for row in rows) * (BOX[0] + GAP) + 2 * MARGIN
    height = len(rows) * ROW + 2 * MARGIN
    places = {}
    for number, row in enumerate(rows):
        begin = (width - len(row) * (BOX[0] + GAP) + GAP) / 2
        for column, room in enumerate(row):
            places[room] = (begin + column * (BOX[0] + GAP), MARGIN + number * ROW)
    marker = (
        '<marker id="a" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="6" markerHeight="6" orient="auto">'
    )
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" font-family="Helvetica" font-size="13">',
        f"<title>{escape(house.name)}: who imports whom</title>",
        f'<defs>{marker}<path d="M0 0L8 4L0 8z" fill="#607d8b"/></marker></defs>',
        f'<rect width="{width:g}" height="{height:g}" fill="#ffffff"/>',
    ]
    for source, dest in direct(house):
        (x0, y0), (x1, y1) = places[source], places[dest]
        begin, end = f"{x0 + BOX[0] / 2:g} {y0 + BOX[1]:g}", f"{x1 + BOX[0] / 2:g} {y1:g}"
        lines.append(f'<path d="M{begin} L{end}" stroke="#90a4ae" fill="none" marker-end="url(#a)"/>')
    for room, (x, y) in places.items():
        lines.append(
            f'<rect x="{x:g}" y="{y:g}" width="{BOX[0]}" height="{BOX[1]}" rx="5" fill="#e3f2fd" stroke="#1565c0"/>'
        )
        lines.append(
            f'<text x="{x + BOX[0] / 2:g}" y="{y + 20:g}" text-anchor="middle">{escape(room)}</text>'
        )
    return "\n".join([*lines, "</svg>"]) + "\n"


def main() -> int:
    """Print both drawings, write pictures, and say what is wrong."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--svg", type=Path, help="write the house as a picture")
    parser.add_argument("--mermaid", type=Path, help="write the house as a Mermaid flow chart")
    parser.add_argument("--check", action="store_true", help="fail when something is wrong")
    options = parser.parse_args()
    files = files_of()
    house = whole_house(files)
    print(text(house), text(diagnosis(files)), sep="\n\n")
    print(f"\ncircles among {len(files)} modules: {len(circles(files))}")
    if options.svg:
        options.svg.write_text(svg(house), encoding="utf-8")
    if options.mermaid:
        options.mermaid.write_text(mermaid(house), encoding="utf-8")
    found = problems(files)
    print("\n".join(found))
    return 1 if options.check and found else 0


if __name__ == "__main__":
    sys.exit(main())
