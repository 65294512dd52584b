"""The improved world: a scenario file whose robot has the physics that the recordings showed."""

from __future__ import annotations

import re

import yaml

from fsm_calib.diagnosis.diagnose import Diagnosis
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

FITTED_BASE = ("axle_length", "tau_forward", "tau_turn")
"""What a fit finds of the base robot beside the wheels' gains, which become wheel ratio and speed."""


def world_text(diagnosis: Diagnosis) -> str:
    """Return a scenario that `fsm-calib run` accepts, the fitted base robot in its comments.

    Events of one recording (a push, a fault) are not part of the robot and are left out.
    """
    decision = diagnosis.decision
    fit, table = decision.model.fit, parameter_table()
    name = decision.engine.simulators[0].prepared.recording.robot.name
    effects: dict[str, dict[str, float]] = {}
    for ranked in decision.model.effects if decision.outcome == "explained" else ():
        effect = registry()[ranked.name]
        if effect.scan == "time":
            continue
        effects[ranked.name] = {
            p.name: _rounded(fit.values[0, table.place(f"{ranked.name}.{p.name}")])
            for p in effect.parameters
            if fit.values[0, table.place(f"{ranked.name}.{p.name}")] != p.null
        }
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
            "base": {name: _rounded(fit.values[0, table.place(name)]) for name in FITTED_BASE},
            "effects": effects,
        },
    }
    lines = [f"# {diagnosis.verdict.verdict}: {diagnosis.verdict.reason}"]
    if measured:
        lines.append(
            "# wheel speeds were measured: the motors' strength is not known, the nominal one is taken"
        )
    lines.append("# the base robot as fitted:")
    lines += [f"#   {key}: {e.value:.5g} ± {e.sd:.2g} {e.unit}" for key, e in diagnosis.verdict.base.items()]
    return "\n".join(lines) + "\n" + yaml.safe_dump(body, sort_keys=False)


def _rounded(value: float) -> float:
    return float(f"{float(value):.6g}")


def _safe(name: str) -> str:
    """Return the robot's name as a file name may be."""
    safe = re.sub(r"[^A-Za-z0-9_-]", "-", name)[:48]
    return safe if safe[:1].isalpha() else f"robot-{safe}"
