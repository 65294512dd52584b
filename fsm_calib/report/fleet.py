"""A fleet of real robots as one CSV and one page, worst first."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from fsm_calib.errors import shown
from fsm_calib.journal import write_atomically
from fsm_calib.report.pages import page

TEMPLATE = "fleet.html.j2"
COLUMNS = (
    "robot", "pulls", "after_1_m_cm", "sd_cm", "wheel_ratio", "wheel_ratio_sd", "gain", "trim", "verdict", "names",
    "recordings", "error",
)  # fmt: skip
"""Columns of the table; ``after_1_m_cm`` is positive to the left."""


def write_fleet(rows: Sequence[dict[str, Any]], directory: Path) -> list[Path]:
    """Write ``fleet.csv`` and ``index.html`` into a folder; return both. The rows come worst first."""
    table = [cells(row) for row in rows]
    text = io.StringIO()
    writer = csv.DictWriter(text, COLUMNS, extrasaction="ignore", lineterminator="\n")
    writer.writeheader()
    writer.writerows(table)
    contents = {"fleet.csv": text.getvalue(), "index.html": fleet_page(table)}
    for name, content in contents.items():
        write_atomically(directory / name, content.encode())
    return [directory / name for name in contents]


def fleet_page(table: Sequence[dict[str, Any]]) -> str:
    """Return the page of a fleet's `cells` as HTML."""
    told = [row for row in table if not row["error"]]
    failed = [row for row in table if row["error"]]
    widest = max((abs(float(row["after_1_m_cm"])) for row in told if row["after_1_m_cm"]), default=0.0)
    return page(
        TEMPLATE, told=told, failed=failed, widest=widest or 1.0, diagnosed=any(r["verdict"] for r in told)
    )


def cells(row: dict[str, Any]) -> dict[str, str]:
    """Return a robot's row as text by `COLUMNS`, what is not told empty, and beside them why it is not (`untold`)."""
    straight, trim = row.get("straight") or {}, row.get("trim") or {}
    diagnosis = row.get("diagnosis") or {}
    ratio = row.get("identify", {}).get("wheel_ratio") or {}
    names = [f"{e['name']} ({e['confidence']:.2f})" for e in diagnosis.get("effects", ())]
    pulls = "" if not straight else straight["side"] or "straight"
    refused = diagnosis.get("error", {}).get("reason", "")
    return {
        "robot": row["robot"],
        "pulls": pulls,
        "after_1_m_cm": _number(straight.get("sideways_m"), 100.0, 2),
        "sd_cm": _number(straight.get("sd_m"), 100.0, 2),
        "wheel_ratio": _number(ratio.get("value"), 1.0, 5),
        "wheel_ratio_sd": _number(ratio.get("sd"), 1.0, 5),
        "gain": _number(trim.get("gain"), 1.0, 4),
        "trim": _number(trim.get("trim"), 1.0, 4),
        "verdict": "refused" if refused else diagnosis.get("verdict", ""),
        "names": refused or "; ".join(names),
        "recordings": str(len(row["recordings"])),
        "error": shown(row["error"]["reason"]) if "error" in row else "",
        "untold": row.get("untold", ""),
    }


def _number(value: float | None, factor: float, digits: int) -> str:
    return "" if value is None else f"{factor * value:.{digits}f}"
