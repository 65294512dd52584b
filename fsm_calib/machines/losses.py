"""The losses that every machine answers alike: no frame, a frozen frame, a wheel that stands, an obstacle."""

from __future__ import annotations

from fsm_calib.statechart.spec import Transition, always, choose, otherwise, when

CAMERA_SILENT = "/failed/camera_silent"
CAMERA_FROZEN = "/failed/camera_frozen"
WHEEL_DEAD = "/failed/wheel_dead"
WALL_HIT = "/failed/wall_hit"
STREAKS = {"lost_frames": "count_lost_frame"}
"""Lost frames count in a row: any other event begins anew."""


def camera_losses(*sources: str) -> tuple[Transition, ...]:
    """Return what happens when the camera fails: try again while frames may be lost, then end with the
    reason.
    """
    return (
        *choose("frame_missing", sources, when("has_frame_retries_left", None, "count_lost_frame"),
                otherwise(CAMERA_SILENT)),
        *choose("frame_frozen", sources, when("has_frame_retries_left", None, "count_lost_frame"),
                otherwise(CAMERA_FROZEN)),
    )  # fmt: skip


def motion_losses(*sources: str) -> tuple[Transition, ...]:
    """Return what happens when commanded wheels do not move the robot: stop and say why.

    The activity has already raised its command to the most it may before it reports such a loss; more pushing
    would only heat the motor.
    """
    return (
        *always("wheel_stalled", sources, WHEEL_DEAD),
        *always("robot_blocked", sources, WALL_HIT),
    )
