"""The options of `fsm-calib diagnose`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

Recordings = Annotated[
    list[str], typer.Argument(metavar="RECORDING", help="Manifests, folders, bags or .mcap files.")
]
HoldoutOption = Annotated[
    list[str] | None, typer.Option(metavar="RECORDING", help="Judge the result on this one; repeatable.")
]
AgainstOption = Annotated[
    list[str] | None,
    typer.Option(metavar="RECORDING", help="What your simulator drove: say what it lacks; repeatable."),
]
SimulatorOption = Annotated[
    str | None,
    typer.Option(
        metavar="MODULE:FUNCTION|PROGRAM",
        help="Your simulator itself: it is driven by the recordings' commands, and what it lacks is applied around it.",
    ),
]
WithoutOption = Annotated[
    list[str] | None,
    typer.Option(metavar="NAME", help="Leave an effect out of the catalogue; repeatable."),
]
WorldOption = Annotated[
    Path | None,
    typer.Option(
        metavar="FILE",
        help="Compare with the robot of this scenario, its effects switched on. "
        "A file that does not exist yet is written instead: the improved world.",
    ),
]
JsonOption = Annotated[
    Path | None,
    typer.Option("--json", metavar="FILE", help="Write the verdict as JSON; - for standard output."),
]
ReportOption = Annotated[
    Path | None, typer.Option(metavar="DIR", help="Write report.html and world.yaml to this folder.")
]
ExportOption = Annotated[
    Path | None,
    typer.Option(
        metavar="DIR", help="Write what was found for other programs: Python, ros2, Gazebo, MuJoCo."
    ),
]
PlanOption = Annotated[
    Path | None,
    typer.Option(metavar="DIR", help="Design the next drive, and write it to this folder to be played."),
]
AreaOption = Annotated[
    str | None,
    typer.Option(
        metavar="WxD",
        help="With --plan: free floor for the next drive [m], the start in its middle (default: 2x2).",
    ),
]
LongestOption = Annotated[
    float | None,
    typer.Option(
        metavar="SECONDS", help="With --plan: longest next drive (default: 40).", min=2.0, max=300.0
    ),
]
SeedOption = Annotated[int, typer.Option(metavar="N", help="Seed of the significance test.")]
ProcessesOption = Annotated[
    int | None,
    typer.Option(
        "--jobs", metavar="N", help="Fits side by side (default: all cores).", min=1, show_default=False
    ),
]
