"""Takes a page's picture for the docs: on a desk (1280 px, by day) and on a phone (390 px, at night), side by side.

    python benchmarks/page_pictures.py out/report.html docs/pictures/page_run.jpg [--height 1500]

Needs chromium.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import tempfile
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

QUALITY = 80
GAP = 24
"""Between the two pictures [px]."""


def shot(page: Path, width: int, height: int, is_dark: bool, scratch: Path) -> NDArray[np.uint8]:
    """Return the top of a page, `width` px wide: in a frame, since a browser's window cannot be as narrow as a phone."""
    frame = scratch / f"{width}.html"
    style = "margin: 0; border: 0; display: block"
    frame.write_text(
        f'<body style="{style}"><iframe src="{page.resolve().as_uri()}" scrolling="no" style="{style}"'
        f' width="{width}" height="{height}"></iframe>',
        encoding="utf-8",
    )
    picture = scratch / f"{width}.png"
    command = ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"]
    command += [f"--blink-settings=preferredColorScheme={0 if is_dark else 1}", "--virtual-time-budget=4000"]
    command += [f"--window-size={max(width, 600)},{height}", f"--user-data-dir={scratch / 'profile'}"]
    subprocess.run(
        [*command, f"--screenshot={picture}", frame.as_uri()], check=True, capture_output=True, timeout=240
    )
    return np.asarray(cv2.imread(str(picture))[:, :width], dtype=np.uint8)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("page", type=Path)
    parser.add_argument("picture", type=Path)
    parser.add_argument("--height", type=int, default=1500, help="of the part that is shown [px]")
    given = parser.parse_args()
    if shutil.which("chromium") is None:
        raise SystemExit("needs chromium (Debian: apt-get install chromium)")
    with tempfile.TemporaryDirectory() as scratch:
        desk = shot(given.page, 1280, given.height, False, Path(scratch))
        phone = shot(given.page, 390, given.height, True, Path(scratch))
    gap = np.full((given.height, GAP, 3), 255, dtype=np.uint8)
    whole = np.hstack([desk, gap, phone])
    small = cv2.resize(whole, None, fx=0.7, fy=0.7, interpolation=cv2.INTER_AREA)
    cv2.imwrite(str(given.picture), small, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])


if __name__ == "__main__":
    main()
