"""The table of a foreign set: who was named, what was wrong, how sure, how much better the world became.

    python benchmarks/foreign/score.py DIR [--answers answers] [--json FILE]

A name counts as stated when it is in `effects`. It is right when the robot carries it, or when one of the answer's
ambiguity sets holds both it and a name that the robot carries. A name of a small unlabelled departure that the robot does
carry (a payload where the mass lies behind the axle) is counted apart: neither right nor wrong. Rows "built in" allow what
every robot of an engine has by construction, too (`BUILT_IN`), and what has the size that was found: a place or an angle in
the key, the friction of a sliding ball, the cells' resistance (`found_as_built`).
"""

from __future__ import annotations

import argparse
import json
from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

SURE = 0.6  # a name stated above this is a claim
DEPARTURE_NAMES = {
    "mass_behind": {"payload_offset"},
    "more_mass": {"payload_offset"},
    "rolling": {"coulomb_friction", "caster_drag"},
    "curve": {"motor_gain_curve"},
    "asymmetry": {"motor_reverse_asymmetry"},
    "caster": {"caster_drag"},
    "tag": {"sensor_offset", "sensor_yaw"},
    "viscous": {"coulomb_friction"},
    "uneven_floor": {"floor_tilt"},
}
# physics that no robot is without: motors with dry friction of 0.6 % of their stall torque and wheels that roll with 0.8 %
# of their load (`robots.py`); in the plane tyres that yield sideways (four to nine times their load for a unit of slip), and
# a trailing caster whose wheel rolls with 1 % of its load; in MuJoCo cylinders that stand on a line, which resists a pivoting
# robot, and contacts that creep sideways (soft constraints); in PhysX a ball under every robot that slides with 1.5 to 4 % of
# its load, a skid with 8 to 14 %, a fork that turns over (`physx_robots/robots.py`, `_casters`)
BUILT_IN = {
    "": {"coulomb_friction"},
    "planar": {"lateral_slip", "caster_drag"},
    "mujoco": {"tyre_scrub", "lateral_slip"},
    "physx": {"caster_drag"},
}
CART = 15.0  # kg: Drake's robots above it stand on a swivelling fork, which turns over after every reversal and pushes
# engines of robots whose cells have 1 % of a motor's resistance (`robots.py`)
SERIES = {"planar", "mujoco", "pybullet", "drake"}
# m, rad or 1, and share of the size: so close is what was found to what was built
NEAR, NEAR_SHARE = 0.002, 0.2
# sizes that mean the same in any engine: (label, laws) -> size in the key, unit of the parameter
SIZES: dict[str, tuple[set[str], str, str]] = {
    "command_delay": ({"constant"}, "delay_s", "s"),
    "observation_delay": ({"constant"}, "delay_s", "s"),
    "sensor_yaw": ({"glued_askew"}, "yaw_rad", "rad"),
    "clock_drift": ({"rate"}, "rate", "1"),
    "floor_tilt": ({"slope"}, "tilt_rad", "rad"),
    "wheel_eccentricity": ({"offset_hub"}, "offset_m", "m"),
    "gear_backlash": ({"stiff_mesh"}, "play_rad", "rad"),
    "command_saturation": ({"hard_clip"}, "limit", "1"),
}


def told(answer: dict[str, Any]) -> list[tuple[str, float]]:
    """Return the names that an answer states, with confidence."""
    return [(e["name"], float(e["confidence"])) for e in answer.get("effects", [])]


def set_of(answer: dict[str, Any], name: str) -> set[str]:
    """Return a name with all that the answer cannot tell from it."""
    return {name}.union(*[set(group) for group in answer.get("ambiguous", []) if name in group])


def names_right(answer: dict[str, Any], labels: Iterable[str]) -> set[str]:
    """Return which of the labels an answer names, by itself or in an ambiguity set with a stated name."""
    stated = set().union(*[set_of(answer, name) for name, _ in told(answer)])
    if answer.get("verdict") == "explained":
        stated = stated.union(*[set(group) for group in answer.get("ambiguous", [])])
    return set(labels) & stated


def departures_of(key: dict[str, Any]) -> set[str]:
    """Return the names that the small departures of a robot may go by."""
    return set().union(*[DEPARTURE_NAMES.get(name, set()) for name in key.get("departures", {})])


def built_in(key: dict[str, Any]) -> set[str]:
    """Return the names of what every robot of the engine has, or of its kind there."""
    on_a_fork = key["engine"] == "drake" and key["robot"]["mass"] > CART
    ramps = "ramp" in (key.get("control") or {})  # a controller that limits acceleration
    own = ({"caster_drag"} if on_a_fork else set()) | ({"motor_asymmetric_lag"} if ramps else set())
    return BUILT_IN[""] | BUILT_IN.get(key["engine"], set()) | own


def found_as_built(answer: dict[str, Any], key: dict[str, Any]) -> set[str]:
    """Return the names whose sizes are as built: centre of mass, tag, friction of a sliding ball, cells' resistance."""
    robot, sensing = key.get("robot", {}), key.get("sensing", {})
    built: dict[str, dict[str, float]] = {}
    if "centre_x" in robot:
        built["payload_offset"] = {"x": robot["centre_x"], "y": robot["centre_y"]}
    if "tag" in sensing:
        built["sensor_offset"] = dict(zip("xy", sensing["tag"], strict=True))
    if "tag_yaw" in sensing:
        built["sensor_yaw"] = {"yaw": sensing["tag_yaw"]}
    if "caster_friction" in robot:
        built["caster_drag"] = {"drag": robot["caster_friction"]}
    if key.get("engine") in SERIES:
        built["battery_sag"] = {"inner": 0.01}

    def same(sizes: dict[str, float], found: dict[str, Any]) -> bool:
        told = [float(found.get(name, {}).get("value", 0.0)) for name in sizes]
        size = np.array(list(sizes.values()))
        return bool(np.linalg.norm(told - size) <= max(NEAR, NEAR_SHARE * np.linalg.norm(size)))

    effects = answer.get("effects", [])
    return {
        e["name"] for e in effects if e["name"] in built and same(built[e["name"]], e.get("parameters", {}))
    }


def wrong_names(
    answer: dict[str, Any], key: dict[str, Any], strict: bool = False, lenient: bool = False
) -> list[str]:
    """Return the names stated above `SURE` that the robot does not carry.

    strict : departures are wrong, too; lenient : what is built into every robot is right.
    """
    true = set(key["labels"]) | (set() if strict else departures_of(key))
    true |= built_in(key) | found_as_built(answer, key) if lenient else set()
    return [name for name, sure in told(answer) if sure > SURE and not set_of(answer, name) & true]


def calibration(pairs: list[tuple[dict[str, Any], dict[str, Any]]]) -> list[tuple[float, int, float, float]]:
    """Return for each tenth of stated confidence: its lower end, how many, mean stated, share right."""
    bins: dict[int, list[tuple[float, bool]]] = defaultdict(list)
    for key, answer in pairs:
        true = set(key["labels"]) | departures_of(key) | built_in(key) | found_as_built(answer, key)
        for name, sure in told(answer):
            bins[min(int(sure * 10), 9)].append((sure, bool(set_of(answer, name) & true)))
    return [
        (k / 10, len(v), float(np.mean([s for s, _ in v])), float(np.mean([r for _, r in v])))
        for k, v in sorted(bins.items())
    ]


def coverage(
    pairs: list[tuple[dict[str, Any], dict[str, Any]]],
) -> list[tuple[str, str, float, float, float]]:
    """Return (robot, label, true, found, sd) for sizes that mean the same; a parameter is known by its unit alone."""
    rows = []
    for key, answer in pairs:
        for effect in key["effects"]:
            laws, size, unit = SIZES.get(effect["label"], (set(), "", ""))
            found = next((e for e in answer.get("effects", []) if e["name"] == effect["label"]), None)
            if found is None or effect["law"] not in laws:
                continue
            same = [
                p for p in found.get("parameters", {}).values() if p.get("unit", "") == unit and p.get("sd")
            ]
            if len(same) == 1:
                value = float(same[0]["value"])
                rows.append(
                    (
                        key["name"],
                        effect["label"],
                        abs(float(effect["sizes"][size])),
                        abs(value),
                        float(same[0]["sd"]),
                    )
                )
    return rows


def improvement(answer: dict[str, Any]) -> dict[str, float]:
    """Return after/floor of both channels, and the share of the error above the floor that went, where most was."""
    held = (answer.get("fit") or {}).get("holdout") or {}
    out: dict[str, float] = {}
    worst = 1.0
    for channel in ("xy_m", "theta_rad"):
        before, after, floor = ((held.get(k) or {}).get(channel) for k in ("before", "after", "floor"))
        if not (before and after and floor):
            continue
        out[f"after_over_floor_{channel}"] = after / floor
        if before / floor > max(worst, 1.15):
            worst = before / floor
            out["removed"] = (before - after) / (before - floor)
    return out


def share(hits: list[bool]) -> str:
    """Return hits as `12 of 13 (92 %)`."""
    return f"{sum(hits)} of {len(hits)} ({100 * np.mean(hits):.0f} %)" if hits else "none"


def score(
    pairs: list[tuple[dict[str, Any], dict[str, Any]]], loo: bool = False
) -> list[tuple[str, str, str]]:
    """Return rows of the table: what, measured, bar."""
    by = defaultdict(list)
    for key, answer in pairs:
        by[key["family"]].append((key, answer))

    def named(family: str, all_of: bool = False) -> str:
        return share(
            [
                len(names_right(a, k["labels"])) == len(k["labels"])
                if all_of
                else bool(names_right(a, [k["strongest"]]))
                for k, a in by[family]
            ]
        )

    if loo:
        return [
            (
                "a wrong name above 0.6, true one left out",
                share([bool(wrong_names(a, {**k, "labels": []})) for k, a in pairs]),
                "<= 5 %",
            )
        ]
    labelled = [(k, a) for k, a in pairs if k["family"] not in ("clean", "outside")]
    better = [improvement(a) for _, a in pairs]
    explained = [improvement(a) for _, a in pairs if a.get("verdict") == "explained"]
    unexplained = [improvement(a) for _, a in pairs if a.get("verdict") == "unexplained"]

    def median(rows: list[dict[str, float]], what: str) -> str:
        values = [row[what] for row in rows if what in row]
        return f"{np.median(values):.2f} (n {len(values)})" if values else "none"

    sizes = coverage(pairs)
    rows = [
        ("strongest named, plain", named("plain"), ">= 95 %"),
        ("strongest named, faint", named("faint"), ">= 80 %"),
        ("strongest named, masked", named("masked"), ""),
        ("both of a pair", named("pair", True), ">= 90 %"),
        ("all of a triple", named("triple", True), ">= 75 %"),
        (
            "strongest of a pair or triple",
            share([bool(names_right(a, [k["strongest"]])) for f in ("pair", "triple") for k, a in by[f]]),
            "",
        ),
        ("a wrong name above 0.6", share([bool(wrong_names(a, k)) for k, a in labelled]), "<= 2 %"),
        (
            "the same, departures count as wrong",
            share([bool(wrong_names(a, k, True)) for k, a in labelled]),
            "",
        ),
        (
            "the same, built-in physics allowed",
            share([bool(wrong_names(a, k, lenient=True)) for k, a in labelled]),
            "",
        ),
        ("clean, a false name above 0.6", share([bool(wrong_names(a, k)) for k, a in by["clean"]]), "<= 1 %"),
        (
            "the same, departures count as false",
            share([bool(wrong_names(a, k, True)) for k, a in by["clean"]]),
            "",
        ),
        (
            "the same, built-in physics allowed",
            share([bool(wrong_names(a, k, lenient=True)) for k, a in by["clean"]]),
            "",
        ),
        (
            "outside, built-in physics allowed",
            share([not wrong_names(a, k, lenient=True) for k, a in by["outside"]]),
            "",
        ),
        ("outside, no name for it", share([not wrong_names(a, k) for k, a in by["outside"]]), ">= 95 %"),
        (
            "90 % intervals hold the true size",
            share([abs(f - t) <= 1.645 * s for _, _, t, f, s in sizes]),
            "85 to 95 %",
        ),
        ("error above the floor removed, explained, median", median(explained, "removed"), ">= 0.80"),
        ("error above the floor removed, unexplained, median", median(unexplained, "removed"), ">= 0.60"),
        ("after / floor xy, median", median(better, "after_over_floor_xy_m"), "<= 1.03"),
        ("after / floor heading, median", median(better, "after_over_floor_theta_rad"), "<= 1.06"),
    ]
    for engine in sorted({k["engine"] for k, _ in pairs}):
        mine = [(k, a) for k, a in labelled if k["engine"] == engine]
        rows.append(
            (
                f"all names, {engine}",
                share([len(names_right(a, k["labels"])) == len(k["labels"]) for k, a in mine]),
                "",
            )
        )
    for low, count, said, right in calibration(pairs):
        rows.append(
            (
                f"stated {low:.1f} to {low + 0.1:.1f}",
                f"{count} names, said {said:.2f}, right {right:.2f}",
                "within 0.05" if low >= 0.5 else "",
            )
        )
    return rows


def by_label(pairs: list[tuple[dict[str, Any], dict[str, Any]]]) -> list[str]:
    """Return one line for each label and law: how many, named, what was said instead."""
    lines: dict[str, list[str]] = defaultdict(list)
    for key, answer in pairs:
        for effect in key["effects"]:
            right = effect["label"] in names_right(answer, [effect["label"]])
            said = "+".join(f"{n} {c:.2f}" for n, c in told(answer)) or answer.get("verdict", "no answer")
            lines[f"{effect['label']}/{effect['law']}"].append(
                "named" if right else f"{key['name']} ({effect['ratio']:.1f}): {said}"
            )
    return [f"{what:40s}{'; '.join(said)}" for what, said in sorted(lines.items())]


def read(folder: Path, answers: str) -> tuple[list[tuple[dict[str, Any], dict[str, Any]]], list[str]]:
    """Return pairs of key and answer, and the robots without one."""
    pairs, missing = [], []
    for key in json.loads((folder / "keys.json").read_text()):
        path = folder / answers / f"{key['name']}.json"
        answer = json.loads(path.read_text())["answer"] if path.exists() else None
        if answer is None:
            missing.append(key["name"])
        else:
            pairs.append((key, answer))
    return pairs, missing


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("--answers", default="answers")
    parser.add_argument("--loo", action="store_true")
    parser.add_argument("--json", type=Path)
    args = parser.parse_args()
    pairs, missing = read(
        args.folder, "answers-loo" if args.loo and args.answers == "answers" else args.answers
    )
    if missing:
        print(f"{len(missing)} robots without an answer: {', '.join(missing[:12])}")
    rows = score(pairs, args.loo)
    for what, measured, bar in rows:
        print(f"{what:54s}{measured:36s}{bar}")
    if not args.loo:
        print("\n".join(["", *by_label(pairs)]))
    if args.json:
        args.json.write_text(json.dumps([list(row) for row in rows], indent=1) + "\n")


if __name__ == "__main__":
    main()
