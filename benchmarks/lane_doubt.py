"""What the lane phase says of robots whose k differs from drive to drive, and of robots whose k does not.

    python benchmarks/lane_doubt.py --robots 10

Drawn robots with a known camera and k, without an effect and with an eccentric wheel, drive the marked section.
"""

from __future__ import annotations

import argparse
import tempfile
from collections import Counter
from pathlib import Path

from fsm_calib.runner.run import run_scenario
from fsm_calib.scenario.models import Scenario

HIDDEN: dict[str, dict[str, dict[str, float]]] = {
    "no effect": {},
    "eccentric wheel, 2 %": {"wheel_eccentricity": {"left": 0.02}},
    "eccentric wheel, 4 %": {"wheel_eccentricity": {"left": 0.04}},
}


def said_of(effects: dict[str, dict[str, float]], seed: int) -> str:
    """Return what the run says is likely: empty where the drives agree."""
    scenario = Scenario.model_validate(
        {
            "name": "lane",
            "seed": seed,
            "robot": {
                "source": "fleet",
                "known": {"camera": True, "ratio_drift": 0.0},
                "start_in_lane": 0.3,
                "effects": effects,
            },
            "plan": ["lane"],
            "output": {"report": False, "recording": False, "frames": 0},
        }
    )
    with tempfile.TemporaryDirectory() as folder:
        result = run_scenario(scenario, Path(folder)).result
    if result["outcome"] != "done" or not result["in_lane"]:
        return f"{result['outcome']}: {(result['failure'] or {}).get('name', '')}"
    doubt = result["in_lane"].get("doubt")
    return "drives agree" if doubt is None else doubt["likely"][0]["name"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robots", type=int, default=10)
    parser.add_argument("--first", type=int, default=11)
    given = parser.parse_args()
    for name, effects in HIDDEN.items():
        seeds = range(given.first, given.first + given.robots)
        print(f"{name:22s} {dict(Counter(said_of(effects, seed) for seed in seeds))}", flush=True)


if __name__ == "__main__":
    main()
