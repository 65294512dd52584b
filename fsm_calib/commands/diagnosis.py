"""`fsm-calib diagnose`: which physics a simulation leaves out, and what it could be."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from fsm_calib.commands import diagnosis_options as options
from fsm_calib.commands.files import check_folders, check_places, tell_result, write_file
from fsm_calib.commands.given import (
    CommandTopic,
    PoseTopic,
    RobotFile,
    TagMapFile,
    WheelsTopic,
    named_by,
    recordings_given,
)
from fsm_calib.commands.next_drive import next_drive_of, write_plan
from fsm_calib.commands.options import EffectsOption
from fsm_calib.commands.verdict_lines import summary_lines
from fsm_calib.errors import UnknownNameError
from fsm_calib.workers import usable_cores

if TYPE_CHECKING:
    from fsm_calib.diagnosis.diagnose import Diagnosis
    from fsm_calib.diagnosis.own_simulator import OwnSimulator
    from fsm_calib.diagnosis.replay.settings import Settings
    from fsm_calib.recording.recording import Recording

PAGES = (".html", ".htm")


def register(app: typer.Typer) -> None:
    """Add `diagnose` to the command line."""
    app.command("diagnose")(diagnose_command)


def diagnose_command(
    recordings: options.Recordings,
    holdout: options.HoldoutOption = None,
    against: options.AgainstOption = None,
    simulator: options.SimulatorOption = None,
    without: options.WithoutOption = None,
    world: options.WorldOption = None,
    json_file: options.JsonOption = None,
    report: options.ReportOption = None,
    export: options.ExportOption = None,
    plan: options.PlanOption = None,
    area: options.AreaOption = None,
    longest: options.LongestOption = None,
    seed: options.SeedOption = 0,
    jobs: options.ProcessesOption = None,
    tag_map: TagMapFile = None,
    effects: EffectsOption = None,
    command: CommandTopic = None,
    pose: PoseTopic = None,
    wheels: WheelsTopic = None,
    urdf: RobotFile = None,
) -> None:
    """Compare recordings with the simulation: locate the mismatch, name the physics, show the fit improve."""
    _refuse_wrong_use(without or (), (json_file, world), (report, export, plan))
    wanted = next_drive_of(plan, area, longest)
    given = world if world is not None and world.exists() else None
    called = _simulator(simulator)
    physics = _physics(given, bool(against or called))
    named = named_by(command, pose, wheels, urdf)
    train, new = recordings_given(recordings, holdout or (), tag_map=tag_map, named=named)
    simulated = recordings_given(against, tag_map=tag_map, named=named)[0] if against else []
    asked = Asked(train, new, tuple(without or ()), seed, jobs or usable_cores())
    result, plain = _beside(asked, simulated, called) if against or called else _alone(asked, physics)
    for note in result.notes:
        typer.echo(note, err=True)
    if given is not None:
        typer.echo(f"compared with the robot of {given}", err=True)
    tell_result(plain, "\n".join(summary_lines(plain)), json_file)
    _write_world(result, None if given is not None else world, report)
    _write_export(result, export)
    if wanted is not None:
        write_plan(result, wanted, seed)


@dataclass(frozen=True)
class Asked:
    """What is asked: recordings to fit and to judge on, effects to leave out, seed, fits side by side."""

    train: Sequence[Recording]
    new: Sequence[Recording]
    without: tuple[str, ...]
    seed: int
    processes: int

    @property
    def settings(self) -> Settings:
        """How the diagnosis looks at the recordings."""
        from fsm_calib.diagnosis.replay.settings import Settings

        return Settings(processes=self.processes)


def _alone(asked: Asked, physics: dict[str, float] | None) -> tuple[Diagnosis, dict[str, Any]]:
    """Diagnose the recordings; return the diagnosis and its JSON."""
    from fsm_calib.diagnosis.diagnose import diagnose
    from fsm_calib.progress.diagnosis import DiagnosisProgress
    from fsm_calib.world2d.effects import registry

    with DiagnosisProgress(len(registry())) as bar:
        result = diagnose(
            asked.train,
            asked.new,
            without=asked.without,
            world=physics,
            settings=asked.settings,
            progress=bar.part,
            seed=asked.seed,
        )
    return result, result.verdict.as_json()


def _beside(
    asked: Asked, simulated: Sequence[Recording], called: OwnSimulator | None
) -> tuple[Diagnosis, dict[str, Any]]:
    """Diagnose the recordings beside a simulator's; return the real robot's diagnosis and the JSON of both.

    called : the simulator itself, which is driven by the recordings' commands, or None.
    """
    from fsm_calib.diagnosis.against import diagnose_against
    from fsm_calib.diagnosis.around import around, simulated_recordings
    from fsm_calib.progress.diagnosis import DiagnosisProgress
    from fsm_calib.world2d.effects import registry

    with DiagnosisProgress(2 * len(registry())) as bar:
        made = simulated_recordings(called, asked.train, asked.seed) if called else []
        found = diagnose_against(
            asked.train,
            [*simulated, *made],
            asked.new,
            without=asked.without,
            settings=asked.settings,
            progress=bar.part,
            seed=asked.seed,
        )
        plain = found.as_json()
        if called:
            plain["against"]["simulator"] = around(found, called, asked.seed).as_json()
    return found.real, plain


def _simulator(text: str | None) -> OwnSimulator | None:
    """Return the user's simulator; None where none was named."""
    from fsm_calib.commands.own_simulator import simulator_of

    return None if text is None else simulator_of(text)


def _physics(world: Path | None, beside: bool) -> dict[str, float] | None:
    """Return the physics of the world to compare with, by full name; None for the base robot alone.

    Raises
    ------
    InputError
        The world cannot be read, or a simulator was given, too.
    """
    if world is None:
        return None  # what reads scenarios brings cameras and machines along
    from fsm_calib.errors import InputError
    from fsm_calib.scenario.world import physics_of

    physics = physics_of(world)
    if beside:
        raise InputError("a world and a simulator at once", where="--against", cure="Give one of the two.")
    return physics


def _refuse_wrong_use(
    without: Iterable[str], files: Iterable[Path | None], folders: Iterable[Path | None]
) -> None:
    """Raise `InputError` for unknown effects and for output that cannot be written, before any work is done."""
    from fsm_calib.errors import InputError
    from fsm_calib.world2d.effects import registry

    for name in without:
        if name not in registry():
            raise UnknownNameError("effect", name, registry(), where="--without")
    check_places(*files)
    for folder in folders:
        if folder is not None and folder.exists() and not folder.is_dir():
            raise InputError("this needs a folder, it is a file", where=str(folder))
        if folder is not None and folder.suffix in PAGES and not folder.exists():
            cure = f"Give a folder, such as {folder.with_suffix('')}: the page is report.html in it."
            raise InputError("this needs a folder, its name is a page's", where=str(folder), cure=cure)
        check_folders(folder)


def _write_world(result: Diagnosis, world: Path | None, report: Path | None) -> None:
    """Write the improved world to its own file, and with the page into the report's folder; None for neither."""
    if world is None and report is None:
        return
    from fsm_calib.report.diagnosis_world import world_text

    text = world_text(result)
    if world is not None:
        write_file(world, text)
    if report is not None:
        from fsm_calib.report.diagnosis_report import write_report

        report.mkdir(parents=True, exist_ok=True)
        write_file(report / "world.yaml", text)
        typer.echo(f"report: {write_report(result, report)}")


def _write_export(result: Diagnosis, folder: Path | None) -> None:
    """Write what was found for other programs into a folder; None for nowhere."""
    if folder is None:
        return
    from fsm_calib.report.export import exported

    folder.mkdir(parents=True, exist_ok=True)
    for name, text in exported(result).items():
        write_file(folder / name, text)
    typer.echo(f"for other programs: {folder / 'README.md'}")
