"""`fsm-calib demo` and `fsm-calib init`: a first look without data, and a scenario to edit."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fsm_calib.commands.files import write_file
from fsm_calib.errors import InputError, UnknownNameError

if TYPE_CHECKING:
    from fsm_calib.diagnosis.diagnose import Diagnosis

DEFAULT_OUT = Path("out") / "demo"
"""Where the demo leaves its files when nothing else is said."""


def register(app: typer.Typer) -> None:
    """Add `demo` and `init` to the command line."""
    app.command("demo")(demo)
    app.command("init")(init)


def demo(
    out: Annotated[Path, typer.Option(metavar="DIR", help="Where the page and the drives go.")] = DEFAULT_OUT,
    seed: Annotated[int, typer.Option(min=0, metavar="N", help="Another seed hides another wheel.")] = 0,
    is_opened: Annotated[
        bool, typer.Option("--open/--no-open", help="Open the page in a browser (on a terminal only).")
    ] = True,
    is_only_driven: Annotated[
        bool,
        typer.Option("--drives-only", help="Only write the drives, as plain CSV tables to try things on."),
    ] = False,
) -> None:
    """Drive a robot with a hidden fault, find the fault, and open the page that tells it."""
    if is_only_driven:
        _write_drives(out, seed)
        return
    from fsm_calib.demo import HIDDEN, drive_demo
    from fsm_calib.diagnosis.diagnose import diagnose
    from fsm_calib.diagnosis.replay.settings import Settings
    from fsm_calib.progress.diagnosis import DiagnosisProgress
    from fsm_calib.recording.writers import write_recording
    from fsm_calib.workers import usable_cores
    from fsm_calib.world2d.effects import registry

    make_folder(out)
    typer.echo("A simulated robot is driven three times. One of its wheels sits off its centre;")
    typer.echo("the program is given the commands and the poses of the drives, and nothing else.")
    drives = drive_demo(seed, [str(out / f"drive-{number}") for number in (1, 2, 3)])
    for recording in (*drives.learned, drives.judged):
        write_recording(recording, Path(recording.source))
    with DiagnosisProgress(len(registry())) as bar:
        settings = Settings(processes=usable_cores())
        found = diagnose(drives.learned, (drives.judged,), settings=settings, progress=bar.part, seed=seed)
    page = _write_page(found, out)
    plain = found.verdict.as_json()
    typer.echo("\n".join(["", *_story(plain, drives.eccentricity), "", f"page   {page}"]))
    typer.echo(f"again  fsm-calib diagnose {out}/drive-1 {out}/drive-2 --holdout {out}/drive-3")
    if is_opened and sys.stdout.isatty():
        import webbrowser

        webbrowser.open(page.resolve().as_uri())
    if [effect["name"] for effect in plain["effects"]] != [HIDDEN]:
        raise typer.Exit(1)


def _write_drives(out: Path, seed: int) -> None:
    """Write the demo's drives as tables without manifests."""
    from fsm_calib.demo import SHORT, drive_demo, write_tables

    make_folder(out)
    drives = drive_demo(seed, seconds=SHORT)
    for recording in (*drives.learned, drives.judged):
        commands, poses = write_tables(recording, out, recording.source)
        typer.echo(f"{commands} and {poses.name}")


def make_folder(folder: Path) -> None:
    """Make a folder for results.

    Raises
    ------
    InputError
        It cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"no folder can be made here: {error.strerror}", where=str(folder)) from error


def _write_page(found: Diagnosis, out: Path) -> Path:
    """Write the page and the improved world."""
    from fsm_calib.report.diagnosis_report import write_report
    from fsm_calib.report.diagnosis_world import world_text

    write_file(out / "world.yaml", world_text(found))
    return write_report(found, out)


def _story(plain: dict[str, Any], hidden: float) -> list[str]:
    """Return what was found beside what was hidden, and how much better the improved simulation predicts."""
    lines = [f"hidden     the left wheel sits off its centre by {hidden:.4f} of its radius"]
    for effect in plain["effects"]:
        lines.append(f"found      {effect['sentence']} ({100.0 * effect['confidence']:.0f} % sure)")
    if not plain["effects"]:
        lines.append(f"found      {plain['verdict']}: {plain['reason']}")
    errors = plain["fit"]["holdout"]
    shown = [
        f"{words} {1e3 * errors[key]['xy_m']:.1f} mm"
        for key, words in (("before", "without"), ("after", "with it"), ("floor", "noise alone"))
    ]
    lines.append(f"predicted  {plain['fit']['horizon_s']:g} s ahead on the third drive: {', '.join(shown)}")
    return lines


def init(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="The scenario to write.", show_default=True)
    ] = Path("my_robot.yaml"),
    like: Annotated[
        str, typer.Option("--from", metavar="NAME", help="The shipped scenario to begin with.")
    ] = "full_calibration",
) -> None:
    """Write a scenario to edit, with its schema beside it for your editor."""
    from fsm_calib.shipped import scenario_names, shipped_folder

    if like not in scenario_names():
        raise UnknownNameError("scenario", like, scenario_names(), where="--from")
    if file.exists():
        raise InputError("exists already", where=str(file), cure="Give another name, or remove it first.")
    make_folder(file.parent)
    folder = shipped_folder("scenarios")
    text = (folder / f"{like}.yaml").read_text(encoding="utf-8")
    write_file(file, text)
    schema = "study_schema.json" if f"$schema={'study_schema.json'}" in text else "schema.json"
    beside = file.parent / schema
    if not beside.exists():
        shutil.copyfile(folder / schema, beside)
    command = "study" if schema.startswith("study") else "run"
    typer.echo(f"{file} written, like {like}. Edit it, then:")
    typer.echo(f"  fsm-calib validate {file}\n  fsm-calib {command} {file}")
