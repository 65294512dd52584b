"""`fsm-calib identify`: fit the base robot alone to recordings."""

from __future__ import annotations

from datetime import datetime
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
from fsm_calib.commands.help import WholeSentences
from fsm_calib.commands.manifests import init_command
from fsm_calib.commands.options import EffectsOption, JsonOption
from fsm_calib.errors import shown
from fsm_calib.report import digits

if TYPE_CHECKING:
    from fsm_calib.types import WheelCalibration


def register(app: typer.Typer) -> None:
    """Add `identify` to the command line."""
    app.command("identify")(identify_command)
    recording = typer.Typer(cls=WholeSentences, help="Recordings: write a manifest.", no_args_is_help=True)
    recording.command("init")(init_command)
    app.add_typer(recording, name="recording")


def identify_command(
    recordings: Annotated[
        list[str], typer.Argument(metavar="RECORDING", help="Manifests, bags or .mcap files.")
    ],
    json_file: JsonOption = None,
    world: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="Fit under the physics that this scenario's robot has (world.yaml)."
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write Duckietown's kinematics file: gain, trim, baseline, k."),
    ] = None,
    tag_map: TagMapFile = None,
    effects: EffectsOption = None,
    command: CommandTopic = None,
    pose: PoseTopic = None,
    wheels: WheelsTopic = None,
    urdf: RobotFile = None,
) -> None:
    """Fit the base robot alone: radii, axle, gains, time constants, sensor pose, each with a deviation."""
    from fsm_calib.diagnosis.identify.identify import identify
    from fsm_calib.diagnosis.identify.result import told_once
    from fsm_calib.diagnosis.identify.straight import straight_sentence, wheel_calibration
    from fsm_calib.recording.untold import why_no_pull

    check_places(json_file, out)
    loaded, _ = recordings_given(recordings, tag_map=tag_map, named=named_by(command, pose, wheels, urdf))
    if world is None:
        result = identify(loaded)
    else:
        from fsm_calib.diagnosis.identify_in_world import identify_in_world
        from fsm_calib.scenario.world import physics_of

        result = identify_in_world(loaded, physics_of(world))
    plain = result.to_json()
    calibration = None if out is None else wheel_calibration(result, loaded)
    pulls = straight_sentence(result, loaded)
    said = f"{plain['robot']} {pulls}" if pulls else f"where it pulls is not told: {why_no_pull(loaded)}"
    tell_result(plain, "\n".join([*_lines(plain, told_once(result, loaded)), said]), json_file)
    if out is not None and calibration is not None:
        _write_kinematics(out, calibration, recordings)


def _write_kinematics(out: Path, wheels: WheelCalibration, recordings: list[str]) -> None:
    """Write Duckietown's kinematics file."""
    from fsm_calib.calibration_files import kinematics_text

    provenance = shown(f"fsm-calib identify {' '.join(Path(path).name for path in recordings)}")
    write_file(out, kinematics_text(wheels, datetime.now(), provenance))


def _lines(plain: dict[str, Any], rows: dict[str, dict[str, Any]]) -> list[str]:
    """Return the result as lines of text, its numbers from `rows`."""
    lines = [f"{plain['robot']}: from {plain['method']}"]
    for name, estimate in rows.items():
        if estimate["value"] is None:
            lines.append(f"  {name:28s} not told: {estimate['reason']}")
        else:
            said = digits.estimate(estimate["value"], estimate["sd"], estimate["unit"], "+-")
            lines.append(f"  {name:28s} {said}")
    lines += [f"  residual {name:19s} {value:.6g}" for name, value in plain["residual"].items()]
    return lines + [f"  note: {note}" for note in plain["notes"]]
