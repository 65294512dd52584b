"""The losses that every machine answers alike: no frame, a frozen frame, a wheel that stands, an obstacle."""

from __future__ import annotations

from fsm_calib.machines.bookkeeping import count_lost_frame
from fsm_calib.machines.guards import has_frame_retries_left
from fsm_calib.statechart.spec import Transition, always, choose, otherwise, when

CAMERA_SILENT = "/failed/camera_silent"
CAMERA_FROZEN = "/failed/camera_frozen"
WHEEL_DEAD = "/failed/wheel_dead"
WALL_HIT = "/failed/wall_hit"
STREAKS = {"lost_frames": "count_lost_frame"}
"""Lost frames count in a row: any other event begins anew."""


LOSS_GUARDS = {"has_frame_retries_left": has_frame_retries_left}
LOSS_ACTIONS = {"count_lost_frame": count_lost_frame}
"""What `camera_losses` names: books with `lost_frames` and limits with `frame_retries` can be used with it."""


def camera_losses(
    *sources: str, silent: str = CAMERA_SILENT, frozen: str = CAMERA_FROZEN
) -> tuple[Transition, ...]:
    """Return what happens when the camera fails: try again while frames may be lost, then end with the
    reason, in the ends `silent` and `frozen`.
    """
    return (
        *choose("frame_missing", sources, when("has_frame_retries_left", None, "count_lost_frame"),
                otherwise(silent)),
        *choose("frame_frozen", sources, when("has_frame_retries_left", None, "count_lost_frame"),
                otherwise(frozen)),
    )  # fmt: skip


def motion_losses(
    *sources: str, stalled: str = WHEEL_DEAD, blocked: str = WALL_HIT
) -> tuple[Transition, ...]:
    """Return what happens when commanded wheels do not move the robot: stop and say why, in the ends given.

    The activity has already raised its command to the most it may before it reports such a loss; more pushing
    would only heat the motor.
    """
    return (
        *always("wheel_stalled", sources, stalled),
        *always("robot_blocked", sources, blocked),
    )
