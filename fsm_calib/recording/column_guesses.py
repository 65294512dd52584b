"""Which columns of a table are which channel, guessed from their names: the first draft of a manifest.

Names are compared without case and marks (``posX`` is ``pos_x``); a unit behind a name (``x_mm``, ``left [rpm]``,
``PWM_L (%)``), or one like rpm ahead of it, is taken for the channel's.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

TIMES = (
    "t",
    "time",
    "times",
    "timestamp",
    "stamp",
    "sec",
    "seconds",
    "datetime",
    "rostime",
    "headerstamp",
    "date",
    "ts",
    "epoch",
    "unixtime",
    "elapsed",
    "elapsedtime",
    "frametime",
    "timesec",
    "simtime",
)
LINEAR = (
    "linearvelocity", "linearspeed", "velocity", "linvel", "linearvel", "forwardvelocity", "forwardspeed",
    "cmdvellinearx",
)  # fmt: skip
ANGULAR = (
    "angularvelocity", "angularspeed", "angvel", "angularvel", "turnrate", "rotationalvelocity", "cmdvelangularz",
)  # fmt: skip
QUANTITIES: dict[str, tuple[str, ...]] = {
    "x": ("x", "posx", "px", "positionx", "posepositionx", "poseposepositionx", "xpos", "xposition"),
    "y": ("y", "posy", "py", "positiony", "posepositiony", "poseposepositiony", "ypos", "yposition"),
    "theta": (
        "theta",
        "yaw",
        "heading",
        "psi",
        "th",
        "angle",
        "orientation",
        "phi",
        "h",
        "bearing",
        "rotation",
    ),
    "qx": ("qx", "orientationx", "poseorientationx", "quatx", "qux"),
    "qy": ("qy", "orientationy", "poseorientationy", "quaty"),
    "qz": ("qz", "orientationz", "poseorientationz", "quatz"),
    "qw": ("qw", "orientationw", "poseorientationw", "quatw"),
    "v": (
        "v",
        "linearx",
        "linx",
        "vx",
        "twistlinearx",
        "speed",
        "linear",
        "vlin",
        "cmdv",
        "vcmd",
        "vel",
        *LINEAR,
    ),
    "omega": (
        "omega",
        "w",
        "angularz",
        "angz",
        "wz",
        "twistangularz",
        "angular",
        "vang",
        "cmdomega",
        "cmdw",
        "wcmd",
        "omegacmd",
        "turn",
        *ANGULAR,
    ),
    "value": ("yawrate", "gyroz", "gz", "gyro", "angularvelocityz", "imuangz", "wzimu"),
    "state": ("state", "mode", "phase"),
}
UNITS = {
    "deg": "deg", "degree": "deg", "degrees": "deg", "rad": "rad", "rpm": "rpm", "mm": "mm", "cm": "cm", "m": "m",
    "s": "s", "ms": "ms", "us": "us", "ns": "ns", "radps": "rad/s", "rads": "rad/s", "degps": "deg/s", "mps": "m/s",
    "ms1": "m/s", "ticks": "tick", "tick": "tick", "counts": "tick", "mmps": "mm/s", "rads1": "rad/s", "percent": "%",
    "pct": "%",
}  # fmt: skip
LEADING = ("rpm", "ticks", "tick", "counts", "deg")
"""Units that people write ahead of a name: ``rpm_left``."""
PRINTED = "field"
"""What `rostopic echo -p` writes ahead of every column."""
SIDES = {"left": ("left", "l", "lft"), "right": ("right", "r", "rgt")}
"""Words that say which wheel a column is of; the first counts inside another word, too."""
SHORT = ("u", "v", "w")
"""Letters ahead of a wheel's: ``ul`` and ``ur`` are commands, ``vl`` speeds, ``wl`` rates."""
SECONDS = {"ms": 1e-3, "us": 1e-6, "ns": 1e-9}
METRES = {"mm": 1e-3, "cm": 1e-2, "mm/s": 1e-3}


@dataclass(frozen=True)
class Guess:
    """One channel of a manifest: its name, its section, and what was assumed, in words."""

    channel: str
    section: dict[str, object]
    assumed: tuple[str, ...] = ()


def plain(name: str) -> tuple[str, str]:
    """Return a column's name without marks and unit, and the unit; empty where it names none."""
    words = words_of(name)
    words = words[1:] if len(words) > 1 and words[0] == PRINTED else words
    if len(words) < 2:
        return "".join(words), ""
    if unit := UNITS.get(words[-1], ""):
        return "".join(words[:-1]), unit
    unit = UNITS[words[0]] if words[0] in LEADING else ""
    return "".join(words[1:] if unit else words), unit


def words_of(name: str) -> list[str]:
    """Return the words of a column's name in small letters: what marks, blanks or a capital letter part."""
    parted = re.sub(r"([a-z])([A-Z])", r"\1 \2", re.sub(r"(?<!^)%", " percent ", name)).lower()
    return [w for w in re.split(r"[^a-z0-9]+", re.sub(r"(rad|deg|mm|m)/s\b", r"\1ps", parted)) if w]


def guessed(file: str, header: Sequence[str]) -> list[Guess]:
    """Return the channels that a table seems to hold; none where no column is a time."""
    named = {name: plain(name) for name in header}
    time = next((n for n, (word, _) in named.items() if word in TIMES), None)
    if time is None:
        return []
    base: dict[str, object] = {"file": file, "time": time}
    if named[time][1] in SECONDS:
        base["time_unit"] = SECONDS[named[time][1]]
    found = {
        key: next((n for n in header if named[n][0] in words), None) for key, words in QUANTITIES.items()
    }
    sides = {side: next((n for n in header if _is_of(n, side)), None) for side in SIDES}
    units = {name: unit for name, (_, unit) in named.items()}
    return list(_channels(base, found, sides, units))


def _is_of(name: str, side: str) -> bool:
    """Return whether a column is of a wheel."""
    words = words_of(name)
    short = [f"{letter}{side[0]}" for letter in SHORT]
    return side in name.lower() or any(word in SIDES[side] for word in words) or "".join(words) in short


def _channels(
    base: dict[str, object],
    found: dict[str, str | None],
    sides: dict[str, str | None],
    units: dict[str, str],
) -> Iterator[Guess]:
    """Yield the channels of the columns that were found."""
    if found["x"] and found["y"]:
        yield _pose(base, found, units)
    if found["v"] and found["omega"]:
        section = base | {"v": found["v"], "omega": found["omega"], "unit": "twist"}
        yield Guess(
            "command", section | _angle(units[found["omega"]]), ("v and omega are commands, not measured",)
        )
    if sides["left"] and sides["right"]:
        yield _wheels(
            base | {"left": sides["left"], "right": sides["right"]}, sides["left"], units[sides["left"]]
        )
    if found["value"]:
        unit = units[found["value"]]
        yield Guess(
            "yaw_rate", base | {"value": found["value"]} | ({"unit": unit} if unit.endswith("/s") else {})
        )
    if found["state"]:
        yield Guess("state", base | {"state": found["state"]})


def _angle(unit: str) -> dict[str, object]:
    return {"angle_unit": "deg"} if unit.startswith("deg") else {}


def _pose(base: dict[str, object], found: dict[str, str | None], units: dict[str, str]) -> Guess:
    section = base | {"x": found["x"], "y": found["y"]}
    unit = units[str(found["x"])]
    section |= {"length_unit": METRES[unit]} if unit in METRES else {}
    quaternion = [found[key] for key in ("qx", "qy", "qz", "qw")]
    if all(quaternion):
        return Guess("pose", section | {"quaternion": quaternion})
    if found["theta"] is None:
        return Guess("pose", section, ("no heading was found",))
    return Guess("pose", section | {"theta": found["theta"]} | _angle(units[found["theta"]]))


def _wheels(section: dict[str, object], name: str, unit: str) -> Guess:
    """Return what left and right columns are, by their unit, else by their name."""
    lower, word = name.lower(), plain(name)[0]
    if unit in ("rpm", "rad/s", "deg/s"):
        return Guess("wheel_rate", section | {"unit": unit})
    if unit in ("m/s", "mm/s"):
        return Guess(
            "wheel_speed", section | {"unit": "m/s"} | ({"length_unit": 1e-3} if unit == "mm/s" else {})
        )
    if unit == "tick" or "tick" in lower or "enc" in lower:
        return Guess("wheel_angle", section | {"unit": "tick"}, ("add ticks_per_turn where you know it",))
    if unit in ("rad", "deg"):
        return Guess("wheel_angle", section | {"unit": unit})
    if "rate" in lower or "omega" in lower or "vel" in lower or word == "wl":
        return Guess("wheel_rate", section, ("rates in rad/s; rpm and deg/s show and are told",))
    if word == "vl":
        return Guess("wheel_speed", section | {"unit": "m/s"}, ("speeds of the rims in m/s",))
    if unit == "%":
        return Guess("command", section | {"unit": "normalized", "full": 100}, ("100 is full command",))
    return Guess("command", section | {"unit": "normalized"}, ("left and right are commands from -1 to 1",))
