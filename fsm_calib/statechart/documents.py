"""The page that explains the machines in words: `diagrams/README.md`, written from the tables."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields

from fsm_calib.statechart.activity import Activity
from fsm_calib.statechart.machinery import Machinery
from fsm_calib.statechart.spec import Chart

INTRO = """\
# The machines

Written by `fsm-calib diagrams` from the tables in `{home}`; `fsm-calib diagrams --check` fails
when this folder is stale. Each machine has a picture (`.svg`), the same as Mermaid text (`.mmd`, with
everything open) and as Graphviz text (`.dot`).{whole}

How to read them: a box is a state, `do /` is the activity that the robot carries out while it is there, and
what the activity returns (its outcome) is the event that moves the machine on. An arrow says **outcome**
[guards, `!` is *not*] / bookkeeping. A row inside a box is an outcome that does not lead elsewhere: ↻ does
the activity again, ⇒ ends the run in the failure of that name.
"""


WHOLE = " `whole` holds everything in one picture."


def machines_markdown(machinery: Machinery) -> str:
    """Return the text of the page."""
    lines = [INTRO.format(home=machinery.home, whole=WHOLE if machinery.phases else "").rstrip()]
    for chart in (machinery.root, *machinery.machines):
        lines += _chart(chart, closed=bool(machinery.phases) and chart is machinery.root)
    lines += ["", "## Activities and what they may return", ""]
    used = {state.do for state in machinery.leaves.values()}
    activities = [activity for activity in machinery.contract.values() if activity.name in used]
    lines += _table(("activity", "does", "outcomes (evidence that guards read)"), map(_activity, activities))
    failures = [state for state in machinery.leaves.values() if state.reason]
    lines += ["", "## Failures", ""]
    lines += _table(("failure", "reason", "cure"), ((f"`{s.name}`", s.about, s.cure) for s in failures))
    lines += _limits(machinery)
    return "\n".join(lines) + "\n"


def _limits(machinery: Machinery) -> Iterator[str]:
    known = fields(machinery.limits)
    if known:
        yield from ("", "## Limits", "", f"Their meaning and source: `{machinery.limits_home}`.", "")
        yield from _table(("limit", "default"), ((f"`{i.name}`", f"{i.default:.4g}") for i in known))
    if machinery.published:
        yield from ("", "## Published behaviours that are limits", "")
        rows = ((f"`{name}`", _changes(values)) for name, values in machinery.published.items())
        yield from _table(("name", "changes"), rows)


def _chart(chart: Chart, *, closed: bool) -> Iterator[str]:
    name = chart.name
    yield from ("", f"## {name}", "", chart.about, "", f"![{name}]({name}.svg)", "")
    yield f"[Mermaid]({name}.mmd) · [Graphviz]({name}.dot)"
    yield ""
    inner = ((state.name, state) for state in chart.states) if closed else chart.walk()
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


def _changes(values: Mapping[str, object]) -> str:
    return ", ".join(f"`{name}` = {value}" for name, value in values.items())


def _table(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> Iterator[str]:
    yield f"| {' | '.join(head)} |"
    yield f"|{'---|' * len(head)}"
    for row in rows:
        yield f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in row)} |"
