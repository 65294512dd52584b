"""One self-contained HTML page that tells a diagnosis: the answer first, then what it rests on."""

from __future__ import annotations

from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import jinja2
import numpy as np
from markupsafe import Markup

from fsm_calib.diagnosis.diagnose import Diagnosis
from fsm_calib.diagnosis.verdict.verdict import ErrorTriple
from fsm_calib.errors import InputError
from fsm_calib.report import diagnosis_figures
from fsm_calib.report.diagnosis_paths import drives

TEMPLATE = "diagnosis.html.j2"
NINETY_PERCENT = 1.645  # standard deviations either side of a normal value
MOST_DRIVES = 6  # drawn in full; a page of twenty recordings opens slowly and tells no more


@dataclass(frozen=True)
class Row:
    """A parameter in the table: who it belongs to, its name, value, 90 % interval and unit, as text."""

    owner: str
    name: str
    value: str
    interval: str
    unit: str


def write_report(diagnosis: Diagnosis, folder: Path) -> Path:
    """Write `report.html` into a folder and return its path.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    path = folder / "report.html"
    try:
        path.write_text(diagnosis_page(diagnosis), encoding="utf-8")
    except OSError as error:
        raise InputError(f"cannot write the report: {error.strerror}", where=str(path)) from error
    return path


def diagnosis_page(diagnosis: Diagnosis) -> str:
    """Return the report as HTML."""
    environment = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True)
    template = environment.from_string(files("fsm_calib.report").joinpath(TEMPLATE).read_text("utf-8"))
    verdict, decision = diagnosis.verdict, diagnosis.decision
    named = {effect.name for effect in verdict.effects}
    return template.render(
        verdict=verdict,
        robot=decision.engine.simulators[0].prepared.recording.robot.name,
        notes=diagnosis.notes,
        errors=error_rows(diagnosis),
        parameters=parameter_rows(diagnosis),
        rivals=verdict.rivals,
        ranking=Markup(diagnosis_figures.ranking(decision.ranking, named)) if decision.ranking else "",
        drives=drawn(diagnosis),
        seconds=verdict.seconds,
    )


def drawn(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """Return title and figures of each recording, those that were only predicted first."""
    every = sorted(drives(diagnosis), key=lambda drive: not drive.judged)
    return [
        {
            "title": drive.title,
            "judged": drive.judged,
            "time": Markup(diagnosis_figures.error_over_time(drive)),
            "floor": Markup(diagnosis_figures.error_on_floor(drive)) if drive.placed else "",
            "paths": Markup(diagnosis_figures.paths(drive)) if drive.placed else "",
        }
        for drive in every[:MOST_DRIVES]
    ]


def error_rows(diagnosis: Diagnosis) -> list[tuple[str, str, str, str]]:
    """Return rows (recordings, before, after, floor) of median errors over the horizon."""
    verdict = diagnosis.verdict
    named: list[tuple[str, ErrorTriple | None]] = [("not fitted", verdict.holdout), ("fitted", verdict.train)]
    return [
        (name, *(_error(e.xy_m, e.theta_rad) for e in (t.before, t.after, t.floor)))  # type: ignore[misc]
        for name, t in named
        if t is not None
    ]


def _error(position: float, heading: float) -> str:
    said = [f"{1e3 * position:.1f} mm"] if np.isfinite(position) else []
    return ", ".join([*said, f"{np.degrees(heading):.2f} deg"] if np.isfinite(heading) else said) or "-"


def parameter_rows(diagnosis: Diagnosis) -> list[Row]:
    """Return the effects' parameters, then the base robot's, with 90 % intervals."""
    verdict = diagnosis.verdict
    owned = [(effect.name, effect.parameters) for effect in verdict.effects] + [("base robot", verdict.base)]
    return [
        Row(owner, name, f"{e.value:.4g}", _interval(e.value, e.sd), "" if e.unit == "1" else e.unit)
        for owner, numbers in owned
        for name, e in numbers.items()
    ]


def _interval(value: float, sd: float) -> str:
    if not np.isfinite(sd):
        return "the data cannot tell"
    return f"{value - NINETY_PERCENT * sd:.4g} to {value + NINETY_PERCENT * sd:.4g}"
