"""`fsm-calib run`: the main job, from a scenario to calibration files and a report."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fsm_calib.commands.options import (
    EffectsOption,
    MachinesOption,
    OutOption,
    OverwriteOption,
    ResumeOption,
    RobotOption,
    ScenarioArgument,
    SeedOption,
    YesOption,
    machinery_of,
)
from fsm_calib.commands.run_place import run_directory
from fsm_calib.commands.safety import confirm
from fsm_calib.commands.watch import watched
from fsm_calib.errors import InputError

if TYPE_CHECKING:
    from fsm_calib.runner.files import Draw
    from fsm_calib.runner.record import RunRecord
    from fsm_calib.scenario.models import Scenario
    from fsm_calib.statechart.machinery import Machinery


PLAN = "will turn on the spot and drive over the floor markers and into the lane, by itself."
"""What a real robot is about to do."""


def register(app: typer.Typer) -> None:
    """Add `run` to the command line."""
    app.command()(run)


def run(
    scenario: ScenarioArgument,
    out: OutOption = None,
    seed: SeedOption = None,
    resume: ResumeOption = None,
    overwrite: OverwriteOption = False,
    robot: RobotOption = None,
    yes: YesOption = False,
    effects: EffectsOption = None,
    machines: MachinesOption = None,
    watch: Annotated[bool, typer.Option("--watch", help="Serve a page that shows the run.")] = False,
    movie: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write the run as a film: .mp4 or .gif.", show_default=False),
    ] = None,
) -> None:
    """Calibrate a robot as a scenario says: camera, wheels, exit, lane; simulated, or a real one with --robot."""
    from fsm_calib.progress.run import ProgressBar
    from fsm_calib.runner.connecting import address_of, with_robot
    from fsm_calib.runner.run import run_scenario
    from fsm_calib.watch.area import write_area

    machinery, draw = machinery_of(machines), _drawn(movie)
    loaded = with_robot(with_seed(read_scenario(scenario, machinery), seed), robot)
    directory = run_directory(out, resume, overwrite=overwrite)
    if loaded.robot.connect != "simulated":
        confirm(address_of(loaded), yes, PLAN)
    if resume is None:
        write_area(directory, loaded)
    with watched(directory, watch):
        with ProgressBar(loaded.plan or (machinery.root.name,)) as bar:
            finished = run_scenario(
                loaded,
                directory,
                resume=resume is not None,
                observer=bar,
                machinery=machinery,
                draw=draw,
            )
        typer.echo(summary(finished.result, directory))
    if finished.result["outcome"] != "done":
        typer.echo(reason(finished.result, scenario, directory), err=True)
        raise typer.Exit(1)


def _drawn(movie: Path | None) -> Draw:
    """Return what makes the page of a finished run, and its film where one was asked for."""
    from fsm_calib.report.run_report import run_report

    if movie is None:
        return run_report
    from fsm_calib.report.movie import movie_kind, write_movie

    film = movie
    movie_kind(film)

    def draw(record: RunRecord) -> str:
        write_movie(record, film)
        return run_report(record)

    return draw


def read_scenario(path: Path, machinery: Machinery | None = None) -> Scenario:
    """Return the scenario in a file, for the calibration or another machine.

    Raises
    ------
    InputError
        For everything that is wrong in it; a study is sent to its own command.
    """
    from fsm_calib.scenario.load import scenario_from
    from fsm_calib.scenario.yaml_source import read_yaml
    from fsm_calib.shipped import scenario_path
    from fsm_calib.study.load import is_study

    document = read_yaml(scenario_path(path))
    if is_study(document):
        cure = f"Give it to: fsm-calib study {path}."
        raise InputError("this is a study, of many robots", where=str(path), cure=cure)
    return scenario_from(document) if machinery is None else scenario_from(document, machinery)


def with_seed(scenario: Scenario, seed: int | None) -> Scenario:
    """Return the scenario with another seed.

    Raises
    ------
    InputError
        The seed is negative.
    """
    if seed is None:
        return scenario
    if seed < 0:
        raise InputError(f"the seed is {seed}", where="--seed", cure="Give 0 or more.")
    return scenario.model_copy(update={"seed": seed})


def reason(result: dict[str, Any], scenario: Path, directory: Path) -> str:
    """Return why a run did not get done, and the cure."""
    failure = result["failure"]
    if failure is None:
        lost = result.get("lost")
        why = "the run was stopped." if lost is None else f"{lost['name']}: {lost['reason']} {lost['cure']}"
        return f"fsm-calib: {why} Go on with: fsm-calib run {scenario} --resume {directory}"
    return f"fsm-calib: {failure['name']}: {failure['reason']} {failure['cure']}"


def summary(result: dict[str, Any], directory: Path) -> str:
    """Return a run's figures, one a line."""
    from fsm_calib.report.camera_words import scan_verdict

    lines = [f"outcome      {result['outcome']}"]
    camera, wheels, lane, seconds = (result[name] for name in ("camera", "wheels", "in_lane", "seconds"))
    if camera:
        lines.append(f"camera       {_camera_error(camera)}")
        if camera["reached"] is False:
            lines.append(f"             {scan_verdict(camera)}")
    if wheels:
        lines.append(
            f"wheels       k = {wheels['wheel_ratio']:.4f} ({_ratio_error(wheels)}) "
            f"after {wheels['iterations']} iterations{_after_2m(wheels)}"
        )
    if lane:
        lines.append(f"in the lane  {_lane_change(lane)}")
        lines += [f"             {lane['doubt']['sentence']}"] if "doubt" in lane else []
    lines.append(f"time         {seconds['simulated']:.1f} s simulated in {seconds['wall']:.1f} s")
    total = sum(seconds["by_part"].values()) or 1.0
    parts = ", ".join(f"{name} {100 * part / total:.0f} %" for name, part in seconds["by_part"].items())
    lines += [f"robot        {sentence}" for sentence in result.get("stored", ())]
    return "\n".join([*lines, f"by part      {parts}", f"files        {directory}/"])


def _camera_error(camera: dict[str, Any]) -> str:
    """Return the camera's error as text: true, where there is a truth, and predicted."""
    figures = f"rms {camera['rms_px']:.3f} px, {camera['views_used']} views"
    predicted = f"{camera['predicted_px']:.2f} px"
    if "true_px" not in camera:
        return f"within {predicted}, as predicted ({figures})"
    return f"{camera['true_px']:.2f} px from the truth (predicted {predicted}, {figures})"


def _lane_change(lane: dict[str, Any]) -> str:
    """Return what the lane changed as text; the deviations where they were scored."""
    ratios = f"k = {lane['wheel_ratio_before']:.4f} -> {lane['wheel_ratio_after']:.4f}"
    if "true_wheel_ratio" not in lane:
        return ratios
    before, after = _centimetres(lane["deviation_before_m"]), _centimetres(lane["deviation_after_m"])
    return f"{ratios}; {before} -> {after} after 2 m"


def _ratio_error(wheels: dict[str, Any]) -> str:
    """Return the true k as text, or the error of the one found."""
    if "true_wheel_ratio" in wheels:
        return f"true {wheels['true_wheel_ratio']:.4f}"
    error = wheels.get("wheel_ratio_error")
    return "error unknown" if error is None else f"+- {error:.4f}"


def _after_2m(wheels: dict[str, Any]) -> str:
    """Return the deviation of a test drive as text; empty where it was not scored."""
    deviation = wheels["deviation_2m_m"]
    if deviation is None and "true_wheel_ratio" not in wheels:
        return ""
    return f"; {_centimetres(deviation)} after 2 m"


def _centimetres(metres: float | None) -> str:
    """Return a deviation as text."""
    return "no drive" if metres is None else f"{100.0 * metres:+.1f} cm"
