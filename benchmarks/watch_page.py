"""What the page of a watched run costs: time to its first paint, and the server's processor time while a run is busy.

    python benchmarks/watch_page.py --seconds 30

A calibration (`full_calibration`, or the run in `--run DIR`) is done first. Its events are then written into another
folder at ten a second, each with a kept frame of 640 x 480 px, as a run writes them, while `fsm-calib watch` serves the
folder from a process of its own to a headless Chromium (Debian's chromium and chromium-driver). First paint is what the
browser itself says (first contentful paint, wall time from the request); the cost is the processor time of the server's
whole process.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import socket
import statistics
import subprocess
import sys
import tempfile
import time
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from fsm_calib.journal import CHECKPOINT_NAME, JOURNAL_NAME, write_atomically
from fsm_calib.watch.area import AREA_NAME

RATE = 10.0
"""Events written each second [Hz]."""
KEPT = 24
"""Frames that a run keeps: the gallery of the page [1]."""
LOADS = 5
"""How often the page is opened for its first paint [1]."""
CLI = [sys.executable, "-c", "from fsm_calib.cli import main; main()"]
PAINT = "return performance.getEntriesByName('first-contentful-paint').map(entry => entry.startTime)"
SHOWN = "return document.body.dataset.state && performance.now()"


class Browser:
    """A headless Chromium, spoken to by WebDriver."""

    def __init__(self) -> None:
        with socket.create_server(("127.0.0.1", 0)) as free:
            port = free.getsockname()[1]
        self._driver = subprocess.Popen(["chromedriver", f"--port={port}"], stdout=subprocess.DEVNULL)
        self._base = f"http://127.0.0.1:{port}"
        wait_for(lambda: self._answers(), "chromedriver")
        options = {"args": ["--headless", "--no-sandbox", "--disable-gpu", "--window-size=1280,900"]}
        wanted = {"capabilities": {"alwaysMatch": {"goog:chromeOptions": options}}}
        self._base += "/session/" + self._ask("/session", wanted)["sessionId"]

    def _answers(self) -> bool:
        try:
            with urllib.request.urlopen(f"{self._base}/status", timeout=2.0):
                return True
        except OSError:
            return False

    def _ask(self, path: str, content: dict[str, Any]) -> Any:
        request = urllib.request.Request(
            self._base + path, json.dumps(content).encode(), {"Content-Type": "application/json"}
        )
        with urllib.request.urlopen(request, timeout=60.0) as answer:
            return json.loads(answer.read())["value"]

    def open(self, address: str) -> None:
        """Open a page."""
        self._ask("/url", {"url": address})

    def run(self, script: str) -> Any:
        """Return what a script on the page returns."""
        return self._ask("/execute/sync", {"script": script, "args": []})

    def close(self) -> None:
        """End it."""
        with urllib.request.urlopen(urllib.request.Request(self._base, method="DELETE"), timeout=60.0):
            pass
        self._driver.terminate()
        self._driver.wait()


def wait_for(condition: Any, what: str, longest: float = 60.0) -> Any:
    """Return what a condition says as soon as it says anything."""
    end = time.monotonic() + longest
    while not (said := condition()):
        if time.monotonic() > end:
            raise SystemExit(f"not within {longest:g} s: {what}")
        time.sleep(0.02)
    return said


@contextmanager
def served(folder: Path) -> Iterator[tuple[str, int]]:
    """Serve a run's folder from a process of its own; yield its address and process number."""
    command = [*CLI, "watch", str(folder), "--no-open"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    try:
        yield process.stderr.readline().split()[1], process.pid
    finally:
        process.terminate()
        process.wait()


def processor_seconds(pid: int) -> float:
    """Return the processor time that a process has used so far [s]."""
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def first_paints(browser: Browser, folder: Path) -> tuple[list[float], list[float]]:
    """Return the times [s] until something is painted, and until state, picture and plan are there."""
    painted, whole = [], []
    with served(folder) as (address, _):
        for _ in range(LOADS):
            browser.open("about:blank")
            browser.open(address)
            whole.append(1e-3 * wait_for(lambda: browser.run(SHOWN), "the page shows a state"))
            painted.append(1e-3 * wait_for(lambda: browser.run(PAINT), "the first paint")[0])
    return painted, whole


def busy_run(browser: Browser, run: Path, folder: Path, seconds: float) -> tuple[float, int, int]:
    """Write a run's events at `RATE` into `folder`; return the server's share of a core, events written and shown."""
    lines = (run / JOURNAL_NAME).read_bytes().splitlines(keepends=True)
    kept = json.loads((run / CHECKPOINT_NAME).read_bytes())["gallery"]
    shutil.copytree(run / "frames", folder / "frames")
    shutil.copy(run / AREA_NAME, folder / AREA_NAME)
    (folder / JOURNAL_NAME).write_bytes(lines[0])
    with served(folder) as (address, pid):
        browser.open(address)
        wait_for(lambda: browser.run(SHOWN), "the page shows a state")
        time.sleep(1.0)
        used, begin, written = processor_seconds(pid), time.monotonic(), 1
        while (now := time.monotonic() - begin) < seconds:
            time.sleep(max(written / RATE - now, 0.0))
            event = json.loads(lines[written % len(lines)]) | {"seq": written, "time": written / RATE}
            gallery = [
                kept[number % len(kept)] | {"time": number / RATE}
                for number in range(max(written - KEPT, 0), written + 1)
            ]
            write_atomically(folder / CHECKPOINT_NAME, json.dumps({"gallery": gallery}).encode())
            with (folder / JOURNAL_NAME).open("ab") as journal:
                journal.write(json.dumps(event).encode() + b"\n")
            written += 1
        share = (processor_seconds(pid) - used) / (time.monotonic() - begin)
        wait_for(lambda: browser.run("return page.events.length") == written, "the page has all events")
        return share, written, browser.run("return page.at") + 1


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=30.0)
    parser.add_argument("--run", type=Path, help="a run's --out folder (default: full_calibration, run now)")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        run = given.run or Path(scratch) / "run"
        if given.run is None:
            subprocess.run(
                [*CLI, "run", "full_calibration", "--out", str(run)], check=True, capture_output=True
            )
        folder = Path(scratch) / "live"
        folder.mkdir()
        browser = Browser()
        try:
            painted, whole = first_paints(browser, run)
            share, written, shown = busy_run(browser, run, folder, given.seconds)
        finally:
            browser.close()
    print(f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    for name, times in (("first paint", painted), ("state and picture there", whole)):
        print(f"{name}: median {statistics.median(times):.2f} s, longest {max(times):.2f} s of {LOADS}")
    print(f"{RATE:g} events/s with frames for {given.seconds:g} s: server {100 * share:.1f} % of a core;")
    print(f"{written} events written, the page stands at the {shown}th")


if __name__ == "__main__":
    main()
