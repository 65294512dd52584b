"""How small an effect shows, by what was driven and for how long: the table of docs/what-to-drive.md.

A simulated robot that hides nothing (the demo's, poses at 25 Hz with 1 mm and 5 mrad of white noise) is driven in three
ways and diagnosed; of each effect `diagnose` tells the size from which it would have been found (`would_show`).

    python3 benchmarks/what_to_drive.py                 # 40 s of CPU
"""

import argparse
from collections.abc import Iterator

import numpy as np

from fsm_calib import demo
from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.world2d.fleet import nominal_robot

SECONDS = (10.0, 20.0, 40.0, 80.0)
SHOWN = (
    "motor_deadband.offset",
    "motor_gain_curve.curvature",
    "tyre_scrub.moment",
    "lateral_slip.compliance",
    "caster_drag.drag",
    "wheel_eccentricity.left",
    "command_delay.delay",
    "payload_offset.x",
    "sensor_yaw.yaw",
    "floor_tilt.slope_x",
    "clock_drift.drift",
)


def laps(rng: np.random.Generator, seconds: float) -> Iterator[demo.Manoeuvre]:
    """Yield rounds at one speed, as a robot that follows a lane drives them: straights and bends to one side."""
    for _ in range(int(seconds / 4.0)):
        yield ("straight", 0.35, 0.35, 1.5)
        yield ("bend", 0.28, 0.42, 2.5)


def straights(rng: np.random.Generator, seconds: float) -> Iterator[demo.Manoeuvre]:
    """Yield straights at three speeds, forwards and backwards, with rests."""
    speeds, total = (0.2, 0.32, 0.45), 0.0
    while total < seconds:
        for u in speeds:
            for name, sign in (("ahead", 1.0), ("back", -1.0)):
                yield (name, sign * u, sign * u, 1.6)
                yield ("rest", 0.0, 0.0, demo.REST)
                total += 1.6 + demo.REST


def mixed(rng: np.random.Generator, seconds: float) -> Iterator[demo.Manoeuvre]:
    """Yield what the advice asks for: straights at three speeds both ways, spins at three rates, a slalom, rests."""
    total = 0.0
    while total < seconds:
        for u in (0.2, 0.32, 0.45):
            for name, left, right in (
                ("ahead", u, u),
                ("back", -u, -u),
                ("spin left", -u, u),
                ("spin right", u, -u),
            ):
                yield (name, left, right, 0.8)
                yield ("rest", 0.0, 0.0, 0.2)
                total += 1.0
        for name, left, right in (("slalom left", 0.15, 0.4), ("slalom right", 0.4, 0.15)):
            yield (name, left, right, 1.0)
            total += 1.0


def smallest(menu, seconds: float, seed: int) -> dict[str, str]:
    """Return the size of each effect that would have shown in one such drive, with its unit."""
    rng = np.random.default_rng(seed)
    drive = demo.drive(nominal_robot("clean"), cut(menu(rng, seconds), seconds), rng, f"{menu.__name__}")
    plain = diagnose([drive], seed=seed).verdict.as_json()
    if plain["verdict"] != "match":
        return {}
    sizes = plain["smallest_seen"]
    return {name: f"{abs(size['value']):.2g} {size['unit']}" for name, size in sizes.items()}


def cut(parts: Iterator[demo.Manoeuvre], seconds: float) -> Iterator[demo.Manoeuvre]:
    """Yield manoeuvres for so many seconds."""
    total = 0.0
    for part in parts:
        if total >= seconds:
            return
        total += part[3]
        yield part


def main() -> None:
    """Print the table."""
    options = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    options.add_argument("--seed", type=int, default=0)
    seed = options.parse_args().seed
    drives = [(laps, 40.0), (straights, 40.0), *((mixed, seconds) for seconds in SECONDS)]
    told = [smallest(menu, seconds, seed) for menu, seconds in drives]
    print("| effect | " + " | ".join(f"{menu.__name__}, {seconds:g} s" for menu, seconds in drives) + " |")
    print("|---" * (len(drives) + 1) + "|")
    for name in SHOWN:
        cells = [column.get(name, "-").removesuffix(" 1") for column in told]
        print(f"| `{name.split('.')[0]}` {name.split('.')[1].replace('_', ' ')} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
