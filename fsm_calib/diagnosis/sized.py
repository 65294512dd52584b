"""A robot of any size: what nobody stated of its wheels and axle is identified before anything is fitted.

The fit of the base robot climbs from the stated sizes, a Duckiebot's where none is stated; from there it does not
reach a robot five times as large.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from fsm_calib.diagnosis.identify.identify import identify
from fsm_calib.diagnosis.identify.result import Identification
from fsm_calib.errors import DataError
from fsm_calib.recording.recording import Recording, RobotFacts


def identified_facts(recordings: Sequence[Recording]) -> tuple[RobotFacts, str]:
    """Return wheel radius [m], axle length [m] and largest wheel rate [rad/s] that were not stated but can be told.

    The sentence says what was identified; empty where nothing was. `recordings` are of one robot, with poses.
    """
    asked = [r for r in recordings if _untold(r)]
    if not asked:
        return RobotFacts(), ""
    try:
        found = identify(asked[:1])
    except DataError:
        return RobotFacts(), ""
    radius = _mean(found, "wheel_radius_left", "wheel_radius_right")
    axle = found.value("axle_length")
    full = _mean(found, "speed_at_full_left", "speed_at_full_right")
    rate = None if full is None else full / (radius or asked[0].robot.wheel_radius or 0.0318)
    facts = RobotFacts(wheel_radius=radius, axle_length=axle, max_wheel_rate=rate)
    names = {"wheel_radius": "m", "axle_length": "m", "max_wheel_rate": "rad/s"}
    said = [
        f"{name} {value:.4g} {unit}"
        for name, unit in names.items()
        if (value := getattr(facts, name)) is not None and getattr(asked[0].robot, name) is None
    ]
    return facts, f"not stated, so identified first: {', '.join(said)}" if said else ""


def sized(recording: Recording, facts: RobotFacts) -> Recording:
    """Return the recording with `facts` where its own are not stated."""
    own = recording.robot
    missing = {
        name: getattr(facts, name)
        for name in ("wheel_radius", "axle_length", "max_wheel_rate")
        if getattr(own, name) is None and getattr(facts, name) is not None
    }
    return replace(recording, robot=replace(own, **missing)) if missing else recording


def _untold(recording: Recording) -> bool:
    """Return whether poses could tell a size of the robot that is not stated."""
    facts, pose = recording.robot, recording.pose
    if pose is None or not pose.has_heading:
        return False
    turning = [t for t in (recording.wheel_angle, recording.wheel_rate) if t is not None and t.unit != "tick"]
    wheels = bool(turning) and (facts.wheel_radius is None or facts.axle_length is None)
    return wheels or (recording.command is not None and facts.axle_length is None)


def _mean(found: Identification, *names: str) -> float | None:
    values = [value for name in names if (value := found.value(name)) is not None and value > 0.0]
    return sum(values) / len(values) if values else None
