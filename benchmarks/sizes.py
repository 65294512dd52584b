"""Robots of 0.5, 20 and 300 kg, of foreign physics, whose mass and inertia are stated: is each told in its own size?

    python benchmarks/sizes.py --out DIR [--masses 0.5,20,300] [--labels clean,payload_offset,...] [--engine planar] [--seed 1]

The robots are those of `benchmarks/foreign` (textbook physics written blind to this program; planar, MuJoCo or Bullet)
with their mass fixed and no small departures beside the label. Each is diagnosed on two drives and held against a
third; printed: the verdict, what is named with its numbers, the error over 2 s on the third drive (base, with the
effects, noise alone), what a warning says of a number at its bound. Robots and answers stay in DIR; a stopped run goes on.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path

from foreign import generate
from foreign.sealed import RUNS, Order

from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.recording import read_recording

LAW = {"payload_offset": "behind", "tyre_scrub": "dry_moment", "command_delay": "delay_constant"}
"""The law of a label, where it has several; others are drawn."""


def robot(folder: Path, label: str, mass: float, engine: str, seed: int) -> Path:
    """Make one robot below `folder`; return its folder. The key lies beside it."""
    name = f"{label}-{mass:g}"
    path = folder / f"{name}.key.json"
    if not path.exists():
        labels, family = ((), "clean") if label == "clean" else ((label,), "plain")
        law = LAW.get(label, "")
        order = Order(name, family, labels, engine, seed, law, mass, states_mass=True)
        path.write_text(json.dumps(generate.make(order, folder)))
    return folder / name


def answer(folder: Path) -> dict:
    """Return what `diagnose` says of a robot."""
    path = folder / "answer.json"
    if not path.exists():
        *train, held = (read_recording(folder / run) for run in RUNS)
        began = time.process_time()
        found = diagnose(train, [held])
        told = found.verdict.as_json() | {"notes": found.notes, "processor_s": time.process_time() - began}
        path.write_text(json.dumps(told))
    return json.loads(path.read_text())


def line(name: str, told: dict, key: dict) -> str:
    """Return one robot's line."""
    named = "; ".join(
        f"{e['name']} {e['confidence']:.2f} ("
        + ", ".join(
            f"{n} {p['value']:.3g} +- {p['sd'] or 0:.1g} {p['unit']}" for n, p in e["parameters"].items()
        )
        + ")"
        for e in told["effects"]
    )
    error = {k: told["fit"]["holdout"][k]["xy_m"] * 1e3 for k in ("before", "after", "floor")}
    bound = [note for note in told["notes"] if "stands at its" in note]
    true = "; ".join(f"{e['label']} {e['sizes']}" for e in key["effects"])
    return (
        f"{name}: {told['verdict']}: {named or '-'} | xy {error['before']:.1f}, {error['after']:.1f}, "
        f"{error['floor']:.1f} mm | true {true or '-'} | {told['processor_s']:.0f} s" + "".join(f"\n    {b}" for b in bound)
    )  # fmt: skip


def main() -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--masses", default="0.5,20,300")
    parser.add_argument("--labels", default="clean,payload_offset,tyre_scrub,caster_drag,coulomb_friction")
    parser.add_argument("--engine", default="planar", choices=["planar", "mujoco", "pybullet"])
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    for label in options.labels.split(","):
        for mass in map(float, options.masses.split(",")):
            folder = robot(options.out, label, mass, options.engine, options.seed)
            key = json.loads((options.out / f"{folder.name}.key.json").read_text())
            print(line(folder.name, answer(folder), key), flush=True)


if __name__ == "__main__":
    main()
