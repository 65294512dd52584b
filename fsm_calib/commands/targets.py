"""`fsm-calib targets`: boards, floor tags and the whole area as PDF at true scale, with a plan of what lies where."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

USES = {
    "plan": "what lies where; not to scale",
    "boards": "the chessboards, one a sheet; glue them flat",
    "tags": "the floor tags to cut out",
    "area": "in place of tags.pdf: the floor in sheets to lay edge to edge",
    "poster": "in place of tags.pdf: the floor as one sheet for a print shop",
}
"""What each file is for."""


def register(app: typer.Typer) -> None:
    """Add `targets` to the command line."""
    app.command("targets")(targets)


def targets(
    scenario: Annotated[
        Path,
        typer.Argument(
            metavar="SCENARIO", help="Whose area: a scenario file, or the name of one that is shipped."
        ),
    ] = Path("full_calibration"),
    out: Annotated[Path, typer.Option(metavar="DIR", help="Where the files go.")] = Path("targets"),
    paper: Annotated[str, typer.Option(metavar="SHEET", help="a4 or a3.")] = "a4",
) -> None:
    """Write boards, floor tags and the area as PDF at true scale, and a plan of what lies where."""
    from fsm_calib.commands.begin import make_folder
    from fsm_calib.commands.run import read_scenario
    from fsm_calib.scenario.scene import scene_of
    from fsm_calib.targets.sheet import paper_size
    from fsm_calib.targets.write import write_targets

    loaded = read_scenario(scenario)
    paper_size(paper)
    make_folder(out)
    for path, pages in write_targets(scene_of(loaded), loaded.name, out, paper).items():
        count = "1 page" if pages == 1 else f"{pages} pages"
        typer.echo(f"{path!s:<24} {count:>9}   {USES[path.stem]}")
    typer.echo("Print at 100 % (“actual size”) and measure the ruler on each sheet.")
