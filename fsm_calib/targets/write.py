"""Writes the printable files of an area: boards, tags, the area in sheets, a poster, the plan."""

from __future__ import annotations

from pathlib import Path

from fsm_calib.targets.area import area_sheets, poster, tiling
from fsm_calib.targets.boards import board_sheets
from fsm_calib.targets.pdf import write_pdf
from fsm_calib.targets.plan import plan_sheet
from fsm_calib.targets.sheet import Sheet
from fsm_calib.targets.tags import placed_tags, tag_sheets
from fsm_calib.world2d.scene import SceneSpec


def write_targets(scene: SceneSpec, name: str, folder: Path, paper: str = "a4") -> dict[Path, int]:
    """Write ``plan.pdf``, ``boards.pdf``, ``tags.pdf``, ``area.pdf`` and ``poster.pdf``; return their pages.

    Everything is drawn before anything is written.

    Raises
    ------
    InputError
        An unknown paper, or a board or tag that it does not hold; a file that cannot be written.
    """
    cut = tiling(scene, paper)
    sheets: dict[str, list[Sheet]] = {
        "plan": [plan_sheet(scene, paper, name, cut)],
        "boards": board_sheets(scene.boards, paper),
        "tags": tag_sheets(placed_tags(scene), paper),
        "area": area_sheets(scene, paper),
        "poster": [poster(scene)],
    }
    written = {}
    for stem, pages in sheets.items():
        if pages:
            path = folder / f"{stem}.pdf"
            write_pdf(path, pages, f"{stem} of {name}")
            written[path] = len(pages)
    return written
