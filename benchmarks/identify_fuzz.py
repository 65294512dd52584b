"""Feeds damaged manifests and CSV files to the reader and to `identify`; every answer must be a sentence.

    python benchmarks/identify_fuzz.py [--cases 10000] [--seed 0]

Prints how many cases were read, how many were refused with a sentence, and every traceback (there must be none).
"""

from __future__ import annotations

import argparse
import gzip
import random
import tempfile
import traceback
from collections import Counter
from pathlib import Path

from fsm_calib.diagnosis.identify.identify import identify
from fsm_calib.errors import DataError, FsmCalibError
from fsm_calib.recording import read_recording

MANIFEST = """format: fsm-calib/recording@1
robot: {name: fuzzed, wheel_radius: 0.0318, axle_length: 0.1, max_wheel_rate: 20.0}
channels:
  command: {file: command.csv, time: t, left: left, right: right, unit: normalized, stale_after: 0.5}
  pose: {file: pose.csv.gz, time: t, x: x, y: y, theta: theta, length_unit: 1.0}
  wheel_angle: {file: angle.csv, time: t, left: left, right: right, unit: tick, ticks_per_turn: 135}
  state: {file: state.csv, time: t, state: state}
"""
NASTY = (
    "nan", "inf", "-inf", "", " ", "abc", "1e999", "1e-3", "0x10", "1_000", "-", "\x00", "\t", ";", "\"", "'", "{", "}",
    "[", "]", ":", "- ", "&a [*a]", "*a", "!!python/object:os.system", "~", "null", "true", "\n", "\r", "\r\n", ",,,,",
    "#", "%", "@", "`", "| ", "> ", "\ufeff", "\u2028", "é", "日", "1" * 400, "9" * 30, "-0", "1.5.2", "../x.csv", "/",
)  # fmt: skip


def files(rng: random.Random) -> dict[str, str]:
    """Return a small sound recording."""
    rows = 12
    time = [0.1 * i for i in range(rows)]
    command = "t,left,right\n" + "".join(f"{t},{rng.random():.3f},{rng.random():.3f}\n" for t in time)
    pose = "t,x,y,theta\n" + "".join(f"{t},{0.1 * t:.4f},{0.02 * t:.4f},{0.2:.4f}\n" for t in time)
    angle = "t,left,right\n" + "".join(f"{t},{i},{2 * i}\n" for i, t in enumerate(time))
    state = "t,state\n0.0,standing\n0.5,driving.forward\n"
    return {
        "recording.yaml": MANIFEST, "command.csv": command, "pose.csv.gz": pose, "angle.csv": angle, "state.csv": state
    }  # fmt: skip


def damage(text: str, rng: random.Random) -> str:
    """Return `text` with one kind of damage."""
    kind = rng.randrange(8)
    i, j = sorted((rng.randrange(len(text) + 1), rng.randrange(len(text) + 1)))
    if kind == 0:
        return text[:i]
    if kind == 1:
        return text[:i] + text[j:]
    if kind == 2:
        return text[:i] + rng.choice(NASTY) + text[i:]
    if kind == 3:
        return text[:i] + text[i:j] * 2 + text[j:]
    if kind == 4:
        lines = text.split("\n")
        rng.shuffle(lines)
        return "\n".join(lines)
    if kind == 5:
        words = text.replace("\n", " \n ").split(" ")
        words[rng.randrange(len(words))] = rng.choice(NASTY)
        return " ".join(words)
    if kind == 6:
        cells = [line.split(",") for line in text.split("\n")]
        row = rng.choice(cells)
        row[rng.randrange(len(row))] = rng.choice(NASTY)
        return "\n".join(",".join(line) for line in cells)
    return "".join(chr(rng.randrange(1, 0x250)) if rng.random() < 0.02 else c for c in text)


def write_case(folder: Path, rng: random.Random) -> None:
    """Write a recording with one to three damaged files; sometimes bytes are damaged after packing."""
    contents = files(rng)
    for _ in range(rng.choice((1, 1, 1, 2))):
        name = rng.choice(list(contents))
        contents[name] = damage(contents[name], rng)
    if rng.random() < 0.05:
        del contents[rng.choice([name for name in contents if name != "recording.yaml"])]
    for name, text in contents.items():
        data = text.encode("utf-8", "surrogatepass")
        data = gzip.compress(data) if name.endswith(".gz") else data
        if rng.random() < 0.05 and data:
            data = damage_bytes(data, rng)
        (folder / name).write_bytes(data)


def damage_bytes(data: bytes, rng: random.Random) -> bytes:
    """Return bytes cut short or with one byte changed."""
    i = rng.randrange(len(data))
    return data[:i] if rng.random() < 0.5 else data[:i] + bytes([rng.randrange(256)]) + data[i + 1 :]


def run(cases: int, seed: int) -> Counter[str]:
    """Feed `cases` damaged recordings to the reader; return how often it read, refused or failed."""
    found: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for case in range(cases):
            rng = random.Random(f"{seed}/{case}")
            for file in folder.iterdir():
                file.unlink()
            write_case(folder, rng)
            try:
                recording = read_recording(folder / "recording.yaml")
                found["read"] += 1
                identify([recording])
            except DataError:
                found["too little to fit"] += 1
            except FsmCalibError as error:
                found["refused"] += 1
                found["without a place"] += "recording.yaml:" not in str(error) and ".csv" not in str(error)
            except Exception:  # what this benchmark looks for
                found["traceback"] += 1
                print(f"case {case} of seed {seed}")
                traceback.print_exc()
    return found


def main() -> None:
    """Read the arguments and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    for key, count in sorted(run(arguments.cases, arguments.seed).items()):
        print(f"{key:16s} {count}")


if __name__ == "__main__":
    main()
