"""Make sealed robots of foreign physics.

    python benchmarks/foreign/generate.py --seed 1 --robots 60 --out DIR [--engine mixed] [--jobs 2]

DIR/robot-000/{run-a,run-b,run-h} are recordings `fsm-calib/recording@1`, DIR/keys.json says what is true of each.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import multiprocessing
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from foreign import laws_body, laws_command, laws_floor, laws_motor, laws_sensing, outside
from foreign.catalogue import LAWS, PLACED, TIMED
from foreign.sealed import Order, make

MODULES = (laws_body, laws_command, laws_floor, laws_motor, laws_sensing, outside)
FAMILIES = {
    "plain": 0.42,
    "faint": 0.20,
    "masked": 0.04,
    "clean": 0.10,
    "outside": 0.10,
    "pair": 0.09,
    "triple": 0.05,
}
LABELS = tuple(sorted(name for name in LAWS if name != "outside"))
SENSING = {"observation_delay", "sensor_offset", "sensor_yaw", "clock_drift", "misplaced_marker"}
SAME_HAND = (
    {"command_delay", "observation_delay", "clock_drift"},
    PLACED,
    TIMED,
    {"motor_deadband", "coulomb_friction", "motor_gain_curve"},
)


def together(labels: list[str]) -> bool:
    """Return whether effects may be drawn together: not two of one kind, which nobody could tell apart."""
    return len(set(labels)) == len(labels) and all(len(group & set(labels)) < 2 for group in SAME_HAND)


def orders(seed: int, count: int, engine: str) -> list[Order]:
    """Return what each robot shall be; labels go round, so that each occurs about equally often."""
    rng = np.random.default_rng(seed)
    families = [f for f, share in FAMILIES.items() for _ in range(round(share * count))]
    families = (families + ["plain"] * count)[:count]
    rng.shuffle(families)
    bag: list[str] = []
    out = []
    for k, family in enumerate(families):
        wanted = {"clean": 0, "outside": 0, "pair": 2, "triple": 3}.get(family, 1)
        labels: list[str] = []
        while len(labels) < wanted:
            bag = bag or [str(x) for x in rng.permutation(LABELS)]
            label = next((x for x in bag if together([*labels, x])), None)
            if label is None:
                bag += [str(x) for x in rng.permutation(LABELS)]
                continue
            bag.remove(label)
            labels.append(label)
        if family == "outside":
            labels = ["outside"]
        kind = (
            engine
            if engine != "mixed"
            else ("planar", "planar", "mujoco", "planar", "planar", "pybullet")[k % 6 if count > 5 else 0]
        )
        if any(not any(kind in item.engines for item in LAWS[label]) for label in labels):
            kind = "planar"
        out.append(Order(f"robot-{k:03d}", family, tuple(labels), kind, int(rng.integers(2**31))))
    return with_masses(out, seed) if engine == "drake" else out


def with_masses(wanted: list[Order], seed: int) -> list[Order]:
    """Give robots in Drake their masses: its three kinds take turns."""
    from foreign.drake_engine import draw_mass

    rng = np.random.default_rng([seed, 3])
    return [dataclasses.replace(order, mass=draw_mass(rng, k)) for k, order in enumerate(wanted)]


def job(task: tuple[Order, Path]) -> dict:
    """Make one robot and keep its key beside the keys, so that a stopped run goes on."""
    order, folder = task
    path = folder / ".keys" / f"{order.name}.json"
    if path.exists():
        return json.loads(path.read_text())
    start = time.perf_counter()
    try:
        key = make(order, folder)
    except RuntimeError as error:
        print(error, file=sys.stderr)
        return {}
    path.write_text(json.dumps(key))
    what = " + ".join(f"{e['label']}/{e['law']} {e['ratio']:.2f}" for e in key["effects"]) or "clean"
    print(
        f"{order.name} {order.family:8s}{order.engine:9s}{what}  ({time.perf_counter() - start:.0f} s)",
        file=sys.stderr,
    )
    return key


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--robots", type=int, default=60)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument(
        "--engine", default="mixed", choices=["planar", "mujoco", "pybullet", "drake", "mixed"]
    )
    parser.add_argument("--jobs", type=int, default=1)
    args = parser.parse_args()
    (args.out / ".keys").mkdir(parents=True, exist_ok=True)
    tasks = [(order, args.out) for order in orders(args.seed, args.robots, args.engine)]
    if args.jobs > 1:
        with multiprocessing.get_context("spawn").Pool(args.jobs) as pool:
            keys = pool.map(job, tasks, chunksize=1)
    else:
        keys = [job(task) for task in tasks]
    (args.out / "keys.json").write_text(json.dumps([key for key in keys if key], indent=1) + "\n")


if __name__ == "__main__":
    main()
