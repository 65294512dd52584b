"""The named ends of a run that failed: what happened and what the operator can do about it.

`reason` may hold numbers of the books and the limits in braces, as they are at the end of the run. It is said
when a budget ended the run; a loss that ends it at once (a standing wheel, an obstacle) is better described
by the activity that saw it.
"""

from __future__ import annotations

from fsm_calib.statechart.spec import State


def _failure(name: str, about: str, reason: str, cure: str) -> State:
    return State(name, about, reason=reason, cure=cure)


FAILURES = (
    _failure(
        "board_missing",
        "A chessboard was not found where the plan expects one.",
        "Chessboard {board} was not found: the robot turned {steps} steps, {angle:.1f} rad as seen in"
        " the picture.",
        "Stand every board in sight of the robot, in a semicircle, or declare fewer boards.",
    ),
    _failure(
        "camera_blurred",
        "The picture stayed blurred.",
        "The picture was still blurred after {focus_looks} looks.",
        "Turn the lens ring until the sharpness is highest, clean the lens, or skip the focus step.",
    ),
    _failure(
        "camera_frozen",
        "The camera repeats one and the same frame.",
        "The camera repeated one and the same frame more than {frame_retries} times.",
        "Restart the camera's driver and check its ribbon cable.",
    ),
    _failure(
        "camera_refused",
        "The camera could not be computed from the views.",
        "The camera could not be computed from the views of {standpoints} standpoint(s).",
        "Stand the boards at different distances and angles; check the declared number and size of squares.",
    ),
    _failure(
        "camera_silent",
        "The camera delivers no frames.",
        "The camera delivered no frame in more than {frame_retries} tries.",
        "Check the camera's ribbon cable and that its driver runs.",
    ),
    _failure(
        "field_not_left",
        "The robot drove on and still saw markers.",
        "The robot drove more than {leaving} steps straight on and still saw markers.",
        "Check that the marker field ends before the lane and lies within the allowed driving distance.",
    ),
    _failure(
        "lane_missing",
        "The lane was not found.",
        "The lane was not found: the robot turned {steps} steps, {angle:.1f} rad as seen in the picture.",
        "Check that the lane's lines are in sight where the marker field ends and that the light is even.",
    ),
    _failure(
        "marker_missing",
        "No floor marker was found.",
        "No floor marker was found.",
        "Check that the floor markers lie flat, are lit, belong to tag36h11 and have the declared size.",
    ),
    _failure(
        "not_aligning",
        "The robot could not turn to stand along the markers.",
        "After {turns} turning steps, {overshoots} overshoots and {recoveries} recoveries the robot still did "
        "not stand along the markers.",
        "Check that all markers are oriented alike and that the wheels turn freely at low commands.",
    ),
    _failure(
        "not_turning",
        "The robot turned for many steps and still saw the same board.",
        "After {views} turning steps the robot still saw chessboard {board}.",
        "Check that the wheels grip the floor and that nothing holds the robot.",
    ),
    _failure(
        "wall_hit",
        "Something blocks the robot.",
        "Something blocks the robot.",
        "Clear the robot's surroundings and put it back to its starting place.",
    ),
    _failure(
        "wheel_dead",
        "A wheel does not turn although it is commanded to.",
        "A wheel does not turn although it is commanded to.",
        "Check the motor's cable, the battery and that the wheel turns freely.",
    ),
    _failure(
        "wheels_not_settling",
        "The wheel ratio did not settle within the allowed iterations.",
        "The wheel ratio had not settled after more than {iterations} iterations.",
        "Check that the wheels are fixed to their axles, the floor is even and the battery is charged.",
    ),
)
