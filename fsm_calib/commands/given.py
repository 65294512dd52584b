"""The recordings that a command was given: the options that read them, and what is refused or said before any work."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fsm_calib.commands.files import print_findings

if TYPE_CHECKING:
    from fsm_calib.recording.named import Named
    from fsm_calib.recording.recording import Recording

TagMapFile = Annotated[
    str | None,
    typer.Option("--tag-map", metavar="FILE", help="Places of tags, for bags without poses."),
]

CommandTopic = Annotated[
    str | None, typer.Option("--command", metavar="TOPIC", help="A bag's commands: /cmd_vel.")
]
PoseTopic = Annotated[
    str | None, typer.Option("--pose", metavar="TOPIC", help="A bag's measured poses: /vrpn/robot/pose.")
]
WheelsTopic = Annotated[
    str | None, typer.Option("--wheels", metavar="TOPIC", help="A bag's wheels: /joint_states.")
]
RobotFile = Annotated[
    Path | None,
    typer.Option("--urdf", metavar="FILE", help="URDF or SDF: wheel radius, axle, mass, inertia."),
]


def named_by(command: str | None, pose: str | None, wheels: str | None, urdf: Path | None) -> Named:
    """Return what the options say about the recordings.

    Raises
    ------
    InputError
        The robot's description cannot be read.
    """
    from fsm_calib.recording.named import Named
    from fsm_calib.recording.robot_files import read_robot_file

    return Named(command, pose, wheels, robot=None if urdf is None else read_robot_file(urdf))


def recordings_given(
    paths: Sequence[str],
    holdout: Sequence[str] = (),
    *,
    tag_map: str | None = None,
    named: Named | None = None,
) -> tuple[list[Recording], list[Recording]]:
    """Return the recordings to fit and those to judge on; tell on standard error what was found in them.

    Raises
    ------
    InputError
        One cannot be read, or is both fitted and held out.
    """
    from fsm_calib.recording import read_recording
    from fsm_calib.recording.alike import refuse_shared, robot_warnings
    from fsm_calib.recording.named import NOTHING

    fitted = [read_recording(path, tag_map, named or NOTHING) for path in paths]
    new = [read_recording(path, tag_map, named or NOTHING) for path in holdout]
    refuse_shared(fitted, new)
    print_findings(fitted + new)
    for sentence in robot_warnings(fitted + new):
        typer.echo(f"warning: {sentence}", err=True)
    return fitted, new
