"""The catalogue as a table: what the command `effects`, the documentation and the scenario schema print."""

from __future__ import annotations

from typing import Any

from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter


def parameter_row(parameter: Parameter) -> dict[str, Any]:
    """Return one parameter as plain JSON values."""
    return {
        "name": parameter.name,
        "symbol": parameter.symbol,
        "unit": parameter.unit,
        "null": parameter.null,
        "bounds": [parameter.low, parameter.high],
        "typical": parameter.typical,
        "strength": parameter.strength,
        "per_recording": parameter.per_recording,
        "fitted": parameter.fitted,
        "source": parameter.source,
    }


def closure_row(effect: Effect, closure: Closure) -> dict[str, Any]:
    """Return one closure as plain JSON values; what it does not say itself is the effect's."""
    return {
        "name": closure.name,
        "summary": closure.summary,
        "parameters": list(closure.frees),
        "fixes": dict(closure.fixes),
        "sentence": closure.sentence or effect.sentence,
        "source": closure.source or effect.source,
    }


def effect_row(effect: Effect) -> dict[str, Any]:
    """Return one effect as plain JSON values."""
    return {
        "name": effect.name,
        "family": effect.family,
        "summary": effect.summary,
        "equation": effect.equation,
        "parameters": [parameter_row(p) for p in effect.parameters],
        "channels": list(effect.channels),
        "regimes": list(effect.regimes),
        "separates": effect.separates,
        "rivals": list(effect.rivals),
        "manoeuvre": effect.manoeuvre,
        "sentence": effect.sentence,
        "source": effect.source,
        "phenomenon": effect.phenomenon,
        "where": effect.where,
        "when": effect.when,
        "closures": [closure_row(effect, closure) for closure in effect.closures],
    }


def table() -> list[dict[str, Any]]:
    """Return the whole catalogue, one row an effect, in alphabetical order."""
    return [effect_row(effect) for effect in registry().values()]
