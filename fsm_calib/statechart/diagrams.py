"""The files in `diagrams/`: Mermaid and DOT text and a picture of every machine, written from the tables.

`--check` compares the texts. A picture carries the digest of the DOT text it was drawn from, so that a stale
picture is found without drawing it again. Pictures are drawn by Graphviz (`dot`) where it is installed;
elsewhere the pictures of `Machinery.drawn` are taken as long as they are current, and what nothing can draw is not
asked for.
"""

from __future__ import annotations

import hashlib
import shutil
import subprocess
from pathlib import Path

from fsm_calib.statechart.documents import machines_markdown
from fsm_calib.statechart.dot import dot_text
from fsm_calib.statechart.machinery import Machinery
from fsm_calib.statechart.mermaid import mermaid_text
from fsm_calib.statechart.picture import Picture, picture

DIGEST = "<!-- drawn from the DOT text with sha256 {} -->"


def pictures(machinery: Machinery, *, closed: tuple[str, ...] = ()) -> dict[str, Picture]:
    """Return what is drawn, by file stem: the root (its machines closed), each machine, and the whole."""
    root, phases = machinery.root, machinery.phases
    if not phases:
        return {root.name: picture(root)}
    drawn = {chart.name: picture(chart, closed=closed) for chart in machinery.machines}
    return {root.name: picture(root, closed=phases), **drawn, "whole": picture(root)}


def diagram_texts(machinery: Machinery) -> dict[str, str]:
    """Return the text files of `diagrams/` by name."""
    texts = {f"{stem}.mmd": mermaid_text(drawn) for stem, drawn in pictures(machinery).items()}
    texts["README.md"] = machines_markdown(machinery)
    shut = pictures(machinery, closed=machinery.shared)
    return texts | {f"{stem}.dot": dot_text(drawn) for stem, drawn in shut.items()}


def write_diagrams(machinery: Machinery, directory: Path | str) -> list[Path]:
    """Write all diagrams into `directory` and return the paths written."""
    folder = Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for name, text in diagram_texts(machinery).items():
        (folder / name).write_text(text, encoding="utf-8", newline="\n")
        written.append(folder / name)
        if name.endswith(".dot") and (svg := draw_svg(text) or _known_svg(machinery.drawn, name, text)):
            written.append((folder / name).with_suffix(".svg"))
            written[-1].write_text(svg, encoding="utf-8", newline="\n")
    return written


def stale_diagrams(machinery: Machinery, directory: Path | str) -> list[Path]:
    """Return the files in `directory` that are missing or differ from what the tables say."""
    folder, stale = Path(directory), []
    for name, text in diagram_texts(machinery).items():
        path = folder / name
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            stale.append(path)
        if name.endswith(".dot") and not _is_current(path.with_suffix(".svg"), text):
            stale.append(path.with_suffix(".svg"))
    return stale


def _is_current(svg: Path, text: str) -> bool:
    """Return whether a picture shows a DOT text; one that is not there, whether nothing here could have drawn it."""
    if not svg.is_file():
        return shutil.which("dot") is None
    return _digest(text) in svg.read_text(encoding="utf-8")


def draw_svg(text: str) -> str | None:
    """Return the SVG picture of a DOT text, or None when Graphviz is not installed."""
    program = shutil.which("dot")
    if program is None:
        return None
    done = subprocess.run(
        [program, "-Tsvg"], input=text, capture_output=True, text=True, check=True, encoding="utf-8"
    )
    return done.stdout.rstrip() + "\n" + _digest(text) + "\n"


def _known_svg(drawn: Path | None, name: str, text: str) -> str | None:
    """Return the picture of the DOT text that is already drawn, or None where there is none or it is stale."""
    path = None if drawn is None else (drawn / name).with_suffix(".svg")
    svg = path.read_text(encoding="utf-8") if path and path.is_file() else ""
    return svg if _digest(text) in svg else None


def _digest(text: str) -> str:
    return DIGEST.format(hashlib.sha256(text.encode()).hexdigest())
