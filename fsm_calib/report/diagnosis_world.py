"""The improved world: a scenario file whose robot has the physics that the recordings showed."""

from __future__ import annotations

import re

import yaml

from fsm_calib.diagnosis.diagnose import Diagnosis
from fsm_calib.diagnosis.fitting.fit import Fit
from fsm_calib.diagnosis.fitting.slot import ALL_RUNS
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

GAINS = ("gain_left", "gain_right")
"""They become wheel ratio and speed."""


def world_text(diagnosis: Diagnosis) -> str:
    """Return a scenario that `fsm-calib run` accepts, the fitted base robot in its comments.

    Events of one recording (a push, a fault) are not part of the robot and are left out.
    """
    decision = diagnosis.decision
    fit = decision.model.fit
    table = parameter_table()
    name = decision.engine.simulators[0].prepared.recording.robot.name
    measured = decision.engine.simulators[0].measured_input
    left, right = (fit.values[0, table.place(f"gain_{side}")] for side in ("left", "right"))
    body = {
        "name": f"improved-{_safe(name)}",
        "robot": {
            "name": _safe(name),
            "source": "nominal",
            "wheel_ratio": _rounded(left / right),
            "speed": 1.0
            if measured
            else _rounded(0.5 * (left + right) / table.null[table.place("gain_left")]),
            "base": _base_of(fit),
            "effects": _effects_of(fit),
        },
    }
    lines = [f"# {diagnosis.verdict.verdict}: {diagnosis.verdict.reason}"]
    if measured:
        lines.append(
            "# wheel speeds were measured: the motors' strength is not known, the nominal one is taken"
        )
    lines.append("# the base robot as fitted:")
    lines += [f"#   {key}: {e.value:.6g} ± {e.sd:.2g} {e.unit}" for key, e in diagnosis.verdict.base.items()]
    return "\n".join(lines) + "\n" + yaml.safe_dump(body, sort_keys=False)


def _base_of(fit: Fit) -> dict[str, float]:
    """Return what the fit found of the base robot beside its gains."""
    table = parameter_table()
    places = [slot.place for slot in fit.slots if not table.owner[slot.place] and slot.run == ALL_RUNS]
    return {table.names[i]: _rounded(fit.values[0, i]) for i in places if table.names[i] not in GAINS}


def _effects_of(fit: Fit) -> dict[str, dict[str, float]]:
    """Return the effects that the fit has, with the values that differ from nothing; events are no part of a robot."""
    table = parameter_table()
    found: dict[str, dict[str, float]] = {}
    for name in table.active_effects(fit.values[0]):
        effect = registry()[name]
        if effect.scan == "time":
            continue
        values = {p.name: float(fit.values[0, table.place(f"{name}.{p.name}")]) for p in effect.parameters}
        kept = {p.name for p in effect.parameters if values[p.name] != p.null}
        found[name] = {key: _rounded(value) for key, value in values.items() if key in kept}
    return found


def _rounded(value: float) -> float:
    return float(f"{float(value):.6g}")


def _safe(name: str) -> str:
    """Return the robot's name as a file name may be."""
    safe = re.sub(r"[^A-Za-z0-9_-]", "-", name)[:48]
    return safe if safe[:1].isalpha() else f"robot-{safe}"
