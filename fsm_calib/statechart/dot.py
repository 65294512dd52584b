"""Graphviz DOT text of a machine, for the pictures that people open.

Source of the notation: graphviz.org/doc/info/shapes.html (HTML-like labels) and graphviz.org/docs/attrs/.
"""

from __future__ import annotations

from collections.abc import Iterator
from html import escape

from fsm_calib.statechart.mermaid import STAY, all_boxes, around, ident
from fsm_calib.statechart.picture import Arrow, Box, Label, Picture

FILLS = {
    "leaf": "#e3f2fd",
    "composite": "#fafafa",
    "closed": "#ede7f6",
    "end": "#c8e6c9",
    "failure": "#ffcdd2",
    "outside": "#eceff1",
    "every": "#ffffff",
}
EDGES = {
    "leaf": "#1565c0",
    "composite": "#90a4ae",
    "closed": "#5e35b1",
    "end": "#2e7d32",
    "failure": "#c62828",
    "outside": "#607d8b",
    "every": "#b0bec5",
}
ACTIVE_FILL, ACTIVE_EDGE = "#ffd54f", "#e65100"
WIDTH = 38
"""Characters of a line inside a box."""
LEFT = '<br align="left"/>'


LEGEND = (
    '<table border="0" cellborder="0" cellspacing="0"><tr><td align="left" balign="left">'
    '<font point-size="9" color="#546e7a">do / what the robot does here; its outcome is the event<br/>'
    "<b>outcome</b> [guards, ! is not] <i>/ bookkeeping</i><br/>"
    "↻ do it again &nbsp; ⇒ the run ends there</font></td></tr></table>"
)


def dot_text(drawn: Picture, active: str = "") -> str:
    """Return the DOT text of `drawn`, with the leaf `active` and the states around it marked."""
    marked = set(around(active))
    lines = [
        f'digraph "{drawn.name}" {{',
        "  rankdir=TB; newrank=true; nodesep=0.4; ranksep=0.5;",
        f"  label=<<b>{escape(drawn.name)}</b><br/>{escape(drawn.about)}>; labelloc=t; fontsize=16;",
        '  fontname="Helvetica"; node [fontname="Helvetica" fontsize=11 shape=plain];',
        '  edge [fontname="Helvetica" fontsize=9 color="#455a64" arrowsize=0.8];',
        '  "[*]" [shape=circle style=filled fillcolor=black label="" width=0.15];',
    ]
    for box in drawn.boxes:
        lines += _box_lines(box, marked, "  ")
    lines.append(f'  "[*]" -> "{ident(drawn.start)}";')
    lines.append(f'  "legend" [label=<{LEGEND}>];')
    leaf_of = {box.path: _first_leaf(box) for box in all_boxes(drawn)}
    lines += [_arrow_line(arrow, leaf_of) for arrow in drawn.arrows]
    return "\n".join([*lines, "}"]) + "\n"


def _first_leaf(box: Box) -> str:
    return _first_leaf(box.inside[0]) if box.inside else box.path


def _box_lines(box: Box, marked: set[str], indent: str) -> Iterator[str]:
    fill = ACTIVE_FILL if box.path in marked else FILLS[box.kind]
    edge = ACTIVE_EDGE if box.path in marked else EDGES[box.kind]
    if not box.inside:
        yield f'{indent}"{ident(box.path)}" [label=<{_table(box, fill, edge)}>];'
        return
    soft = "#fff8e1" if box.path in marked else fill
    yield f'{indent}subgraph "cluster_{ident(box.path)}" {{'
    yield f'{indent}  style="rounded,filled"; fillcolor="{soft}"; color="{edge}"; fontsize=13;'
    yield f"{indent}  label=<<b>{escape(box.title)}</b>{_about(box)}>;"
    for child in box.inside:
        yield from _box_lines(child, marked, indent + "  ")
    yield f"{indent}}}"


def _about(box: Box) -> str:
    return f' <font point-size="10" color="#546e7a">{escape(box.about)}</font>' if box.about else ""


def _table(box: Box, fill: str, edge: str) -> str:
    head = f"<b>{escape(box.title)}</b>"
    if box.about:
        head += f'<br/><font point-size="9" color="#546e7a">{_wrapped(box.about)}</font>'
    cells = [f'<tr><td align="center" cellpadding="5">{head}</td></tr>']
    if box.do:
        cells.append(
            f'<hr/><tr><td align="left"><font color="#0d47a1">do / {escape(box.do)}</font></td></tr>'
        )
    if box.rows:
        cells.append("<hr/>")
        cells += [f'<tr><td align="left" balign="left">{_row(row)}</td></tr>' for row in box.rows]
    style = f'style="rounded" border="1" cellborder="0" cellspacing="0" bgcolor="{fill}" color="{edge}"'
    return f"<table {style}>{''.join(cells)}</table>"


def _row(label: Label) -> str:
    end = f' <font color="#c62828">⇒ {_wrapped(label.end, LEFT)}</font>' if label.end else STAY
    return f'<font point-size="9">{_said(label)}{end}</font>'


def _said(label: Label) -> str:
    text = f"<b>{escape(label.trigger)}</b>" if label.trigger else ""
    if label.condition:
        text += f' <font color="#6a1b9a">[{_wrapped(label.condition, LEFT)}]</font>'
    return text + (f" <i>/ {_wrapped(label.actions, LEFT)}</i>" if label.actions else "")


def _wrapped(text: str, line_break: str = "<br/>") -> str:
    lines, line = [], ""
    for word in text.split():
        if line and len(line) + len(word) >= WIDTH:
            lines.append(line)
            line = ""
        line = f"{line} {word}".strip()
    return line_break.join(escape(part) for part in [*lines, line])


def _arrow_line(arrow: Arrow, leaf_of: dict[str, str]) -> str:
    source, dest = leaf_of[arrow.source], leaf_of[arrow.dest]
    label = "".join(_said(item) + LEFT for item in arrow.labels)
    return f'  "{ident(source)}" -> "{ident(dest)}" [label=<{label}>];'
