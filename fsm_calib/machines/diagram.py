"""The files in `diagrams/`: Mermaid and DOT text and a picture of every machine, written from the tables.

`--check` compares the texts. A picture carries the digest of the DOT text it was drawn from, so that a stale
picture is found without drawing it again. Pictures are drawn by Graphviz (`dot`) where it is installed;
elsewhere the project's own pictures are taken as long as they are current.
"""

from __future__ import annotations

import hashlib
import shutil
import subprocess
from pathlib import Path

from fsm_calib.machines.document import machines_markdown
from fsm_calib.machines.dot import dot_text
from fsm_calib.machines.mermaid import mermaid_text
from fsm_calib.machines.picture import Picture, picture
from fsm_calib.machines.supervisor import MACHINES, PHASES, SUPERVISOR

DIGEST = "<!-- drawn from the DOT text with sha256 {} -->"


SHIPPED = Path(__file__).parents[1] / "_shipped" / "diagrams"
COMMITTED = SHIPPED if SHIPPED.is_dir() else Path(__file__).parents[2] / "diagrams"
"""The project's own diagrams: in an installed wheel, or at the top of the source tree."""
SHARED = "squaring"
"""The part that several machines share: in pictures it is open once, as `orientation`."""


def pictures(*, closed: tuple[str, ...] = ()) -> dict[str, Picture]:
    """Return what is drawn, by file stem: the supervisor (machines closed), each machine, the whole."""
    drawn = {chart.name: picture(chart, closed=closed) for chart in MACHINES}
    return {"supervisor": picture(SUPERVISOR, closed=PHASES), **drawn, "whole": picture(SUPERVISOR)}


def diagram_texts() -> dict[str, str]:
    """Return the text files of `diagrams/` by name."""
    texts = {f"{stem}.mmd": mermaid_text(drawn) for stem, drawn in pictures().items()}
    texts["README.md"] = machines_markdown()
    return texts | {f"{stem}.dot": dot_text(drawn) for stem, drawn in pictures(closed=(SHARED,)).items()}


def write_diagrams(directory: Path | str) -> list[Path]:
    """Write all diagrams into `directory` and return the paths written."""
    folder = Path(directory)
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for name, text in diagram_texts().items():
        (folder / name).write_text(text, encoding="utf-8", newline="\n")
        written.append(folder / name)
        if name.endswith(".dot") and (svg := draw_svg(text) or _committed_svg(name, text)):
            written.append((folder / name).with_suffix(".svg"))
            written[-1].write_text(svg, encoding="utf-8", newline="\n")
    return written


def stale_diagrams(directory: Path | str) -> list[Path]:
    """Return the files in `directory` that are missing or differ from what the tables say."""
    folder, stale = Path(directory), []
    for name, text in diagram_texts().items():
        path = folder / name
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            stale.append(path)
        svg = path.with_suffix(".svg")
        if name.endswith(".dot") and (
            not svg.is_file() or _digest(text) not in svg.read_text(encoding="utf-8")
        ):
            stale.append(svg)
    return stale


def draw_svg(text: str) -> str | None:
    """Return the SVG picture of a DOT text, or None when Graphviz is not installed."""
    program = shutil.which("dot")
    if program is None:
        return None
    done = subprocess.run(
        [program, "-Tsvg"], input=text, capture_output=True, text=True, check=True, encoding="utf-8"
    )
    return done.stdout.rstrip() + "\n" + _digest(text) + "\n"


def _committed_svg(name: str, text: str) -> str | None:
    """Return the project's own picture of the DOT text, or None where it is not at hand or stale."""
    path = (COMMITTED / name).with_suffix(".svg")
    svg = path.read_text(encoding="utf-8") if path.is_file() else ""
    return svg if _digest(text) in svg else None


def _digest(text: str) -> str:
    return DIGEST.format(hashlib.sha256(text.encode()).hexdigest())
