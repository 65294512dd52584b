"""Is a place effect from outside named as surely as the package's own? `python3 benchmarks/outside_effect.py`.

Ten robots hide a sticky spot (tests/effects_outside/sticky_spot.py: size, place and radius drawn, and the rate at which
it gives way, which the fit holds at its usual value), ten a rough patch, both with the other in the catalogue. Two
drives of 50 s each with poses of 2 mm and 6 mrad at 15 Hz. About ten minutes on one core.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests"))

from fsm_calib.world2d.effects import add_effects

add_effects([ROOT / "tests" / "effects_outside" / "sticky_spot.py"])

from diagnosis_robots import recording

from fsm_calib.diagnosis.diagnose import diagnose


def hidden(kind: str, number: int) -> dict[str, float]:
    rng = np.random.default_rng([7, number])
    x, y = rng.uniform(-0.15, 0.25), rng.uniform(-0.2, 0.2)
    if kind == "sticky_spot":
        sizes = {
            "pull": rng.uniform(0.8, 3.0),
            "radius": rng.uniform(0.12, 0.25),
            "rate": rng.uniform(0.06, 0.18),
        }
    else:
        half = rng.uniform(0.12, 0.25)
        sizes = {"drag": rng.uniform(0.4, 1.5), "half_x": half, "half_y": half, "roundness": 1.0}
    return {f"{kind}__{name}": value for name, value in {"x": x, "y": y, **sizes}.items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robots", type=int, default=10)
    count = parser.parse_args().robots
    for kind in ("sticky_spot", "rough_floor_patch"):
        right = 0
        for number in range(count):
            truth = hidden(kind, number)
            drives = [recording(100 * number + i, duration=50.0, **truth) for i in range(2)]
            verdict = diagnose(drives).verdict
            named = [effect.name for effect in verdict.effects]
            right += named == [kind]
            off = np.hypot(
                *(verdict.effects[0].parameters[a].value - truth[f"{kind}__{a}"] for a in "xy")
            ) if named == [kind] else np.nan  # fmt: skip
            rivals = ", ".join(f"{r.name} {r.evidence_gap:.0f} behind" for r in verdict.rivals[:2])
            print(
                f"{kind} {number}: {verdict.verdict} {named} centre off {100 * off:.1f} cm; {rivals}; {verdict.reason}",
                flush=True,
            )
        print(f"{kind}: {right} of {count} named")


if __name__ == "__main__":
    main()
