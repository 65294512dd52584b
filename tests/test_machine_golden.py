"""The table as it was reviewed: a change of any row shows as a difference here and must be reviewed again."""

from __future__ import annotations

import csv
from pathlib import Path

from fsm_calib.machines.supervisor import SUPERVISOR

GOLDEN = Path(__file__).parent / "golden" / "transitions.csv"
HEAD = ["source", "trigger", "condition", "dest", "actions"]


def rows() -> list[list[str]]:
    return [
        [edge.source, edge.trigger, edge.condition, edge.dest or "(stay)", " ".join(edge.actions)]
        for edge in SUPERVISOR.all_transitions()
    ]


def test_declared_rows_are_the_reviewed_ones() -> None:
    with GOLDEN.open(newline="", encoding="utf-8") as file:
        reviewed = list(csv.reader(file))
    assert reviewed[0] == HEAD
    assert [row for row in rows() if row not in reviewed] == [], "declared, but not reviewed"
    assert [row for row in reviewed[1:] if row not in rows()] == [], "reviewed, but no longer declared"
    assert len(reviewed) - 1 == len(rows())
