"""The page that explains the machines in words: `diagrams/README.md`, written from the tables."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import fields

from fsm_calib.machines.activities import ACTIVITIES, Activity
from fsm_calib.machines.failures import FAILURES
from fsm_calib.machines.limits import PUBLISHED, Limits
from fsm_calib.machines.spec import Chart
from fsm_calib.machines.supervisor import MACHINES, SUPERVISOR

INTRO = """\
# The machines

Written by `fsm-calib diagrams` from the tables in `fsm_calib/machines/`; `fsm-calib diagrams --check` fails
when this folder is stale. Each machine has a picture (`.svg`), the same as Mermaid text (`.mmd`, with
everything open) and as Graphviz text (`.dot`). `whole` holds everything in one picture.

How to read them: a box is a state, `do /` is the activity that the robot carries out while it is there, and
what the activity returns (its outcome) is the event that moves the machine on. An arrow says **outcome**
[guards, `!` is *not*] / bookkeeping. A row inside a box is an outcome that does not lead elsewhere: ↻ does
the activity again, ⇒ ends the run in the failure of that name.
"""


def machines_markdown() -> str:
    """Return the text of the page."""
    lines = [INTRO.rstrip()]
    for chart in (SUPERVISOR, *MACHINES):
        lines += _chart(chart)
    lines += ["", "## Activities and what they may return", ""]
    lines += _table(("activity", "does", "outcomes (evidence that guards read)"), map(_activity, ACTIVITIES))
    lines += ["", "## Failures", ""]
    lines += _table(("failure", "reason", "cure"), ((f"`{s.name}`", s.about, s.cure) for s in FAILURES))
    lines += ["", "## Limits", "", "Their meaning and source: `fsm_calib/machines/limits.py`.", ""]
    lines += _table(("limit", "default"), ((f"`{i.name}`", f"{i.default:.4g}") for i in fields(Limits)))
    lines += ["", "## Published behaviours that are limits", ""]
    lines += _table(
        ("name", "changes"), ((f"`{name}`", _changes(values)) for name, values in PUBLISHED.items())
    )
    return "\n".join(lines) + "\n"


def _chart(chart: Chart) -> Iterator[str]:
    name = chart.name
    yield from ("", f"## {name}", "", chart.about, "", f"![{name}]({name}.svg)", "")
    yield f"[Mermaid]({name}.mmd) · [Graphviz]({name}.dot)"
    yield ""
    inner = chart.walk() if chart is not SUPERVISOR else ((state.name, state) for state in chart.states)
    yield from _table(
        ("state", "what the robot does there", "activity"),
        ((f"`{path}`", state.about, f"`{state.do}`" if state.do else "") for path, state in inner),
    )


def _activity(activity: Activity) -> tuple[str, str, str]:
    said = []
    for item in activity.returns:
        keys = f" ({', '.join(item.keys)})" if item.keys else ""
        said.append(f"`{item.trigger}`{keys}")
    return f"`{activity.name}`", activity.does, ", ".join(said)


def _changes(values: dict[str, object]) -> str:
    return ", ".join(f"`{name}` = {value}" for name, value in values.items())


def _table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> Iterator[str]:
    yield f"| {' | '.join(head)} |"
    yield f"|{'---|' * len(head)}"
    for row in rows:
        yield f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in row)} |"
