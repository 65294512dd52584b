"""The topics of a bag: what each is, how much it holds, and which of them serve as which channel.

A topic of transforms is one topic for each child frame, named ``/tf:CHILD``. Where several could serve and nothing
tells them apart, nothing is guessed: the error lists them and the option that chooses.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from fsm_calib.errors import InputError

FEWEST = 5  # messages: fewer are goals or settings, no measurement of a drive
GOALS = ("goal", "target", "setpoint", "waypoint", "plan", "initialpose", "desired", "reference", "cmd")
MEASURED = ("vrpn", "mocap", "optitrack", "vicon", "qualisys", "truth", "ground", "world", "tracker")
"""Words in the names of topics that a motion capture or a simulator writes: the pose itself, not an estimate."""
COMPUTED = ("deadreckoning", "velocity_to_pose", "odom")
"""Words in the names of poses that are computed from wheels or commands and measure nothing."""
WORLDS = ("world", "map", "earth", "mocap", "vicon", "optitrack", "odom_combined", "")
"""Frames in which a transform is a measured pose; one in `odom` is computed."""


@dataclass(frozen=True)
class Topic:
    """One topic: name, message type without its package, rows (stamp [ns], message); parent frame of a transform."""

    name: str
    kind: str
    rows: list[tuple[int, Any]] = field(repr=False)
    parent: str | None = None

    @property
    def rate(self) -> float:
        """Messages a second [Hz]; 0 for one message."""
        span = (self.rows[-1][0] - self.rows[0][0]) / 1e9 if self.rows else 0.0
        return (len(self.rows) - 1) / span if span > 0 else 0.0

    def __str__(self) -> str:
        """Return name, type, count and rate."""
        return f"{self.name} ({self.kind}, {len(self.rows)} messages, {self.rate:.3g} Hz)"


def owner_of(name: str) -> str:
    """Return the robot whose topic it is, by its name as Duckietown's nodes and motion captures write it; else empty.

    ``/NAME/SOME_node/...`` and ``/vrpn_client_node/NAME/pose`` (`MEASURED` has the words).
    """
    house, part, *rest = [*name.strip("/").split("/"), ""]
    if any(word in house for word in MEASURED):
        return part if rest and rest[0] else ""
    return house if part.endswith("_node") and rest and rest[0] else ""


def says(topic: Topic, words: Sequence[str]) -> bool:
    """Return whether a topic's name holds one of the words."""
    return any(word in topic.name.lower() for word in words)


def chosen(topics: Mapping[str, Topic], name: str, option: str, kinds: Sequence[str], where: str) -> Topic:
    """Return the topic that the user named, in full or by its end.

    Raises
    ------
    InputError
        None or several match, or it is of a type that cannot serve; the sentence lists those that can.
    """
    found = [t for t in topics.values() if t.name == name]
    found = found or [t for t in topics.values() if t.name.endswith(name) or t.name.split(":")[0] == name]
    if len(found) == 1 and found[0].kind in kinds:
        return found[0]
    serving = [t for t in topics.values() if t.kind in kinds]
    problem = f"no topic {name!r}"
    if len(found) == 1:
        problem = f"{found[0]} cannot serve as {option}"
    elif found:
        problem = f"{name!r} stands for {len(found)} topics"
    raise InputError(f"{problem}; {listed(found if len(found) > 1 else serving)}", where=where)


def listed(serving: Sequence[Topic]) -> str:
    """Return the topics that would serve in words."""
    return (
        f"these would serve: {', '.join(map(str, serving))}"
        if serving
        else "the bag holds none that would serve"
    )


def only(serving: Sequence[Topic], option: str, where: str) -> Topic | None:
    """Return the one topic that serves, None for none.

    Raises
    ------
    InputError
        There are several: the sentence lists them with type, count and rate.
    """
    if len(serving) > 1:
        raise InputError(
            f"{len(serving)} topics could be the {option}; {listed(serving)}",
            where=where,
            cure=f"Choose one: --{option} {serving[0].name}",
        )
    return serving[0] if serving else None


def measured_pose(topics: Mapping[str, Topic], kinds: Sequence[str], where: str) -> Topic | None:
    """Return the topic of measured poses: no goals, nothing computed from the wheels, a motion capture first."""
    serving = [t for t in topics.values() if t.kind in kinds and len(t.rows) >= FEWEST and _is_measured(t)]
    captured = [t for t in serving if says(t, MEASURED)]
    duckietown = [t for t in serving if t.kind == "Pose2DStamped"]
    return only(_at_most_one(captured) or duckietown[:1] or captured or serving, "pose", where)


def _at_most_one(topics: list[Topic]) -> list[Topic]:
    return topics if len(topics) == 1 else []


def _is_measured(topic: Topic) -> bool:
    if topic.parent is not None and (_frame(topic.parent) not in WORLDS or "odom" in topic.name):
        return False
    if topic.kind == "Odometry":
        return says(topic, MEASURED)
    return not says(topic, GOALS) and not says(topic, COMPUTED)


def _frame(name: str) -> str:
    """Return a frame without the names of its house: ``vicon/world`` is a world."""
    return name.strip("/").rpartition("/")[2]


def passed_over(topics: Mapping[str, Topic], kinds: Sequence[str]) -> list[Topic]:
    """Return the topics of poses that were taken for computed ones; goals are none."""
    return [t for t in topics.values() if t.kind in kinds and len(t.rows) >= FEWEST and not says(t, GOALS)]


def commanded(topics: Mapping[str, Topic], kinds: Sequence[str], where: str) -> Topic | None:
    """Return the topic of commanded twists: the one that is called as ROS calls it, else the only one."""
    serving = [t for t in topics.values() if t.kind in kinds and not says(t, ("odom", "measured", "joy"))]
    for ending in ("car_cmd_switch_node/cmd", "car_cmd", "/cmd_vel", "cmd_vel_stamped", "cmd_vel_unstamped"):
        called = [t for t in serving if t.name.endswith(ending)]
        if len(called) == 1:
            return called[0]
    return only(serving, "command", where)


def first_of(topics: Mapping[str, Topic], kind: str, order: Sequence[str] = ()) -> Topic | None:
    """Return the topic of a kind whose name ends as `order` says, else the first of that kind."""
    found = [t for t in topics.values() if t.kind == kind]
    for ending in order:
        for topic in found:
            if topic.name.endswith(ending):
                return topic
    return found[0] if found else None
