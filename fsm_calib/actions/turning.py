"""Turn by about an angle, one push at a time, and learn how much a push turns this robot."""

from __future__ import annotations

import math
from dataclasses import dataclass

from fsm_calib.actions.bench import Bench
from fsm_calib.actions.looking import look
from fsm_calib.actions.moving import CLOCKWISE, push
from fsm_calib.outcome import Outcome
from fsm_calib.perception.turning import Turn, turn_between
from fsm_calib.types import Frame

WHEEL_STALLED = Outcome(
    "wheel_stalled",
    sentence="The robot does not turn, though one wheel was commanded up to the most, forward and backward.",
    cure="Check the motor's cable, the battery and the wheel.",
)
ROBOT_BLOCKED = Outcome(
    "robot_blocked",
    sentence="The robot turns one way but not the other: something stands in its way.",
    cure="Clear the area around the robot.",
)
_LEARNING_SHARE = 0.5  # weight of the newest push in the learnt gain [1]


@dataclass(frozen=True, eq=False)
class Step:
    """A step's end: the frame and the angle turned, counter-clockwise positive [rad], as far as the picture
    tells.
    """

    frame: Frame
    turned: float


def turn_step(bench: Bench, way: str, angle: float) -> Step | Outcome:
    """Turn `way` by about `angle` [rad] and return what is seen then, or the loss.

    A push that moves nothing is followed by a stronger one. When the strongest moves nothing, the same wheel
    is tried the other way: a robot that stands against something can leave it, a dead wheel does neither.
    """
    if bench.notebook.unseen:
        return _look_again(bench)
    if bench.notebook.panorama is None:
        first = look(bench)
        if isinstance(first, Outcome):
            return first
    most = bench.settings.turn.largest_command
    command = _command_for(bench, way, angle)
    while True:
        step = _push_and_look(bench, way, command)
        if isinstance(step, Outcome) or step.turned != 0.0:
            return step
        bench.notebook.push_floor = max(bench.notebook.push_floor, min(command, 0.5 * most))
        if command >= most:
            return _why_still(bench, way)
        command = min(command * bench.settings.turn.raise_factor, most)


def _look_again(bench: Bench) -> Step | Outcome:
    """Look without moving: the last move has not been seen yet."""
    before = bench.notebook.panorama
    frame = look(bench)
    if isinstance(frame, Outcome):
        return frame
    after = bench.notebook.panorama
    return Step(frame, 0.0 if before is None or after is None else turn_between(before, after).angle)


def _push_and_look(bench: Bench, way: str, command: float, *, reverse: bool = False) -> Step | Outcome:
    before = bench.notebook.panorama
    push(bench, way, command, reverse=reverse)
    frame = look(bench)
    if isinstance(frame, Outcome):
        return frame
    after = bench.notebook.panorama
    if before is None or after is None:
        return Step(frame, 0.0)
    turn = turn_between(before, after)
    if _stands_still(bench, turn):
        return Step(frame, 0.0)
    if turn.likeness < bench.settings.turn.clear_likeness:
        return Step(frame, _expected_turn(bench, way, -command if reverse else command))
    if not reverse:
        _learn(bench, way, command, turn.angle)
    return Step(frame, turn.angle)


def _stands_still(bench: Bench, turn: Turn) -> bool:
    """Whether the picture is the same but for its noise, or shifted by less than can be told.

    A clear shift is no noise, however little it changes in a dark room.
    """
    settings = bench.settings.turn
    if turn.likeness >= settings.clear_likeness:
        return abs(turn.angle) < settings.smallest_turn
    return turn.change < settings.still_change


def _expected_turn(bench: Bench, way: str, command: float) -> float:
    """Return the angle that a push should have turned [rad]: for a picture that changed but is no shifted
    one, as over markers so near that the robot's own motion distorts them.
    """
    angle = _gain(bench, way) * command
    return -angle if way == CLOCKWISE else angle


def _command_for(bench: Bench, way: str, angle: float) -> float:
    wanted = max(angle / _gain(bench, way), 1.05 * bench.notebook.push_floor)
    return min(wanted, bench.settings.turn.largest_command)


def _gain(bench: Bench, way: str) -> float:
    """Return the angle per unit command of a push [rad]: learnt, or the other way's, or the nominal one."""
    settings, learnt = bench.settings.turn, bench.notebook.push_gain
    nominal = settings.scan_step / settings.first_command
    return learnt.get(way, next(iter(learnt.values()), nominal))


def _learn(bench: Bench, way: str, command: float, angle: float) -> None:
    """Remember how much a push of this command turned; a turn the wrong way teaches nothing."""
    if (angle < 0.0) is not (way == CLOCKWISE):
        return
    gains, gain = bench.notebook.push_gain, abs(angle) / command
    gains[way] = gain if way not in gains else (1.0 - _LEARNING_SHARE) * gains[way] + _LEARNING_SHARE * gain


def _why_still(bench: Bench, way: str) -> Outcome:
    step = _push_and_look(bench, way, bench.settings.turn.largest_command, reverse=True)
    if isinstance(step, Outcome):
        return step
    return WHEEL_STALLED if step.turned == 0.0 else ROBOT_BLOCKED


def turned_evidence(step: Step) -> dict[str, float]:
    """Return the evidence of a step: the angle [rad], rounded to what the picture can tell."""
    return {"turned": round(step.turned, 5) if math.isfinite(step.turned) else 0.0}
