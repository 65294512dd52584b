"""`fsm-calib study`: the paper's section 4 on any number of robots, and fleets on all cores or a cluster."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fsm_calib.commands.options import AddressOption, BackendOption, EffectsOption, JobsOption
from fsm_calib.errors import DataError, InputError

if TYPE_CHECKING:
    from fsm_calib.study.models import Study

DEFAULT_OUT = Path("out") / "study"
"""Studies leave their files below this, each in a folder of its name."""


def register(app: typer.Typer) -> None:
    """Add `study` to the command line."""
    app.command()(study)


def study(
    scenario: Annotated[
        Path,
        typer.Argument(
            metavar="STUDY", help="A study file, or the name of one that is shipped.", show_default=False
        ),
    ],
    robots: Annotated[
        int | None,
        typer.Option(metavar="N", help="Another number of robots than the file's.", show_default=False),
    ] = None,
    jobs: JobsOption = None,
    out: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR",
            help="Where files go (default: out/study/NAME); what is there goes on.",
            show_default=False,
        ),
    ] = None,
    backend: BackendOption = "loky",
    address: AddressOption = None,
    page: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="Also renew this study's section of a Markdown page.", show_default=False
        ),
    ] = None,
    effects: EffectsOption = None,
) -> None:
    """Calibrate many robots by hand and automatically, and compare; a killed command goes on where it was."""
    from fsm_calib.progress.fleet import FleetBar, studied_name
    from fsm_calib.report.study_files import write_page, write_study
    from fsm_calib.shipped import scenario_path
    from fsm_calib.study.backends import crew_of
    from fsm_calib.study.fleet import run_fleet
    from fsm_calib.study.interrupts import interrupted_by_signals
    from fsm_calib.study.load import load_study
    from fsm_calib.study.summary import summarise

    loaded = with_robots(load_study(scenario_path(scenario)), robots)
    crew = crew_of(backend, jobs, address)
    directory = out or DEFAULT_OUT / loaded.name
    try:
        with FleetBar(studied_name) as bar, interrupted_by_signals():
            store = run_fleet(loaded, directory, crew, bar)
    except KeyboardInterrupt as stopped:
        raise DataError(f"stopped by {stopped}", cure="Give the same command to go on.") from stopped
    summary = summarise(loaded, store.rows.values())
    content = write_study(directory, summary)
    if page is not None:
        write_page(page, summary, directory, command_of(scenario, robots))
    typer.echo(content.text())
    typer.echo(f"files: {directory}/")
    if all("error" in row for row in store.rows.values()):
        reason = next(iter(store.rows.values()))["error"]["reason"]
        raise DataError(f"no robot has a result; the first said: {reason}")


def with_robots(study: Study, robots: int | None) -> Study:
    """Return the study with another number of robots.

    Raises
    ------
    InputError
        The number is below one.
    """
    if robots is None:
        return study
    if robots < 1:
        raise InputError(f"--robots is {robots}", where="--robots", cure="Give 1 or more.")
    return study.model_copy(update={"robots": robots})


def command_of(scenario: Path, robots: int | None) -> str:
    """Return the command that repeats a study."""
    more = "" if robots is None else f" --robots {robots}"
    return f"fsm-calib study {scenario}{more}"
