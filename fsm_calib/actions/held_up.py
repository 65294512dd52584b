"""What held the robot up: something in its way, or a wheel that does not turn?

Either leaves a drive short of where it should have led. Driven a little back, a robot comes straight away from an
obstacle; with one dead wheel it turns about that wheel, by the way that the living one rolls over the axle.
"""

from __future__ import annotations

from fsm_calib.actions.bench import Bench
from fsm_calib.actions.looking import look
from fsm_calib.actions.moving import drive
from fsm_calib.outcome import Outcome
from fsm_calib.perception.turning import turn_between

DRIVE_BLOCKED = Outcome(
    "robot_blocked",
    sentence="The robot was driven, but the markers say that it did not get as far: something stands in its way.",
    cure="Clear the way over the floor markers and around the robot.",
)


def why_held_up(bench: Bench, blocked: Outcome = DRIVE_BLOCKED) -> Outcome:
    """Drive back a little: a robot that turns about one wheel has a dead one, any other was `blocked`.

    A camera that froze on the way shows a robot that got nowhere: the loss of a frame is returned as such. Without a
    clear turn an obstacle is assumed.
    """
    settings, before = bench.settings.drive, bench.notebook.panorama
    drive(bench, settings.told_back / settings.expected_speed, bench.notebook.wheel_ratio, backward=True)
    seen, after = look(bench), bench.notebook.panorama
    if isinstance(seen, Outcome):
        return seen
    if before is None or after is None:
        return blocked
    turn = turn_between(before, after)
    of_one_wheel = settings.told_back / bench.settings.ratio.axle_length
    is_clear = turn.likeness >= bench.settings.turn.clear_likeness
    if not is_clear or abs(turn.angle) < settings.one_wheel_turn * of_one_wheel:
        return blocked
    dead = "right" if turn.angle > 0.0 else "left"
    return Outcome(
        "wheel_stalled",
        {"turned": round(turn.angle, 3), "wheel": dead},
        f"Driven straight back, the robot turns about its {dead} wheel: that wheel does not turn.",
        cure=f"Check the {dead} motor's cable, the battery and the wheel.",
    )
