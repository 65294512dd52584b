"""Ours and its peers on the same concealed robots, in one table.

    python -m pip install pysindy scikit-learn                                       # development only
    python benchmarks/concealed/generate.py build/peers --robots 40 --seed 77 --open
    python benchmarks/concealed/run.py build/peers --jobs 1                          # ours
    python benchmarks/peers/run.py build/peers                                       # the peers, and the table

Resumable: answers go to OUT/peers.jsonl, one line for each robot and peer. Errors are medians over 2 s windows of the
drive that nobody fitted, divided by the floor that `fsm-calib diagnose` states for it; where it has not yet diagnosed
a robot, the smallest error of any method stands in for the floor.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from statistics import median

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from concealed.score import first_names

from peers.data import error_of, read_track, windows_of
from peers.methods import PEERS, predict

DELAYS = {"command_delay", "observation_delay"}
OURS = "fsm-calib diagnose"
BASE = "base re-fitted by likelihood"


def answer(folder: Path, peer: str) -> dict:
    """Let one peer work on one robot."""
    started = time.process_time()
    train = [read_track(folder / run) for run in ("run-a", "run-b")]
    said = PEERS[peer](train)
    seconds = time.process_time() - started
    new = read_track(folder / "run-h")
    windows = windows_of(new)
    xy, theta = error_of(predict(new, windows, said.rates), windows)
    return {
        "robot": folder.name, "peer": peer, "name": said.name, "xy_m": xy, "theta_rad": theta, "seconds": seconds
    }  # fmt: skip


def ours(out: Path, robot: str) -> list[dict]:
    """Return our verdict, and the base that it re-fitted first, as lines of peers; none while there is no verdict."""
    file = out / "verdicts" / f"{robot}.json"
    if not file.exists():
        return []
    verdict = json.loads(file.read_text())
    holdout = (verdict.get("fit") or {}).get("holdout") or {}
    parts, before, after = verdict.get("seconds_by_part") or {}, holdout.get("before"), holdout.get("after")
    common = {"robot": robot, "floor": holdout.get("floor") or {}}
    mine = {
        "names": sorted(first_names(verdict)),
        "verdict": verdict["verdict"],
        "seconds": verdict.get("seconds"),
    }
    base = {"names": [], "seconds": parts.get("base")}
    return [
        {**common, **base, "peer": BASE, **(before or {})},
        {**common, **mine, "peer": OURS, **(after or {})},
    ]


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
        f"{median([line['seconds'] or 0.0 for line in lines]):.1f}",
    ]
    return f"| {peer} | {' | '.join(cells)} |"


def floors_of(lines: list[dict]) -> dict[str, dict]:
    """Return the floor of each robot: ours as stated, else the smallest error anybody made."""
    floors: dict[str, dict] = {}
    for robot in {line["robot"] for line in lines}:
        mine = [line for line in lines if line["robot"] == robot]
        stated = next((line["floor"] for line in mine if line.get("floor")), {})
        least = {key: min(line[key] for line in mine if line.get(key)) for key in ("xy_m", "theta_rad")}
        floors[robot] = {key: stated.get(key) or least[key] for key in least}
    return floors


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
    done = {(line["robot"], line["peer"]) for line in lines}
    for robot in labels:
        for peer in PEERS:
            if (robot, peer) in done:
                continue
            line = answer(arguments.out / "robots" / robot, peer)
            lines.append(line)
            with store.open("a") as stream:
                stream.write(json.dumps(line) + "\n")
            print(f"{robot} {peer}: {line['name'] or 'nothing'}", file=sys.stderr, flush=True)
    lines = [line for line in lines if line["robot"] in labels]
    lines += [line for robot in labels for line in ours(arguments.out, robot)]
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
