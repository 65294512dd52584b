"""`fsm-calib effects`: the catalogue."""

from __future__ import annotations

import json
import textwrap
from typing import Annotated, Any

import typer

from fsm_calib.commands.options import EffectsOption
from fsm_calib.errors import UnknownNameError

WIDTH = 80
"""Characters of a line of text: what every terminal has."""


def register(app: typer.Typer) -> None:
    """Add `effects` to the command line."""
    app.command("effects")(effects_command)


def effects_command(
    names: Annotated[
        list[str] | None, typer.Argument(metavar="NAME", help="These alone.", show_default=False)
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON instead of a table.")] = False,
    effects: EffectsOption = None,
) -> None:
    """Print the catalogue of effects: equation, parameters, where each shows, what separates it from its rivals."""
    from fsm_calib.world2d.effects.catalogue import table

    rows = [row for row in table() if not names or row["name"] in names]
    for name in names or ():
        if all(row["name"] != name for row in rows):
            raise UnknownNameError("effect", name, [row["name"] for row in table()])
    if as_json:
        typer.echo(json.dumps(rows, indent=1, allow_nan=False))
        return
    for row in rows:
        typer.echo("\n".join(effect_lines(row)))


def effect_lines(row: dict[str, Any]) -> list[str]:
    """Return an effect of the catalogue as lines of at most `WIDTH` characters."""
    said = [row["equation"]]
    for p in row["parameters"]:
        low, high = p["bounds"]
        usual = "nothing at" if p["strength"] else "default"
        said.append(f"{p['name']} [{p['unit']}], {usual} {p['null']:g}, {low:g} to {high:g}")
    said.append(f"shows in {', '.join(row['channels'])}; {row['separates']}")
    lines = textwrap.wrap(f"{row['name']} ({row['family']}): {row['summary']}", WIDTH, subsequent_indent="  ")
    for text in said:
        lines += textwrap.wrap(text, WIDTH, initial_indent="    ", subsequent_indent="      ")
    return lines
