"""A verdict as lines of text, for the terminal."""

from __future__ import annotations

import textwrap
from typing import Any

CLEAR = 3.0  # standard deviations from which a difference is printed


def summary_lines(plain: dict[str, Any]) -> list[str]:
    """Return the verdict as lines of text."""
    lines = [f"{plain['verdict']}: {plain['reason']}", *_drives(plain.get("drives"))]
    for effect in plain["effects"]:
        names = next((group for group in plain["ambiguous"] if effect["name"] in group), [effect["name"]])
        either = " or ".join(sorted(names, key=lambda name: name != effect["name"]))
        lines.append(f"  {either} (confidence {effect['confidence']:.2f}): {effect['sentence']}")
    for group in plain["ambiguous"]:
        lines.append(f"  cannot be told apart: {', '.join(group)}; the numbers are of the first")
    lines += _unsaid(plain)
    if "against" in plain:
        lines += _beside_simulator(plain["against"])
    located = plain["located"]
    if plain["verdict"] != "match":
        channels, regime = ", ".join(located["channels"]) or "-", located["regime"] or "-"
        lines.append(f"  shows in: {channels}; {regime}{_around(located['where'])}")
    if plain["family"]:
        lines.append(f"  resembles most: {plain['family']}")
    for name in ("holdout", "train"):
        errors = plain["fit"][name]
        if errors:
            said = "; ".join(_error(k, errors) for k in errors)
            lines.append(f"  {plain['fit']['horizon_s']:g} s error on {name}: {said}")
    for rival in plain["rivals"][:3]:
        lines.append(f"  rival {rival['name']}: {rival['evidence_gap']:.0f} behind")
    lines += _would_show(plain["smallest_seen"])
    lines.append(f"  next: {plain['next_manoeuvre']}")
    parts = ", ".join(f"{name} {seconds:.1f}" for name, seconds in plain["seconds_by_part"].items())
    return [*lines, f"  {plain['seconds']:.1f} s ({parts})"]


def _unsaid(plain: dict[str, Any]) -> list[str]:
    """Return what was fitted besides, each too unsure for a name."""
    said = {effect["name"] for effect in plain["effects"]}
    unsaid = [f"{e['name']} ({e['confidence']:.2f})" for e in plain["model"] if e["name"] not in said]
    return _wrapped(f"fitted as well, too unsure for a name: {', '.join(unsaid)}") if unsaid else []


def _drives(told: dict[str, Any] | None) -> list[str]:
    """Return what the drives can tell."""
    if told is None:
        return []
    parts = [f"the drives lack {', '.join(told['lack'])}"] if told["lack"] else []
    parts += (
        [f"alike in them: {'; '.join(' or '.join(names) for names in told['alike'])}"]
        if told["alike"]
        else []
    )
    parts += [f"too faint in them: {', '.join(told['faint'])}"] if told["faint"] else []
    return _wrapped(". ".join(parts))


def _wrapped(text: str) -> list[str]:
    return textwrap.wrap(text, 110, initial_indent="  ", subsequent_indent="    ")


def _beside_simulator(told: dict[str, Any]) -> list[str]:
    """Return what the real robot has that the simulator lacks or has otherwise; numbers from three deviations on."""
    lines = [f"  the simulator's own: {told['verdict']}; {', '.join(told['effects']) or 'no effects'}"]
    lines += [f"  the simulator lacks: {', '.join(told['lacks'])}"] if told["lacks"] else []
    lines += [f"  it has otherwise: {', '.join(told['otherwise'])}"] if told["otherwise"] else []
    lines += [f"  alike in both: {', '.join(told['alike'])}"] if told["alike"] else []
    if errors := told.get("simulator"):
        said = "; ".join(_error(name, errors) for name in ("before", "after", "floor"))
        lines.append(f"  your simulator on {errors['on']}, what it lacks around it after: {said}")
    for d in told["differences"]:
        if d["z"] is not None and abs(d["z"]) >= CLEAR:
            unit = "" if d["unit"] == "1" else f" {d['unit']}"
            size = f"{d['difference']:+.3g} ± {d['sd']:.1g}{unit}"
            lines.append(f"  {d['name']}: real {d['real']:.4g}, simulated {d['simulated']:.4g}, {size}")
    return lines


def _around(where: dict[str, float] | None) -> str:
    if not where:
        return ""
    return f"; within {where['radius']:.2f} m of ({where['x']:.2f} m, {where['y']:.2f} m)"


def _would_show(sizes: dict[str, Any]) -> list[str]:
    said = [
        f"{name} {e['value']:.2g}{'' if e['unit'] == '1' else ' ' + e['unit']}" for name, e in sizes.items()
    ]
    return _wrapped(f"would have been seen from: {', '.join(said)}") if said else []


def _error(name: str, errors: dict[str, Any]) -> str:
    return f"{name} {_millimetres(errors[name]['xy_m'])}, {_degrees(errors[name]['theta_rad'])}"


def _millimetres(value: float | None) -> str:
    return "-" if value is None else f"{1e3 * value:.1f} mm"


def _degrees(value: float | None) -> str:
    return "-" if value is None else f"{57.29578 * value:.2f} deg"
