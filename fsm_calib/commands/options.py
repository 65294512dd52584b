"""Options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def _add_effects(files: list[Path] | None) -> list[Path] | None:
    """Add the effects of the files to the catalogue before anything asks for it."""
    if files:
        from fsm_calib.world2d.effects import add_effects

        add_effects(files)
    return files


EffectsOption = Annotated[
    list[Path] | None,
    typer.Option(
        "--effects",
        metavar="FILE.py",
        help="Add the effects that this file declares (docs/own-effect.md); repeatable.",
        callback=_add_effects,
        show_default=False,
    ),
]
"""Effects from outside; the catalogue has them when the command's body begins."""
