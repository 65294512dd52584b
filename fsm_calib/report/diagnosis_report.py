"""One self-contained HTML page that tells a diagnosis: the answer first, then what it rests on."""

from __future__ import annotations

import json
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

from fsm_calib.diagnosis.diagnose import Diagnosis
from fsm_calib.diagnosis.proof.heldout import Comparison
from fsm_calib.diagnosis.proof.windows import Windows
from fsm_calib.diagnosis.verdict.argument import Argument
from fsm_calib.diagnosis.verdict.verdict import ErrorTriple
from fsm_calib.errors import InputError
from fsm_calib.report import diagnosis_figures, digits
from fsm_calib.report.diagnosis_paths import drives
from fsm_calib.report.diagnosis_signature import signature
from fsm_calib.report.pages import page
from fsm_calib.world2d.effects import registry

TEMPLATE = "diagnosis.html.j2"
NINETY_PERCENT = 1.645  # standard deviations either side of a normal value
RANKED = 12  # hypotheses that the page shows
TAIL = 0.95
MOST_MOMENTS = 1500  # at which the cursor may stand
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
    verdict, decision = diagnosis.verdict, diagnosis.decision
    return page(
        TEMPLATE,
        verdict=verdict,
        robot=decision.engine.simulators[0].prepared.recording.robot.name,
        notes=diagnosis.notes,
        unsaid=[_unsure(argument) for argument in verdict.unsaid],
        physics=physics(diagnosis),
        signature=Markup(signature(diagnosis)),
        errors=error_rows(diagnosis),
        parameters=parameter_rows(diagnosis),
        ranking=ranking_rows(diagnosis),
        ranked_out=ranked_out(diagnosis),
        drives=drawn(diagnosis),
        improved=bool(decision.model.effects),
        command=command(diagnosis),
        seconds=verdict.seconds,
    )


def _unsure(argument: Argument) -> str:
    return f"{argument.name.replace('_', ' ')} ({100.0 * argument.confidence:.0f} %)"


def physics(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """Return what the catalogue says of each named effect, with the fitted numbers."""
    found = []
    for named in diagnosis.verdict.effects:
        effect = registry().get(named.name)
        if effect is None:
            continue
        numbers = [f"{key} = {digits.estimate(e.value, e.sd, e.unit)}" for key, e in named.parameters.items()]
        closure = effect.closure(named.closure) if named.closure and len(effect.closures) > 1 else None
        found.append(
            {
                "key": effect.name,
                "name": effect.name.replace("_", " "),
                "summary": effect.summary,
                "separates": effect.separates,
                "equation": effect.equation,
                "closure": f"{closure.name}: {closure.summary}" if closure else "",
                "numbers": numbers,
                "source": (closure.source if closure else "") or effect.source,
            }
        )
    return found


def ranking_rows(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """Return the hypotheses that explain something: name, evidence, length of its bar [%], what speaks against it."""
    ranked = [r for r in diagnosis.decision.ranking if r.evidence > 0.0][:RANKED]
    if not ranked:
        return []
    named = {effect.name for effect in diagnosis.verdict.effects}
    top = max(max(r.evidence for r in ranked), 1e-9)
    return [
        {
            "name": r.name.replace("_", " "),
            "named": r.name in named,
            "evidence": f"{r.evidence:.0f}",
            "width": f"{100.0 * r.evidence / top:.1f}",
            "why": _why(r.name, r.evidence, named, top),
        }
        for r in ranked
    ]


def ranked_out(diagnosis: Diagnosis) -> list[str]:
    """Return the names of the hypotheses that explain less than their numbers cost."""
    return [r.name.replace("_", " ") for r in diagnosis.decision.ranking if r.evidence <= 0.0]


def _why(name: str, evidence: float, named: set[str], top: float) -> str:
    """Return in a sentence why a hypothesis was named or was not."""
    effect = registry().get(name)
    known = f"; its mark would be: {effect.separates}" if effect is not None else ""
    if name in named:
        return f"named{known}".replace("would be", "is")
    return f"{top - evidence:.0f} behind the first{known}"


def command(diagnosis: Diagnosis) -> str:
    """Return the command that was run, as far as the recordings tell it."""
    fitted = [simulator.prepared.name for simulator in diagnosis.decision.engine.simulators]
    judged = [simulator.prepared.name for simulator in diagnosis.holdout_simulators]
    parts = ["fsm-calib diagnose", *map(shlex.quote, fitted)]
    return " ".join([*parts, *(f"--holdout {shlex.quote(name)}" for name in judged)])


def drawn(diagnosis: Diagnosis) -> list[dict[str, Any]]:
    """Return title and figures of each recording, those that were only predicted first."""
    located = diagnosis.verdict.located
    every = sorted(drives(diagnosis), key=lambda drive: not drive.judged)
    when = (
        located.when if len(diagnosis.decision.engine.simulators) == 1 else ()
    )  # else perhaps another drive's
    return [
        {
            "title": drive.title,
            "judged": drive.judged,
            "track": json.dumps(drive.track(MOST_MOMENTS), separators=(",", ":")),
            "time": Markup(diagnosis_figures.error_over_time(drive, () if drive.judged else when)),
            "floor": Markup(diagnosis_figures.error_on_floor(drive, located.where)) if drive.placed else "",
            "paths": Markup(diagnosis_figures.paths(drive)) if drive.placed else "",
        }
        for drive in every[:MOST_DRIVES]
    ]


def error_rows(diagnosis: Diagnosis) -> list[tuple[str, str, str, str, str]]:
    """Return rows (recordings, which, before, after, floor) of errors over the horizon: medians, and the tail."""
    verdict = diagnosis.verdict
    rows: list[tuple[str, str, str, str, str]] = []
    parts: list[tuple[str, ErrorTriple | None, Comparison | None]] = [
        ("not fitted", verdict.holdout, diagnosis.holdout),
        ("fitted", verdict.train, diagnosis.train),
    ]
    for name, triple, comparison in parts:
        if triple is None or comparison is None:
            continue
        before, after, floor = (
            _error(e.xy_m, e.theta_rad) for e in (triple.before, triple.after, triple.floor)
        )
        rows.append((name, "median", before, after, floor))
        tails = [tail_error(part) for part in (comparison.windows_before, comparison.windows_after)]
        rows.append((name, f"{100 * TAIL:.0f} %", _error(*tails[0]), _error(*tails[1]), ""))
    return rows


def tail_error(windows: Sequence[Windows]) -> tuple[float, float]:
    """Return the errors that one prediction in twenty exceeds: position [m], heading [rad]."""
    error = np.vstack([part.error for part in windows])
    if not len(error):
        return float("nan"), float("nan")
    distance = np.hypot(error[:, 0], error[:, 1])
    return float(np.quantile(distance, TAIL)), float(np.quantile(np.abs(error[:, 2]), TAIL))


def _error(position: float, heading: float) -> str:
    parts = ((1e3 * position, ".1f", "mm"), (np.degrees(heading), ".2f", "deg"))
    said = [f"{value:{form}}\N{NO-BREAK SPACE}{unit}" for value, form, unit in parts if np.isfinite(value)]
    return ", ".join(said) or "-"


def parameter_rows(diagnosis: Diagnosis) -> list[Row]:
    """Return the effects' parameters, then the base robot's, with 90 % intervals."""
    verdict = diagnosis.verdict
    owned = [(effect.name, effect.parameters) for effect in verdict.effects] + [("base robot", verdict.base)]
    return [
        Row(
            owner,
            name,
            digits.rounded(e.value, e.sd),
            _interval(e.value, e.sd),
            "" if e.unit == "1" else e.unit,
        )
        for owner, numbers in owned
        for name, e in numbers.items()
    ]


def _interval(value: float, sd: float) -> str:
    if not np.isfinite(sd):
        return "the data cannot tell"
    low, high = (digits.rounded(value + side * NINETY_PERCENT * sd, sd) for side in (-1.0, 1.0))
    return f"{low} to {high}"
