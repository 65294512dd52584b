"""Whatever fails, in whichever phase: when does the wheel driver have its zero? `python3 benchmarks/guard_table.py`.

A served robot drives in real time behind Debian's rosmaster (the project's own where there is none), and `fsm-calib run`, a
process of its own with its guard, calibrates it in one phase. At a random moment in which the wheels turn something fails,
and the driver's clock tells when it received the last zero: how long after the failure, and whether the wheels stand a
second later. Every cell is a fresh robot, program, guard and master. Cells are kept in ``--out`` (JSON lines) as they end; a
second call goes on where the first one ended, and ``--print`` prints the table of what is there. About ten seconds a cell.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from kept_rows import kept_rows

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))
from ros_rig import answers, free_port, until

from fsm_calib.perception.encoded import encode_jpeg
from fsm_calib.robots.ros1.messages import BOOL, WHEELS, message_type
from fsm_calib.robots.ros1.node import Node
from fsm_calib.robots.ros1.served_node import ServedNode
from fsm_calib.robots.served.settings import ServeSettings
from fsm_calib.scenario.load import load_scenario
from fsm_calib.scenario.world import world_of
from fsm_calib.types import STOP, WheelCommand
from fsm_calib.world2d.robot import make_world

LIMIT = 0.3
"""What the wheels may take to stand [s]."""
AFTER = 1.0
"""The wheels must still stand this long after their last zero [s]."""
PHASES = ("scan", "orientation", "wheels", "exit", "lane")
"""The phases in which wheels turn: `focus` only looks."""
SCENARIO = """name: guard
seed: {seed}
robot: {{source: fleet, name: duckie{start}}}
plan: [{phase}]
output: {{report: false, recording: false, bag: none, frames: 0}}
"""


class Driver:
    """What the wheel driver of a served robot receives, and when."""

    def __init__(self, node: ServedNode) -> None:
        self.node, self.is_moving, self.changed = node, False, time.monotonic()
        self._take = node.station.take
        node.station.take = self.take  # type: ignore[method-assign]

    def take(self, command: WheelCommand) -> None:
        if (command != STOP) != self.is_moving:
            self.is_moving, self.changed = command != STOP, time.monotonic()
        self._take(command)


class Cell:
    """One robot with its master, and the program that calibrates it."""

    def __init__(self, phase: str, seed: int, folder: Path) -> None:
        file, start = folder / "scenario.yaml", ", start_in_lane: 0.0" if phase == "lane" else ""
        file.write_text(SCENARIO.format(seed=seed, phase=phase, start=start))
        scenario, port = load_scenario(file), free_port()
        self.master = start_master(port)
        self.url = f"http://127.0.0.1:{port}/"
        until(lambda: answers(self.url), "the master answers")
        world = make_world(world_of(scenario))
        self.node = ServedNode(world, ServeSettings(), self.url, "duckie", encode_jpeg)
        self.driver, self.bystander = Driver(self.node), Node("/bystander", self.url)
        self.button = self.bystander.publish(self.node.topics.estop, BOOL)
        self.out = folder / "run"
        options = ["--robot", f"ros1://127.0.0.1:{port}/duckie", "--yes", "--out", str(self.out)]
        self.program = subprocess.Popen(
            [sys.executable, "-m", "fsm_calib.cli", "run", str(file), *options],
            stdout=subprocess.DEVNULL,
            stderr=(folder / "errors.txt").open("w"),
            start_new_session=True,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL) and None,
        )

    @property
    def guard(self) -> int:
        """The process number of the program's guard."""
        for entry in Path("/proc").iterdir():
            with contextlib.suppress(OSError, ValueError):
                status = (entry / "status").read_text()
                if (
                    f"PPid:\t{self.program.pid}\n" in status
                    and b"guard.process" in (entry / "cmdline").read_bytes()
                ):
                    return int(entry.name)
        raise RuntimeError("the program has no guard")

    def close(self) -> None:
        guards = []
        with contextlib.suppress(RuntimeError):
            guards.append(self.guard)
        for pid in (self.program.pid, *guards):
            for number in (signal.SIGCONT, signal.SIGKILL):
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, number)
        self.program.wait()
        self.master.kill()
        self.master.wait()
        for node in (self.bystander, self.node):
            with contextlib.suppress(Exception):  # its master is gone
                node.close()


def start_master(port: int) -> subprocess.Popen[bytes]:
    """Start a ROS master in a process of its own."""
    if shutil.which("rosmaster"):
        command = ["rosmaster", "--core", "-p", str(port)]
    else:
        text = f"from fsm_calib.robots.ros1.master import Master; Master('127.0.0.1', {port}); input()"
        command = [sys.executable, "-c", text]
    return subprocess.Popen(
        command,
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )


def press(cell: Cell) -> None:
    """Press the emergency stop."""
    pressed = message_type(BOOL).stamped(0.0, data=True)
    until(lambda: cell.button.publish(pressed), "the guard hears the button")


def drive_it_too(cell: Cell) -> None:
    """Have another node push the wheels once."""
    stick = cell.bystander.publish(cell.node.topics.wheels, WHEELS)
    pushed = message_type(WHEELS).stamped(0.0, vel_left=0.5, vel_right=-0.5)
    until(lambda: stick.publish(pushed), "the driver hears the joystick")


def deafen(cell: Cell) -> None:
    """Cut the way back: no acknowledgement of a wheel command arrives any more."""
    cell.node.executed = lambda command, number, time: None  # type: ignore[method-assign]


FAILURES: dict[str, Callable[[Cell], object]] = {
    "Ctrl-C": lambda cell: cell.program.send_signal(signal.SIGINT),
    "SIGTERM": lambda cell: cell.program.send_signal(signal.SIGTERM),
    "SIGKILL": lambda cell: cell.program.kill(),
    "SIGSTOP": lambda cell: cell.program.send_signal(signal.SIGSTOP),
    "guard SIGTERM": lambda cell: os.kill(cell.guard, signal.SIGTERM),
    "guard SIGKILL": lambda cell: os.kill(cell.guard, signal.SIGKILL),
    "guard SIGSTOP": lambda cell: os.kill(cell.guard, signal.SIGSTOP),
    "roscore killed": lambda cell: cell.master.kill(),
    "emergency stop": press,
    "foreign command": drive_it_too,
    "link back cut": deafen,
}


@contextmanager
def prepared(phase: str, seed: int) -> Iterator[Cell]:
    with tempfile.TemporaryDirectory() as name:
        cell = Cell(phase, seed, Path(name))
        try:
            yield cell
        finally:
            cell.close()


def attempt(phase: str, failure: str, seed: int) -> dict:
    """Let something fail in a phase while the wheels turn, and return when they stood; in the first push where the phase
    ends before the one that was drawn.
    """
    rng = np.random.default_rng([seed, PHASES.index(phase), list(FAILURES).index(failure)])
    try:
        return stopped(phase, failure, seed, int(rng.integers(1, 4)), rng)
    except pytest.fail.Exception:
        return stopped(phase, failure, seed, 1, rng)


def stopped(phase: str, failure: str, seed: int, pushes: int, rng: np.random.Generator) -> dict:
    """Let something fail in the last of so many pushes; return when the wheels stood."""
    with prepared(phase, seed) as cell:
        for _ in range(pushes):
            until(lambda: cell.driver.is_moving, "the wheels turn", deadline=60.0)
            pause = cell.driver.changed + float(rng.uniform(0.0, 0.3))
            until(lambda pause=pause: time.monotonic() > pause, "a moment passes")
        until(lambda: cell.driver.is_moving, "the wheels turn", deadline=60.0)
        began = time.monotonic()
        FAILURES[failure](cell)
        until(
            lambda: not cell.driver.is_moving and time.monotonic() > cell.driver.changed + AFTER,
            "",
            deadline=20.0,
        )
        row = {
            "phase": phase,
            "failure": failure,
            "seed": seed,
            "seconds": max(cell.driver.changed - began, 0.0),
            "stands": not cell.driver.is_moving,
            "load": os.getloadavg()[0],
        }
        with contextlib.suppress(subprocess.TimeoutExpired):
            row["exit"] = cell.program.wait(5.0)
        with contextlib.suppress(OSError, ValueError):
            result = json.loads((cell.out / "result.json").read_text())
            row["outcome"], row["lost"] = result["outcome"], (result.get("lost") or {}).get("name", "")
    return row


def print_table(rows: list[dict]) -> None:
    """Print the longest time of each cell [s], as a table of Markdown."""
    print("| what fails | " + " | ".join(PHASES) + " | told as |")
    print("|---" * (len(PHASES) + 2) + "|")
    for failure in FAILURES:
        cells, told = [], set()
        for phase in PHASES:
            of = [row for row in rows if (row["phase"], row["failure"]) == (phase, failure)]
            told |= {row.get("lost") or row.get("outcome", "") for row in of} - {""}
            cells.append(f"{max(row['seconds'] for row in of):.2f}" if of else "")
            if not all(row["stands"] for row in of):
                cells[-1] = "TURN"
        print(f"| {failure} | " + " | ".join(cells) + f" | {', '.join(sorted(told)) or '-'} |")
    late = [row for row in rows if row["seconds"] > LIMIT or not row["stands"]]
    print(
        f"{len(rows)} stops, {len(rows) - len(late)} within {LIMIT} s; all stand: {all(row['stands'] for row in rows)}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/guard.jsonl"))
    parser.add_argument("--seeds", type=int, default=1, help="attempts of each cell")
    parser.add_argument("--print", action="store_true", dest="is_only_printed")
    given = parser.parse_args()
    given.out.parent.mkdir(parents=True, exist_ok=True)
    rows = kept_rows(given.out)
    known = {(row["seed"], row["phase"], row["failure"]) for row in rows}
    for seed in range(1, given.seeds + 1):
        for phase in PHASES:
            for failure in FAILURES:
                if given.is_only_printed or (seed, phase, failure) in known:
                    continue
                rows.append(attempt(phase, failure, seed))
                print(json.dumps(rows[-1]), file=sys.stderr, flush=True)
                with given.out.open("a") as file:
                    file.write(json.dumps(rows[-1]) + "\n")
    print_table(rows)


if __name__ == "__main__":
    main()
