"""Composes the README's picture from a run: what the robot saw and found, where it drove, and one of its machines.

    fsm-calib run scenarios/full_calibration.yaml --out out/picture
    python benchmarks/readme_picture.py out/picture docs/pictures/calibration.jpg

Needs chromium, which lays out the page and takes its picture.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import cv2

ROOT = Path(__file__).parent.parent
SIZE = (1560, 900)
QUALITY = 82
BOARD_GREEN, LINE = (90, 200, 40), cv2.LINE_AA
PAGE = """<html><style>
body {{ margin: 0; width: {width}px; height: {height}px; background: #fff; font: 17px sans-serif; color: #333; overflow: hidden }}
.grid {{ display: grid; grid-template-columns: 450px 1fr; gap: 14px; padding: 14px }}
figure {{ margin: 0 0 10px }} figcaption {{ padding: 2px 0 }} img {{ width: 450px; display: block }}
.plan svg {{ width: 1060px; height: 540px }} .machine img {{ width: auto; height: 282px; margin: auto }}
</style><div class="grid"><div>{seen}</div><div>
<figure class="plan"><figcaption>Where it drove: among the boards, over the markers, out into the lane</figcaption>{plan}</figure>
<figure class="machine"><figcaption>One of its machines, drawn from the table that runs</figcaption>{machine}</figure>
</div></div></html>"""


def seen(directory: Path, folder: Path) -> str:
    """Return three frames of a run with what was found in them, as HTML."""
    pictures = json.loads((directory / "checkpoint.json").read_text())["gallery"]
    chosen = [
        ("A chessboard: 35 corners to 0.05 px", _best(pictures, "scan/counterclockwise")),
        ("Floor markers: where it is, how straight it drove", _best(pictures, "wheels/comparing")),
        ("Markers in the lane: is k still right?", _best(pictures, "lane/")),
    ]
    return "".join(_figure(directory, folder, title, picture) for title, picture in chosen)


def _best(pictures: list[dict], path: str) -> dict:
    """Return the picture of a state in which most was found."""
    return max(
        (picture for picture in pictures if picture["path"].startswith(path)), key=lambda p: len(p["points"])
    )


def _figure(directory: Path, folder: Path, title: str, picture: dict) -> str:
    """Draw the points found into a frame and return it as a figure."""
    image = cv2.imread(str(directory / picture["file"]))
    for x, y in picture["points"]:
        cv2.circle(image, (round(x * 16), round(y * 16)), 4 * 16, BOARD_GREEN, 2, LINE, 4)
    low = image[110:470]  # the hall above says nothing
    name = Path(picture["file"]).name
    cv2.imwrite(str(folder / name), low)
    return f'<figure><img src="{name}"><figcaption>{title}</figcaption></figure>'


def main() -> None:
    directory, target = Path(sys.argv[1]), Path(sys.argv[2])
    report = (directory / "report.html").read_text()
    plan = re.search(r'<svg[^>]*aria-label="Floor plan.*?</svg>', report, flags=re.DOTALL)
    if plan is None:
        sys.exit(f"{directory}/report.html holds no floor plan")
    with tempfile.TemporaryDirectory(dir=Path.home()) as name:
        folder = Path(name)
        machine = f'<img src="{(ROOT / "diagrams/focus.svg").as_uri()}">'
        page = folder / "page.html"
        frames = seen(directory, folder)
        page.write_text(
            PAGE.format(width=SIZE[0], height=SIZE[1], seen=frames, plan=plan.group(), machine=machine)
        )
        shot = folder / "page.png"
        command = [
            "chromium",
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--allow-file-access-from-files",
        ]
        size = f"--window-size={SIZE[0]},{SIZE[1]}"
        subprocess.run(
            [*command, size, f"--screenshot={shot}", page.as_uri()], check=True, capture_output=True
        )
        target.parent.mkdir(parents=True, exist_ok=True)
        cv2.imwrite(str(target), cv2.imread(str(shot)), [cv2.IMWRITE_JPEG_QUALITY, QUALITY])


if __name__ == "__main__":
    main()
