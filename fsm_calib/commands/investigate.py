"""`fsm-calib investigate`: the robot finds out by driving what its simulation is missing."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fsm_calib.commands.files import STANDARD_OUTPUT, check_places, write_file
from fsm_calib.commands.given import recordings_given
from fsm_calib.commands.options import (
    EffectsOption,
    JsonOption,
    OutOption,
    OverwriteOption,
    ResumeOption,
    RobotOption,
    ScenarioArgument,
    SeedOption,
    YesOption,
)
from fsm_calib.commands.run import read_scenario, with_seed
from fsm_calib.commands.run_place import run_directory
from fsm_calib.commands.safety import confirm
from fsm_calib.commands.verdict_lines import summary_lines
from fsm_calib.errors import shown_lines

if TYPE_CHECKING:
    from fsm_calib.runner.investigation.session import Investigation
    from fsm_calib.runner.progress import Observer
    from fsm_calib.scenario.models import Scenario

PLAN = """will drive over the area's floor markers by itself, as fast as `investigate.command`.
It stops itself at the area's edge, by what its own camera sees."""
"""What a real robot is about to do."""


def register(app: typer.Typer) -> None:
    """Add `investigate` to the command line."""
    app.command("investigate")(investigate_command)


def investigate_command(
    scenario: ScenarioArgument,
    robot: RobotOption = None,
    given: Annotated[
        list[str] | None,
        typer.Option("--from", metavar="RECORDING", help="Go on from this recording; repeatable."),
    ] = None,
    calibration: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="An earlier run's folder: the calibration of the robot's camera."),
    ] = None,
    budget: Annotated[
        float | None,
        typer.Option(metavar="SECONDS", help="Robot time, in place of the scenario's.", min=10.0, max=7200.0),
    ] = None,
    json_file: JsonOption = None,
    out: OutOption = None,
    resume: ResumeOption = None,
    overwrite: OverwriteOption = False,
    seed: SeedOption = None,
    calibrate: Annotated[
        Path | None,
        typer.Option(metavar="SCENARIO", help="Then drive this calibration in the improved world."),
    ] = None,
    yes: YesOption = False,
    effects: EffectsOption = None,
) -> None:
    """Drive, diagnose, and design the next drive, until it is settled what the simulation is missing."""
    from fsm_calib.progress.run import ProgressBar
    from fsm_calib.runner.connecting import address_of
    from fsm_calib.runner.investigation.run import investigate
    from fsm_calib.runner.investigation.session import Before, refuse_blind

    check_places(json_file)
    loaded = asked_of(scenario, robot, budget, seed)
    recordings, _ = recordings_given(given or (), (), tag_map=None)
    directory = run_directory(out, resume, overwrite=overwrite)
    if loaded.robot.connect != "simulated":
        refuse_blind(loaded, Before(calibration=calibration))
        confirm(address_of(loaded), yes, PLAN)
    with ProgressBar(()) as bar:
        going, result = investigate(
            loaded,
            directory,
            given=recordings,
            calibration=calibration,
            resume=resume is not None,
            observer=bar,
        )
        if calibrate is not None and going.mind.diagnosis is not None:
            drive_afterwards(calibrate, going, result, directory, bar)
    write_files(going, result, directory)
    tell(result, directory, json_file)
    if str(result["ended"]).startswith(("failed", "aborted")):
        typer.echo(f"fsm-calib: {result['reason']} {result['cure']}", err=True)
        raise typer.Exit(1)


def drive_afterwards(
    path: Path, going: Investigation, result: dict[str, Any], directory: Path, observer: Observer
) -> None:
    """Drive a calibration in the improved world; add what came of it to the result and to its file."""
    from fsm_calib.report.diagnosis_world import world_text
    from fsm_calib.runner.investigation.afterwards import calibrated_afterwards
    from fsm_calib.runner.investigation.files import RESULT

    if going.mind.diagnosis is None:
        return
    world = world_text(going.mind.diagnosis)
    result["calibration"] = calibrated_afterwards(read_scenario(path), world, directory, observer)
    write_file(directory / RESULT, json.dumps(result, indent=1) + "\n")


def asked_of(path: Path, robot: str | None, budget: float | None, seed: int | None) -> Scenario:
    """Return the scenario with what the command line says in its place."""
    from fsm_calib.runner.connecting import with_robot

    scenario = with_seed(with_robot(read_scenario(path), robot), seed)
    if budget is None:
        return scenario
    asked = scenario.investigate.model_copy(update={"budget": budget})
    return scenario.model_copy(update={"investigate": asked})


def write_files(going: Investigation, result: dict[str, Any], directory: Path) -> None:
    """Write the improved world and the pages, as far as there is a diagnosis."""
    from fsm_calib.report.diagnosis_report import write_report
    from fsm_calib.report.diagnosis_world import world_text
    from fsm_calib.report.investigation import investigation_page

    diagnosis = going.mind.diagnosis
    if diagnosis is None:
        return
    write_file(directory / "world.yaml", world_text(diagnosis))
    write_report(diagnosis, directory)
    write_file(
        directory / "index.html", investigation_page(going.bench.findings.drives, going.mind.area, result)
    )


def tell(result: dict[str, Any], directory: Path, json_file: Path | None) -> None:
    """Print the result in words, or as JSON where that was asked for."""
    if json_file == STANDARD_OUTPUT:
        typer.echo(json.dumps(result, indent=1, allow_nan=False))
        return
    lines = [f"{result['ended']} after {result['robot']['seconds']:.0f} s of robot time"]
    for number, drive in enumerate(result["drives"], start=1):
        expected, reached = (
            f"{drive[k]:.2f}" if drive[k] is not None else "-" for k in ("expected", "reached")
        )
        lines.append(
            f"  drive {number}: {drive['seconds']:.0f} s, expected {expected}, reached {reached}; {drive['why']}"
        )
    if "verdict" in result:
        lines += summary_lines(
            {**result, "drives": None}
        )  # those of a diagnosis are not those that were driven
    for name, row in result.get("calibration", {}).items():
        lines.append(
            f"  calibration, {name}: {row['outcome']}, k = {row['wheel_ratio']}, after 2 m {row['deviation_2m_m']} m"
        )
    if result["ended"] != "done":
        lines.append(f"  {result['reason']} {result['cure']}")
    typer.echo(shown_lines("\n".join([*lines, f"  {directory}/"])))
    if json_file is not None:
        write_file(json_file, json.dumps(result, indent=1, allow_nan=False) + "\n")
