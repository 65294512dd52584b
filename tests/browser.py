"""A headless Chromium for tests, where there is one."""

import json
import re
import shutil
import subprocess
from collections.abc import Mapping
from html import unescape
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

PROGRAM = next(
    (path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))), None
)
LONGEST = 240.0
"""Longest wait for a page [s]."""
needs_browser = pytest.mark.skipif(
    PROGRAM is None, reason="no Chromium here (Debian: apt-get install chromium)"
)


def _ran(command: list[str]) -> subprocess.CompletedProcess[str]:
    """Run the browser; on a machine that is too busy for one, the test is skipped."""
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True, timeout=LONGEST)
    except subprocess.TimeoutExpired:
        pytest.skip("the browser did not answer in time")


def page_after_scripts(address: str, tmp_path, budget_ms: int = 5000) -> str:
    """Return the document of a page as it is after its scripts have run for `budget_ms` of its own time."""
    command = [
        PROGRAM, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path / 'profile'}",
        f"--virtual-time-budget={budget_ms}", "--dump-dom", address,
    ]  # fmt: skip
    return _ran(command).stdout


def picture_of(page: Path, width: int, height: int, scratch: Path) -> NDArray[np.uint8]:
    """Return a page or a drawing as a browser paints it in a window of `width` x `height` px, grey."""
    frame, target = scratch / "frame.html", scratch / "frame.png"
    style = f"position: fixed; inset: 0; width: {width}px; height: {height}px"
    frame.write_text(f'<!doctype html><img src="{page.as_uri()}" style="{style}">', encoding="utf-8")
    _ran([
        PROGRAM, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", f"--screenshot={target}",
        f"--user-data-dir={scratch / 'profile'}", f"--window-size={width},{height}", frame.as_uri(),
    ])  # fmt: skip
    return np.asarray(cv2.imread(str(target), cv2.IMREAD_GRAYSCALE), np.uint8)


WIDTHS = (390, 1280)
"""A phone and a desk [px]."""
PROBE = (Path(__file__).parent / "page_probe.js").read_text(encoding="utf-8").strip().rstrip(";")
TOLD = re.compile(r'<pre id="told">(.*?)</pre>', re.DOTALL)
CONSOLE = re.compile(r":CONSOLE[:(].*?(?:Uncaught|Error|Refused|Failed).*")


def faults(pages: Mapping[str, str], folder: Path, address: str | None = None) -> list[str]:
    """Return what is wrong with pages, given by name, in a browser at both widths, by day and at night.

    `address` is where the folder is served, for pages that need a server.
    Looked for: scrolling sideways, text that is cut, contrast below WCAG's AA, errors of scripts (`page_probe.js`).
    """
    frames = []
    for name, html in pages.items():
        for width in WIDTHS:
            asked = f"{name} {width}"
            tell = f"setTimeout(() => parent.postMessage([{json.dumps(asked)}, {PROBE}], '*'), 300)"
            (folder / f"{name}-{width}.html").write_text(f"{html}<script>{tell}</script>", encoding="utf-8")
            frames.append(f'<iframe src="{name}-{width}.html" width="{width}" height="900"></iframe>')
    gather = "onmessage = e => { told.push(e.data); out.textContent = JSON.stringify(told); }"
    script = f"<script>const told = [], out = document.getElementById('told'); {gather}</script>"
    whole = folder / "all.html"
    whole.write_text(f'<!doctype html><pre id="told"></pre>{script}{"".join(frames)}', encoding="utf-8")
    return [
        f"{scheme}: {fault}"
        for scheme in ("dark", "light")
        for fault in _told(whole, address or folder.as_uri(), scheme, len(frames))
    ]


def _told(whole: Path, address: str, scheme: str, count: int) -> list[str]:
    """Return the faults that the frames of a page told, and what the console said."""
    command = [
        PROGRAM, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={whole.parent / scheme}",
        f"--blink-settings=preferredColorScheme={0 if scheme == 'dark' else 1}", "--enable-logging=stderr",
        "--window-size=1400,1000", "--virtual-time-budget=4000", "--dump-dom",
        f"{address}/{whole.name}",
    ]  # fmt: skip
    done = _ran(command)
    found = TOLD.search(done.stdout)
    assert found is not None, done.stdout[:500]
    answers = json.loads(unescape(found[1]) or "[]")
    assert len(answers) == count, [name for name, _ in answers]
    said = [f"console: {line}" for line in CONSOLE.findall(done.stderr)]
    return said + [f"{name}: {fault}" for name, told in answers for fault in told]
