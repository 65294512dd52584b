"""One self-contained HTML page that tells a run: opens offline, from the summary down to every setting."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from markupsafe import Markup

from fsm_calib.report import run_camera, run_plan, run_timeline, run_wheels
from fsm_calib.report.camera_words import scan_verdict
from fsm_calib.report.pages import page
from fsm_calib.report.run_replay import replay
from fsm_calib.runner.record import RunRecord

TEMPLATE = "run.html.j2"
FIGURES = ("plan", "timeline", "coverage", "reprojection", "predicted", "ratio", "drives")


@dataclass(frozen=True)
class Card:
    """A figure at the top of the page: name, value, a remark, and whether it is good (None: neither)."""

    name: str
    value: str
    remark: str = ""
    good: bool | None = None


def run_report(record: RunRecord) -> str:
    """Return the report of a run as HTML."""
    return page(
        TEMPLATE,
        record=record,
        result=record.result,
        cards=cards(record.result),
        figures=_figures(record),
        replay=replay(record),
        camera_verdict=scan_verdict(record.result["camera"] or {}),
        pictures=[(picture, Markup(record.data_url(picture))) for picture in record.pictures],
        settings={name: rows(values) for name, values in record.settings.items()},
    )


def _figures(record: RunRecord) -> dict[str, Markup]:
    """Return the figures by name; empty where this run has nothing to show."""
    drawn = dict.fromkeys(FIGURES, "")
    if len(record.track):
        drawn["plan"] = run_plan.floor_plan(record)
    if record.spans:
        drawn["timeline"] = run_timeline.time_line(record)
    if record.notebook.views:
        drawn["coverage"] = run_camera.coverage(record)
    if record.calibration is not None:
        drawn["reprojection"] = run_camera.reprojection(record.calibration)
        drawn["predicted"] = run_camera.predicted_error(record.calibration)
    if len(record.notebook.ratio_history) > 1:
        drawn["ratio"] = run_wheels.ratio_history(record)
    if record.paths:
        drawn["drives"] = run_wheels.test_drives(record)
    return {name: Markup(text) for name, text in drawn.items()}


def cards(result: Mapping[str, Any]) -> list[Card]:
    """Return the figures at the top of the page."""
    found = [Card("outcome", str(result["outcome"]).replace("_", " "), good=result["outcome"] == "done")]
    camera, wheels, lane = (result.get(name) or {} for name in ("camera", "wheels", "in_lane"))
    if camera.get("true_px") is not None:
        remark = f"rms {camera['rms_px']:.3f} px, {camera['views_used']} views"
        found.append(Card("camera error", f"{camera['true_px']:.2f} px", remark, camera["true_px"] <= 0.6))
    elif camera.get("predicted_px") is not None:
        remark = f"predicted; rms {camera['rms_px']:.3f} px, {camera['views_used']} views"
        found.append(Card("camera error", f"{camera['predicted_px']:.2f} px", remark, camera["reached"]))
    if wheels.get("wheel_ratio") is not None:
        remark = f"{_ratio_remark(wheels)}{wheels['iterations']} iterations"
        found.append(Card("wheel ratio k", f"{wheels['wheel_ratio']:.4f}", remark))
    if wheels.get("deviation_2m_m") is not None:
        deviation = wheels["deviation_2m_m"]
        found.append(Card("after 2 m", f"{100 * deviation:+.1f} cm", "limit 10 cm", abs(deviation) <= 0.10))
    if lane.get("deviation_after_m") is not None:
        remark = f"before the lane {100 * lane['deviation_before_m']:+.1f} cm"
        found.append(Card("after 2 m, refined", f"{100 * lane['deviation_after_m']:+.1f} cm", remark))
    if "doubt" in lane:
        found.append(Card("k in the lane", "differs", lane["doubt"]["sentence"], good=False))
    seconds = result["seconds"]
    remark = f"computed in {seconds['wall']:.1f} s"
    return [*found, Card("robot time", f"{seconds['simulated']:.0f} s", remark)]


def _ratio_remark(wheels: Mapping[str, Any]) -> str:
    """Return the true k, or the error of the one found, with a comma behind it; empty where neither is known."""
    if "true_wheel_ratio" in wheels:
        return f"true {wheels['true_wheel_ratio']:.4f}, "
    error = wheels.get("wheel_ratio_error")
    return "" if error is None else f"+- {error:.4f}, "


def rows(values: Any, prefix: str = "") -> list[tuple[str, str]]:
    """Return nested settings as (dotted name, text) rows."""
    if dataclasses.is_dataclass(values) and not isinstance(values, type):
        values = {field.name: getattr(values, field.name) for field in dataclasses.fields(values)}
    if isinstance(values, Mapping):
        nested = [rows(value, f"{prefix}.{name}" if prefix else str(name)) for name, value in values.items()]
        return [row for group in nested for row in group]
    if isinstance(values, list | tuple) and values and not isinstance(values[0], str | int | float):
        nested = [rows(value, f"{prefix}[{number}]") for number, value in enumerate(values)]
        return [row for group in nested for row in group]
    return [(prefix, f"{values:.6g}" if isinstance(values, float) else str(values))]
