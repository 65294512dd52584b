"""What the functions of `fsm_calib.api` return: plain values that show themselves in a notebook."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fsm_calib.diagnosis.diagnose import Diagnosis
    from fsm_calib.perception.calibration import CameraCalibration


@dataclass(frozen=True, eq=False)
class Answer:
    """What a function of this module found; printed as lines, shown as a table in a notebook.

    Attributes
    ----------
    title : str
        What it is, in a sentence.
    json : dict
        Plain values, as the command's `--json` writes them, in SI units.
    rows : tuple
        The figures that matter, as (name, text).
    """

    title: str
    json: dict[str, Any]
    rows: tuple[tuple[str, str], ...] = field(default=())

    def __str__(self) -> str:
        """Return title and figures as lines of text."""
        return "\n".join([self.title, *(f"  {name}: {text}" for name, text in self.rows)])

    def _repr_html_(self) -> str:
        """Return title and figures as a table, and everything folded below it."""
        cells = "".join(
            f"<tr><th>{escape(name)}</th><td>{escape(text)}</td></tr>" for name, text in self.rows
        )
        everything = escape(json.dumps(self.json, indent=1))
        folded = f"<details><summary>everything</summary><pre>{everything}</pre></details>"
        return f"<b>{escape(self.title)}</b><table>{cells}</table>{folded}"


@dataclass(frozen=True, eq=False)
class RunAnswer(Answer):
    """A finished run or investigation.

    Attributes
    ----------
    directory : Path
        Its files, among them report.html; those of a run also calibrations/.
    """

    directory: Path = Path()


@dataclass(frozen=True, eq=False)
class DiagnosisAnswer(Answer):
    """A diagnosis.

    Attributes
    ----------
    diagnosis : Diagnosis
        Everything that it was drawn from (`fsm_calib.diagnosis.diagnose.Diagnosis`).
    """

    diagnosis: Diagnosis | None = None

    def write_report(self, folder: str | Path) -> Path:
        """Write report.html and world.yaml into a folder, which is made; return the page's path.

        Parameters
        ----------
        folder : str or Path
            Where they go; what is there under these names is replaced.
        """
        from fsm_calib.report.diagnosis_report import write_report
        from fsm_calib.report.diagnosis_world import world_text

        if self.diagnosis is None:
            raise ValueError("this answer holds no diagnosis")
        place = Path(folder)
        place.mkdir(parents=True, exist_ok=True)
        (place / "world.yaml").write_text(world_text(self.diagnosis), encoding="utf-8")
        return write_report(self.diagnosis, place)


@dataclass(frozen=True, eq=False)
class CameraAnswer(Answer):
    """A camera.

    Attributes
    ----------
    calibration : CameraCalibration
        With covariance, residuals and poses (`fsm_calib.perception.calibration.CameraCalibration`).
    """

    calibration: CameraCalibration | None = None
