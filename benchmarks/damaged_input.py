"""Damaged recordings given to `fsm-calib identify` and `fsm-calib diagnose` as a user would give them.

    python benchmarks/damaged_input.py

For each kind of damage: the exit code (2 is right), the number of lines on standard error (1 is right), whether a file
was written (none is right), and the line itself. Ends with exit code 1 if one of them is not right.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from fsm_calib.recording import CommandTrack, PoseTrack, Recording, RobotFacts
from fsm_calib.recording.writers import write_bag, write_recording

ENDLESS = 2 << 30  # bytes of the line without end
COMMANDS = ("identify", "diagnose")


def drive() -> Recording:
    """Return a sound drive of 20 s along a slalom."""
    time = np.arange(0.0, 20.0, 0.05)
    heading = 0.8 * np.sin(time)
    x, y = np.cumsum(0.01 * np.cos(heading)), np.cumsum(0.01 * np.sin(heading))
    command = CommandTrack(time, 0.3 - 0.1 * np.cos(time), 0.3 + 0.1 * np.cos(time))
    return Recording(
        RobotFacts("sound", 0.0318, 0.1, 20.0), command=command, pose=PoseTrack(time, x, y, heading)
    )


def edited(change: Callable[[list[str]], list[str]]) -> Callable[[Path], Path]:
    """Return damage that rewrites the lines of the table of poses."""

    def apply(folder: Path) -> Path:
        manifest = write_recording(drive(), folder, compress=False)
        table = folder / "pose.csv"
        table.write_text("\n".join(change(table.read_text().splitlines())) + "\n")
        return manifest

    return apply


def with_cell(lines: list[str], row: int, column: int, word: str) -> list[str]:
    """Return the lines with one cell replaced."""
    cells = lines[row].split(",")
    cells[column] = word
    return [*lines[:row], ",".join(cells), *lines[row + 1 :]]


def with_text_column(lines: list[str]) -> list[str]:
    """Return the lines with words in the column of headings."""
    return [lines[0]] + [line.rsplit(",", 1)[0] + ",north" for line in lines[1:]]


def cut_bag(name: str) -> Callable[[Path], Path]:
    """Return damage that cuts a bag short by a third."""

    def apply(folder: Path) -> Path:
        folder.mkdir()
        path = write_bag(drive(), folder / name)
        file = path if path.is_file() else next(path.glob("*.mcap"))
        file.write_bytes(file.read_bytes()[: 2 * file.stat().st_size // 3])
        return file

    return apply


def without_table(folder: Path) -> Path:
    """Remove the table of commands."""
    manifest = write_recording(drive(), folder, compress=False)
    (folder / "command.csv").unlink()
    return manifest


def endless_line(folder: Path) -> Path:
    """Replace the table of poses by two sound lines and one that goes on for 2 GB."""
    manifest = write_recording(drive(), folder, compress=False)
    head = b"\n".join((folder / "pose.csv").read_bytes().split(b"\n")[:2])
    with (folder / "pose.csv").open("wb") as stream:
        stream.write(head + b"\n")
        for _ in range(ENDLESS >> 24):
            stream.write(b"1" * (1 << 24))
    return manifest


DAMAGE: dict[str, Callable[[Path], Path]] = {
    "truncated ROS 1 bag": cut_bag("drive.bag"),
    "truncated MCAP": cut_bag("drive"),
    "empty CSV": edited(lambda _: []),
    "CSV of a header alone": edited(lambda lines: lines[:1]),
    "NaN": edited(lambda lines: with_cell(lines, 7, 1, "nan")),
    "swapped columns (x and theta)": edited(lambda lines: ["time,theta,y,x", *lines[1:]]),
    "swapped columns (time and x)": edited(lambda lines: ["x,time,y,theta", *lines[1:]]),
    "missing table": without_table,
    "missing recording": lambda folder: folder / "nothing.yaml",
    "2 GB line": endless_line,
    "column of text": edited(with_text_column),
}


def judge(command: str, damage: str, folder: Path) -> bool:
    """Run one command on one damaged recording, print what came, return whether it was right."""
    recording = DAMAGE[damage](folder / "recording")
    out = folder / "out"
    out.mkdir()
    program = str(Path(sys.executable).parent / "fsm-calib")
    call = [program, command, str(recording), "--json", str(out / "result.json")]
    if command == "diagnose":
        call += ["--world", str(out / "world.yaml"), "--report", str(out / "report")]
    done = subprocess.run(call, capture_output=True, text=True, cwd=out, check=False)
    lines = done.stderr.strip().splitlines()
    written = [path.name for path in out.rglob("*")]
    right = done.returncode == 2 and len(lines) == 1 and not done.stdout and not written
    said = lines[0].replace(f"{folder}/", "") if lines else "nothing"
    print(
        f"| {command} | {damage} | {done.returncode} | {len(lines)} | {len(written)} | {said} |", flush=True
    )
    return right


def main() -> None:
    """Print the table."""
    print("| command | damage | exit | lines | files | said |\n|---|---|---|---|---|---|")
    right = []
    for damage in DAMAGE:
        for command in COMMANDS:
            with tempfile.TemporaryDirectory() as name:
                right.append(judge(command, damage, Path(name)))
    print(f"\n{sum(right)} of {len(right)} answered with one line, exit code 2, and nothing written")
    sys.exit(0 if all(right) else 1)


if __name__ == "__main__":
    main()
