"""`fsm-calib diagnose` and `fsm-calib effects`: which physics a simulation leaves out, and what it could be."""

from __future__ import annotations

import json
import textwrap
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fsm_calib.commands.files import check_places, tell_result, write_file
from fsm_calib.commands.given import (
    CommandTopic,
    PoseTopic,
    RobotFile,
    TagMapFile,
    WheelsTopic,
    named_by,
    recordings_given,
)
from fsm_calib.commands.next_drive import area_of, write_plan
from fsm_calib.commands.options import EffectsOption
from fsm_calib.errors import UnknownNameError

if TYPE_CHECKING:
    from fsm_calib.diagnosis.against import Against
    from fsm_calib.diagnosis.diagnose import Diagnosis


WIDTH = 80
"""Characters of a line of text: what every terminal has."""

CLEAR = 3.0  # standard deviations from which a difference is printed


def register(app: typer.Typer) -> None:
    """Add `diagnose` and `effects` to the command line."""
    app.command("diagnose")(diagnose_command)
    app.command("effects")(effects_command)


def diagnose_command(
    recordings: Annotated[
        list[str], typer.Argument(metavar="RECORDING...", help="Manifests, folders, bags or .mcap files.")
    ],
    holdout: Annotated[
        list[str] | None, typer.Option(metavar="RECORDING", help="Judge the result on this one; repeatable.")
    ] = None,
    against: Annotated[
        list[str] | None,
        typer.Option(metavar="RECORDING", help="What your simulator drove: say what it lacks; repeatable."),
    ] = None,
    without: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="Leave an effect out of the catalogue; repeatable."),
    ] = None,
    world: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Compare with the robot of this scenario, its effects switched on. "
            "A file that does not exist yet is written instead: the improved world.",
        ),
    ] = None,
    json_file: Annotated[
        Path | None,
        typer.Option("--json", metavar="FILE", help="Write the verdict as JSON; - for standard output."),
    ] = None,
    report: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Write report.html and world.yaml to this folder.")
    ] = None,
    export: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", help="Write what was found for other programs: Python, ros2, Gazebo, MuJoCo."
        ),
    ] = None,
    plan: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Design the next drive, and write it to this folder to be played."),
    ] = None,
    area: Annotated[
        str, typer.Option(metavar="WxD", help="Free floor for the next drive [m], the start in its middle.")
    ] = "2x2",
    longest: Annotated[
        float, typer.Option(metavar="SECONDS", help="Longest next drive.", min=2.0, max=300.0)
    ] = 40.0,
    seed: Annotated[int, typer.Option(help="Seed of the significance test.")] = 0,
    tag_map: TagMapFile = None,
    effects: EffectsOption = None,
    command: CommandTopic = None,
    pose: PoseTopic = None,
    wheels: WheelsTopic = None,
    urdf: RobotFile = None,
) -> None:
    """Compare recordings with the simulation: locate the mismatch, name the physics, show the fit improve."""
    from fsm_calib.diagnosis.against import diagnose_against
    from fsm_calib.diagnosis.diagnose import diagnose
    from fsm_calib.errors import InputError
    from fsm_calib.progress.diagnosis import DiagnosisProgress
    from fsm_calib.scenario.world import physics_of
    from fsm_calib.world2d.effects import registry

    _refuse_wrong_use(without or (), (json_file, world), (report, export))
    floor = area_of(area)
    given = world if world is not None and world.exists() else None
    physics = physics_of(given) if given is not None else None
    if given is not None and against:
        raise InputError("a world and a simulator at once", where="--against", cure="Give one of the two.")
    named = named_by(command, pose, wheels, urdf)
    train, new = recordings_given(recordings, holdout or (), tag_map=tag_map, named=named)
    beside: Against | None = None
    if against:
        simulated, _ = recordings_given(against, tag_map=tag_map, named=named)
        with DiagnosisProgress(2 * len(registry())) as bar:
            beside = diagnose_against(
                train, simulated, new, without=without or (), progress=bar.part, seed=seed
            )
        result = beside.real
    else:
        with DiagnosisProgress(len(registry())) as bar:
            result = diagnose(train, new, without=without or (), world=physics, progress=bar.part, seed=seed)
    for note in result.notes:
        typer.echo(note, err=True)
    if given is not None:
        typer.echo(f"compared with the robot of {given}", err=True)
    plain = result.verdict.as_json() if beside is None else beside.as_json()
    tell_result(plain, "\n".join(summary_lines(plain)), json_file)
    _write_world(result, None if given is not None else world, report)
    _write_export(result, export)
    if plan is not None:
        write_plan(result, floor, longest, plan, seed)


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


def summary_lines(plain: dict[str, Any]) -> list[str]:
    """Return the verdict as lines of text."""
    lines = [f"{plain['verdict']}: {plain['reason']}"]
    for effect in plain["effects"]:
        names = next((group for group in plain["ambiguous"] if effect["name"] in group), [effect["name"]])
        either = " or ".join(sorted(names, key=lambda name: name != effect["name"]))
        lines.append(f"  {either} (confidence {effect['confidence']:.2f}): {effect['sentence']}")
    for group in plain["ambiguous"]:
        lines.append(f"  cannot be told apart: {', '.join(group)}; the numbers are of the first")
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
            said = [
                f"{k} {_millimetres(errors[k]['xy_m'])}, {_degrees(errors[k]['theta_rad'])}" for k in errors
            ]
            lines.append(f"  {plain['fit']['horizon_s']:g} s error on {name}: {'; '.join(said)}")
    for rival in plain["rivals"][:3]:
        lines.append(f"  rival {rival['name']}: {rival['evidence_gap']:.0f} behind")
    lines += _would_show(plain["smallest_seen"])
    lines.append(f"  next: {plain['next_manoeuvre']}")
    parts = ", ".join(f"{name} {seconds:.1f}" for name, seconds in plain["seconds_by_part"].items())
    return [*lines, f"  {plain['seconds']:.1f} s ({parts})"]


def _beside_simulator(told: dict[str, Any]) -> list[str]:
    """Return what the real robot has that the simulator lacks or has otherwise; numbers from three deviations on."""
    lines = [f"  the simulator's own: {told['verdict']}; {', '.join(told['effects']) or 'no effects'}"]
    lines += [f"  the simulator lacks: {', '.join(told['lacks'])}"] if told["lacks"] else []
    lines += [f"  it has otherwise: {', '.join(told['otherwise'])}"] if told["otherwise"] else []
    lines += [f"  alike in both: {', '.join(told['alike'])}"] if told["alike"] else []
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
    text = f"would have been seen from: {', '.join(said)}"
    return textwrap.wrap(text, 110, initial_indent="  ", subsequent_indent="    ") if said else []


def _millimetres(value: float | None) -> str:
    return "-" if value is None else f"{1e3 * value:.1f} mm"


def _degrees(value: float | None) -> str:
    return "-" if value is None else f"{57.29578 * value:.2f} deg"


def effects_command(
    names: Annotated[
        list[str] | None, typer.Argument(metavar="NAME...", help="These alone.", show_default=False)
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
        said.append(f"{p['name']} [{p['unit']}], nothing at {p['null']:g}, {low:g} to {high:g}")
    said.append(f"shows in {', '.join(row['channels'])}; {row['separates']}")
    lines = textwrap.wrap(f"{row['name']} ({row['family']}): {row['summary']}", WIDTH, subsequent_indent="  ")
    for text in said:
        lines += textwrap.wrap(text, WIDTH, initial_indent="    ", subsequent_indent="      ")
    return lines
