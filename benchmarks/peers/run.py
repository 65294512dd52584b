"""Ours and its peers on the same concealed robots, in one run and one table.

    python -m pip install pysindy scikit-learn                                       # development only
    python benchmarks/concealed/generate.py build/peers --robots 40 --seed 77 --open
    python benchmarks/peers/run.py build/peers

Resumable: answers go to OUT/peers.jsonl, one line for each robot and method. Errors are medians over the same 2 s
windows of the drive that nobody fitted, divided by the floor that the diagnosis' noise alone would give there; seconds
are processor time of one core.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from statistics import median

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from peers.data import Track, Windows, error_of, read_track, windows_of
from peers.methods import PEERS, predict
from peers.ours import BASE, OURS, answers, new_drive, shared

DELAYS = {"command_delay", "observation_delay"}


def answer(folder: Path, peer: str, new: Track, windows: Windows) -> dict:
    """Let one peer work on one robot."""
    started = time.process_time()
    train = [read_track(folder / run) for run in ("run-a", "run-b")]
    said = PEERS[peer](train)
    seconds = time.process_time() - started
    xy, theta = error_of(predict(new, windows, said.rates), windows)
    return {
        "robot": folder.name, "peer": peer, "name": said.name, "xy_m": xy, "theta_rad": theta, "seconds": seconds
    }  # fmt: skip


def work(folder: Path, done: set[str]) -> Iterator[dict]:
    """Let everybody who is not done work on one robot."""
    new = read_track(folder / "run-h")
    windows, *places = shared(new, windows_of(new), new_drive(folder / "run-h"))
    if OURS not in done:
        yield from answers(folder, (places[0], places[1]))
    for peer in PEERS:
        if peer not in done:
            yield answer(folder, peer, new, windows)


def is_right(label: str, names: set[str]) -> bool:
    """Tell whether the label, or one name of a pair, was said; the two delays count as one for everybody."""
    wanted = set(label.split("+"))
    return bool((wanted | DELAYS if wanted & DELAYS else wanted) & names)


def share(hits: list[bool]) -> str:
    """Return a share with its counts."""
    return f"{100 * sum(hits) / len(hits):.0f} % ({sum(hits)}/{len(hits)})" if hits else "-"


def row(peer: str, lines: list[dict], labels: dict[str, str], floors: dict[str, dict]) -> str:
    """Return one row of the table."""
    named = {
        line["robot"]: set(line.get("names") or ([line["name"]] if line.get("name") else []))
        for line in lines
    }
    single = [r for r in named if labels[r] != "none" and ":" not in labels[r] and "+" not in labels[r]]
    outside = [line for line in lines if ":" in labels[line["robot"]]]
    ratios = []
    for channel in ("xy_m", "theta_rad"):
        found = [line[channel] / floors[line["robot"]][channel] for line in lines if line.get(channel)]
        ratios.append(f"{median(found):.2f}" if found else "-")
    cells = [
        share([is_right(labels[r], named[r]) for r in single]),
        share([bool(named[r]) for r in named if labels[r] == "none"]),
        share([line.get("verdict") == "unexplained" for line in outside]),
        *ratios,
        "part of ours" if lines[0]["peer"] == BASE else f"{median([line['seconds'] for line in lines]):.1f}",
    ]
    return f"| {peer} | {' | '.join(cells)} |"


def floors_of(lines: list[dict]) -> dict[str, dict]:
    """Return the floor of each robot, as the diagnosis states it."""
    return {line["robot"]: line["floor"] for line in lines if line["peer"] == OURS}


def main() -> None:
    """Run what is missing and print the table over the robots that everybody has done."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("--robots", type=int, default=10_000, help="at most so many")
    arguments = parser.parse_args()
    key = json.loads((arguments.out / "key.json").read_text())[: arguments.robots]
    labels = {line["name"]: line["label"] for line in key if not line["poor"]}
    store = arguments.out / "peers.jsonl"
    lines = [json.loads(text) for text in store.read_text().splitlines()] if store.exists() else []
    for robot in labels:
        done = {line["peer"] for line in lines if line["robot"] == robot}
        for line in work(arguments.out / "robots" / robot, done):
            lines.append(line)
            with store.open("a") as stream:
                stream.write(json.dumps(line) + "\n")
            named = line.get("names") or ([line["name"]] if line.get("name") else [])
            print(f"{robot} {line['peer']}: {', '.join(named) or 'nothing'}", file=sys.stderr, flush=True)
    lines = [line for line in lines if line["robot"] in labels]
    floors = floors_of(lines)
    print(
        "| method | right name | a name for clean | unexplained outside | xy / floor | heading / floor | s |"
    )
    print("|---|---|---|---|---|---|---|")
    for peer in (BASE, *PEERS, OURS):
        mine = [line for line in lines if line["peer"] == peer]
        if mine:
            print(row(f"{peer} ({len(mine)} robots)", mine, labels, floors))


if __name__ == "__main__":
    main()
