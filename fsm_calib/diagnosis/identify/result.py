"""What `identify` hands back: estimates with standard deviations, and reasons where the data cannot tell."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fsm_calib.recording.recording import Finding, Recording
from fsm_calib.types import wrap_angle

DISAGREE = 2.0  # a stretch of the standard deviation above which recordings are said to disagree
SENSOR = ("sensor.x", "sensor.y", "sensor.theta")


@dataclass(frozen=True, slots=True)
class Estimate:
    """One number: `value` and its standard deviation `sd` in `unit`.

    `value` None means that the data cannot tell; `reason` then says why. `sd_robust` is the
    smaller deviation that rows without the outliers give, where `sd` counts outliers as noise since they have
    a common cause; None where the two are the same.
    """

    value: float | None
    sd: float | None = None
    unit: str = ""
    reason: str = ""
    sd_robust: float | None = None

    def to_json(self) -> dict[str, Any]:
        """Return plain JSON values; NaN never occurs."""
        if self.value is None:
            return {"value": None, "sd": None, "unit": self.unit, "reason": self.reason}
        sd = self.sd if self.sd is not None and math.isfinite(self.sd) else None
        plain: dict[str, Any] = {"value": self.value, "sd": sd, "unit": self.unit}
        if self.sd_robust is not None:
            plain["sd_robust"] = self.sd_robust
        return plain


def unknown(unit: str, reason: str) -> Estimate:
    """Return an estimate that the data cannot give."""
    return Estimate(None, None, unit, reason)


@dataclass(frozen=True)
class Identification:
    """The base robot as the data tells it.

    estimates : by name; ``sensor.x``, ``sensor.y``, ``sensor.theta`` for the sensor's pose on the robot;
    residual : measured minus predicted after the fit, by name with the unit in the name (``xy_m``,
    ``theta_rad``); notes : sentences about wrong facts, reversed signs, outliers; findings : what the
    recordings' checks found.
    """

    robot: str
    method: str
    estimates: dict[str, Estimate]
    residual: dict[str, float]
    notes: tuple[str, ...] = ()
    findings: tuple[Finding, ...] = field(default=())

    def value(self, name: str) -> float | None:
        """Return the value of an estimate; None where it is not known."""
        estimate = self.estimates.get(name)
        return None if estimate is None else estimate.value

    def to_json(self) -> dict[str, Any]:
        """Return the object that `identify --json` writes."""
        plain: dict[str, Any] = {"robot": self.robot, "method": self.method}
        for name, estimate in self.estimates.items():
            if name not in SENSOR:
                plain[name] = estimate.to_json()
        plain["sensor"] = {
            name.split(".")[1]: self.estimates[name].to_json() for name in SENSOR if name in self.estimates
        }
        plain["residual"] = {name: value for name, value in self.residual.items() if math.isfinite(value)}
        plain["notes"] = list(self.notes)
        plain["checks"] = [str(finding) for finding in self.findings]
        return plain


def told_once(found: Identification, recordings: Sequence[Recording]) -> dict[str, dict[str, Any]]:
    """Return the estimates by full name as `to_json` has them, the sensor last, each number under one name.

    ``wheel_gain`` is the share that a wheel makes of the speed which `recordings` state for command 1. Where they state
    none it is ``speed_at_full`` again [m/s], and told here as unknown, with what stating the speed needs.
    """
    twice = [
        name for name, one in found.estimates.items() if name.startswith("wheel_gain_") and one.unit == "m/s"
    ]
    plain: dict[str, dict[str, Any]] = {}
    for name, estimate in sorted(found.estimates.items(), key=lambda item: item[0] in SENSOR):
        if name not in twice:
            plain[name] = estimate.to_json()
        elif name == twice[0]:
            plain["wheel_gain"] = unknown("1", _gain_needs(found, recordings)).to_json()
    return plain


def _gain_needs(found: Identification, recordings: Sequence[Recording]) -> str:
    """Return what the robot's facts lack for the gains of its wheels."""
    robots = [recording.robot for recording in recordings]
    measured = found.value("wheel_radius_left") is not None
    lacking = ["wheel_radius"] if not measured and any(robot.wheel_radius is None for robot in robots) else []
    lacking += ["max_wheel_rate"] if any(robot.max_wheel_rate is None for robot in robots) else []
    said = "it is speed_at_full over wheel_radius times max_wheel_rate"
    return f"{said}; state the robot's {' and '.join(lacking)} to have it"


def combined(parts: Sequence[Identification]) -> Identification:
    """Return the weighted mean of identifications of one robot from several recordings.

    Weights are 1 / sd^2. Where the parts scatter more than their deviations allow (chi-square per degree of
    freedom above 1), the deviation grows by its root (Birge 1932, DOI 10.1103/PhysRev.40.207), and a note
    says so.
    """
    if len(parts) == 1:
        return parts[0]
    names = list(dict.fromkeys(name for part in parts for name in part.estimates))
    notes = list(dict.fromkeys(note for part in parts for note in part.notes))
    estimates = {}
    for name in names:
        found = [part.estimates[name] for part in parts if name in part.estimates]
        estimates[name], stretch = _mean(found)
        if stretch > DISAGREE:
            notes.append(f"the recordings disagree about {name}: they scatter {stretch:.1f} times too much")
    residual = {
        name: max(part.residual[name] for part in parts if name in part.residual)
        for name in dict.fromkeys(key for part in parts for key in part.residual)
    }
    findings = tuple(finding for part in parts for finding in part.findings)
    return Identification(parts[0].robot, parts[0].method, estimates, residual, tuple(notes), findings)


def _mean(found: Sequence[Estimate]) -> tuple[Estimate, float]:
    """Return the weighted mean and by how much its deviation was stretched."""
    known = [estimate for estimate in found if estimate.value is not None and estimate.sd]
    if not known:
        return found[0], 1.0
    values = np.array([estimate.value for estimate in known], dtype=float)
    precision = np.array([1.0 / float(estimate.sd or 1.0) ** 2 for estimate in known])
    unit = known[0].unit
    if unit == "rad":
        values = values[0] + np.array([wrap_angle(float(value - values[0])) for value in values])
    mean = float((values * precision).sum() / precision.sum())
    stretch = 1.0
    if len(known) > 1:
        stretch = max(1.0, float(np.sqrt(((values - mean) ** 2 * precision).sum() / (len(known) - 1))))
    return Estimate(mean, float(precision.sum() ** -0.5) * stretch, unit), stretch
