"""Mermaid text of a machine, as GitHub draws it; the active states are marked.

Source of the notation: mermaid.js.org/syntax/stateDiagram.html. The library's own writer does not mark nested
states, hence this one.
"""

from __future__ import annotations

from collections.abc import Iterator

from fsm_calib.statechart.picture import Box, Picture
from fsm_calib.statechart.spec import SEPARATOR

STYLES = (
    "classDef active fill:#ffd54f,stroke:#e65100,stroke-width:3px,color:#000000",
    "classDef good fill:#c8e6c9,stroke:#2e7d32,color:#000000",
    "classDef failure fill:#ffcdd2,stroke:#c62828,color:#000000",
    "classDef outside fill:#eceff1,stroke:#607d8b,stroke-dasharray:4,color:#000000",
)
STAY = " ↻"
"""After a row that stays in its state."""
LINE = "<br/>"
"""Between the labels of one arrow."""
CLASSES = {"end": "good", "failure": "failure", "outside": "outside"}


def mermaid_text(drawn: Picture, active: str = "") -> str:
    """Return the Mermaid state diagram of `drawn`, with the leaf `active` and the states around it marked."""
    lines = ["---", f"title: {drawn.name}", "---", "stateDiagram-v2", "    direction TB"]
    lines += [f"    [*] --> {ident(drawn.start)}"]
    for box in drawn.boxes:
        lines += _box_lines(box, "    ")
    for arrow in drawn.arrows:
        words = LINE.join(label.text for label in arrow.labels)
        lines.append(f"    {ident(arrow.source)} --> {ident(arrow.dest)} : {words}")
    lines += [f"    {style}" for style in STYLES]
    lines += [
        f"    class {ident(box.path)} {CLASSES[box.kind]}" for box in all_boxes(drawn) if box.kind in CLASSES
    ]
    drawn_paths = {box.path for box in all_boxes(drawn)}
    lines += [f"    class {ident(path)} active" for path in around(active) if path in drawn_paths]
    return "\n".join(lines) + "\n"


def _box_lines(box: Box, indent: str) -> Iterator[str]:
    yield f'{indent}state "{box.title}" as {ident(box.path)}'
    if box.inside:
        yield f"{indent}state {ident(box.path)} {{"
        for child in box.inside:
            yield from _box_lines(child, indent + "    ")
        yield f"{indent}}}"
        return
    if box.do:
        yield f"{indent}{ident(box.path)} : do / {box.do}"
    for row in box.rows:
        yield f"{indent}{ident(box.path)} : {row.text}{'' if row.end else STAY}"


def ident(path: str) -> str:
    """Return the identifier of a state in a diagram's text: the path with ``__`` for ``/``."""
    return path.removeprefix(SEPARATOR).replace(SEPARATOR, "__")


def around(active: str) -> tuple[str, ...]:
    """Return the paths of the leaf `active` and of all states around it, outermost first."""
    parts = active.split(SEPARATOR) if active else []
    return tuple(SEPARATOR.join(parts[:n]) for n in range(1, len(parts) + 1))


def all_boxes(drawn: Picture) -> Iterator[Box]:
    """Yield every box of `drawn`, those inside others included."""
    stack = list(reversed(drawn.boxes))
    while stack:
        box = stack.pop()
        yield box
        stack.extend(reversed(box.inside))
