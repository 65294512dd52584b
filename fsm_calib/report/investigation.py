"""The page of an investigation: what the robot drove, why, and how the probabilities moved."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from markupsafe import Markup

from fsm_calib.actions.investigating import Field
from fsm_calib.diagnosis.design.area import Area
from fsm_calib.report.pages import page
from fsm_calib.report.palette import BOARD_COLOURS, INK
from fsm_calib.report.plot import Axes, Box, figure

TEMPLATE = "investigation.html.j2"


def investigation_page(drives: Sequence[Field], area: Area, result: dict[str, Any]) -> str:
    """Return the page as HTML; `result` as in investigation.json."""
    named = " and ".join(effect["name"].replace("_", " ") for effect in result.get("effects", []))
    told = [
        {
            **row,
            "expected": row["expected"] or 0.0,
            "manoeuvres": [step["name"] for step in drive.plan.get("manoeuvres", ())],
            "figure": Markup(driven(drive, area, number)),
        }
        for number, (row, drive) in enumerate(zip(result["drives"], drives, strict=True), start=1)
    ]
    return page(
        TEMPLATE,
        answer=named or {"match": "nothing is missing"}.get(result.get("verdict", ""), "no answer"),
        ended=result["ended"].replace("_", " ").replace("/", ": "),
        seconds=result["robot"]["seconds"],
        drives=told,
        fits=fits_of(result),
        calibrations=result.get("calibration", {}),
    )


def fits_of(result: dict[str, Any]) -> list[tuple[str, float, float]]:
    """Return rows of name, position [mm] and heading [deg]: the error over 2 s before, after, and what noise leaves."""
    fit = result.get("fit", {})
    rows = fit.get("holdout") or fit.get("train") or {}
    return [
        (name, 1e3 * rows[name]["xy_m"], float(np.degrees(rows[name]["theta_rad"])))
        for name in ("before", "after", "floor")
        if rows.get(name) and rows[name].get("theta_rad") is not None
    ]


def driven(drive: Field, area: Area, number: int) -> str:
    """Return a drive as the tracker saw it from above, to scale, as SVG."""
    xlim, ylim = (area.x_low, area.x_high), (area.y_low, area.y_high)
    box = Box(60.0, 20.0, 420.0, 360.0).shrunk(xlim, ylim)
    axes = Axes(box, xlim, ylim)
    poses = np.array(drive.poses)
    axes.line(poses[:, 1:3], BOARD_COLOURS[0], 1.8)
    picked = poses[::15]
    axes.arrows(picked[:, 1:3], picked[:, 3], 0.06, INK)
    axes.dots(poses[:1, 1:3], INK, 8.0)
    axes.frame("x [m]", "y [m]")
    return figure(540.0, box.top + box.height + 60.0, f"Drive {number} as seen from above", axes)
