"""`fsm-calib fleet`: identify and diagnose many robots in one call."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fsm_calib.commands.options import AddressOption, BackendOption, EffectsOption, JobsOption
from fsm_calib.errors import DataError, InputError, shown_lines

DEFAULT_OUT = Path("out") / "fleet"
"""Where files go that no option sends elsewhere."""


def register(app: typer.Typer) -> None:
    """Add `fleet` to the command line."""
    app.command("fleet")(fleet_command)


def fleet_command(
    places: Annotated[
        list[str],
        typer.Argument(metavar="BAG_OR_DIR", help="A robot each, or a folder of robots' folders."),
    ],
    jobs: JobsOption = None,
    out: Annotated[
        Path, typer.Option(metavar="DIR", help="Where files go; what is there goes on.")
    ] = DEFAULT_OUT,
    diagnose: Annotated[
        bool, typer.Option("--diagnose", help="Also say what each robot has that the base lacks.")
    ] = False,
    backend: BackendOption = "loky",
    address: AddressOption = None,
    effects: EffectsOption = None,
) -> None:
    """Identify many robots: who pulls where, worst first, as a page and a table; a killed command goes on."""
    from fsm_calib.fleet.folders import robots_in
    from fsm_calib.fleet.run import run_robots
    from fsm_calib.progress.fleet import FleetBar, real_name
    from fsm_calib.report.fleet import write_fleet
    from fsm_calib.study.backends import crew_of
    from fsm_calib.study.interrupts import interrupted_by_signals

    robots, crew = robots_in(places), crew_of(backend, jobs, address)
    if out.exists() and not out.is_dir():
        raise InputError("the fleet needs a folder, this is a file", where=str(out))
    try:
        with FleetBar(real_name) as bar, interrupted_by_signals():
            rows = run_robots(robots, out, bar, diagnosed=diagnose, crew=crew)
    except KeyboardInterrupt as stopped:
        raise DataError(f"stopped by {stopped}", cure="Give the same command to go on.") from stopped
    written = write_fleet(rows, out)
    typer.echo(shown_lines("\n".join(line for row in rows for line in _lines(row))))
    typer.echo(f"files: {', '.join(str(path) for path in written)}")
    if all("error" in row for row in rows):
        raise DataError(f"no robot has an answer; the first said: {rows[0]['error']['reason']}")


def _lines(row: dict) -> list[str]:  # type: ignore[type-arg]
    """Return what is said of a robot."""
    if "error" in row:
        return [f"{row['robot']}: no answer: {row['error']['reason']}"]
    untold = f"where it pulls is not told: {row.get('untold', '')}"
    lines = [f"{row['robot']}: {row['sentence'] or untold}"]
    if verdict := row.get("diagnosis"):
        names = ", ".join(effect["name"] for effect in verdict["effects"])
        lines.append(f"  {verdict['verdict'] or 'not diagnosed'}: {names or verdict['reason']}")
    return lines
