"""The contract between states and actions: what each do-activity does and which outcomes it may return.

The room `actions` implements every activity named here under the same name. An activity gets nothing from the
machine but the briefing (board, direction, iteration: `statechart.runtime.Machine.briefing`), re-observes
before it acts (so that it may be done again after a crash) and returns one `Outcome` whose trigger is among
`returns`. `evidence` names the keys that guards and bookkeeping read; an activity may add any other plain
JSON value for the journal.

Units: angles in rad, counter-clockwise positive; `heading` is the marker's heading in the robot's frame on
the floor, so that a robot that stands along the markers sees 0 and one that is turned too far
counter-clockwise sees a negative heading (it must turn clockwise).
"""

from __future__ import annotations

from fsm_calib.statechart.activity import Activity, Returned, contract_of

QUIET = "quiet: bool, |(k_i - 1) / 2| is below the threshold E"
HEADING = "heading: rad, the nearest marker's heading in the base frame"
TURNED = "turned: rad, how far the robot turned in this step, 0 or absent when unknown"

CAMERA = (
    Returned("frame_missing", "The camera delivered no frame."),
    Returned(
        "frame_frozen", "The frame repeats an earlier one pixel by pixel; a live sensor's noise never does."
    ),
)
MOTION = (
    Returned("wheel_stalled", "A commanded wheel does not turn, though the command was raised to its most."),
    Returned(
        "robot_blocked", "Both wheels are commanded and turn, but the robot does not move on: an obstacle."
    ),
)
FRESH = "fresh_views: views since the last judgement, kept or not"
PRECISE = "precise: bool, the predicted error is within its threshold, from enough views of every board"
_BOARD_SEEN = Returned(
    "board_seen",
    "The board is in the frame; its view is kept under the briefing's board, if it adds enough.",
    (FRESH,),
)
_BOARD_MISSED = Returned("board_missed", "No board is in the frame.", (TURNED,))
_NEXT_BOARD = Returned(
    "next_board_seen",
    "The board followed so far left the frame while the next one in the turn's direction is in it.",
)
_MARKER_SEEN = Returned("marker_seen", "A floor marker is in the frame.", (HEADING,))
_MARKER_MISSED = Returned("marker_missed", "No floor marker is in the frame.", (TURNED,))
_MARKER_GONE = Returned("marker_missed", "No floor marker is in the frame.")
_LANE_MISSED = Returned("lane_missed", "The lane's lines are not in the frame.", (TURNED,))
_DRIVEN = Returned("drive_finished", "The drive was made for its whole time and the robot stands.")
_RATIO = Returned("ratio_measured", "The drive's k_i is known (paper, Eq. 3).")

ACTIVITIES = (
    Activity(
        "stop_wheels",
        "Command zero to both wheels and wait until the robot stands.",
        (Returned("wheels_stopped", "The wheels are at zero."),),
    ),
    Activity(
        "measure_sharpness",
        "Capture a frame, compute its sharpness, keep the best so far.",
        (
            Returned(
                "sharpness_measured", "One more value.", ("sharp: bool, sharp enough to calibrate with",)
            ),
            Returned("focus_skipped", "The operator or the scenario skips the step."),
            *CAMERA,
        ),
    ),
    Activity(
        "look_for_board",
        "Capture a frame without moving and find the board in it.",
        (_BOARD_SEEN, _BOARD_MISSED, *CAMERA),
    ),
    *(
        Activity(
            f"step_{way}",
            f"Drive one wheel for one quantum so that the robot turns {way}, stop, settle, capture, "
            "find the board.",
            (_BOARD_SEEN, _BOARD_MISSED, _NEXT_BOARD, *CAMERA, *MOTION),
        )
        for way in ("clockwise", "counterclockwise")
    ),
    *(
        Activity(
            f"search_{way}",
            f"As step_{way}, but no board is in sight: a larger step is allowed.",
            (_BOARD_SEEN, _BOARD_MISSED, *CAMERA, *MOTION),
        )
        for way in ("clockwise", "counterclockwise")
    ),
    Activity(
        "judge_views",
        "Solve the camera from the views kept so far and predict its error over the image; nothing moves.",
        (Returned("views_judged", "The predicted error is known.", (PRECISE,)),),
    ),
    Activity(
        "solve_camera",
        "Compute the intrinsics from all views kept so far.",
        (
            Returned("camera_solved", "The predicted error over the image is within its threshold."),
            Returned("camera_imprecise", "Solved, but the views do not determine the camera well enough."),
            Returned("camera_refused", "The views do not determine a camera at all."),
        ),
    ),
    Activity(
        "move_to_standpoint",
        "Drive a short way to where the boards look different, facing the row.",
        (Returned("standpoint_reached", "The robot stands at the new place."), *MOTION),
    ),
    Activity(
        "turn_to_marker",
        "Turn one step (counter-clockwise), stop, settle, capture, find floor markers.",
        (_MARKER_SEEN, _MARKER_MISSED, *CAMERA, *MOTION),
    ),
    *(
        Activity(
            f"turn_{way}",
            f"Turn one small step {way}, stop, settle, capture, find floor markers; smaller steps "
            "after each overshoot (briefing).",
            (_MARKER_SEEN, _MARKER_GONE, *CAMERA, *MOTION),
        )
        for way in ("clockwise", "counterclockwise")
    ),
    Activity(
        "measure_marker",
        "At rest, measure the nearest marker over several frames; keep it as the drive's start.",
        (Returned("marker_measured", "The marker's pose is known.", (HEADING,)), _MARKER_GONE, *CAMERA),
    ),
    Activity(
        "drive_forward", "Drive straight for the time t with the k so far, stop, settle.", (_DRIVEN, *MOTION)
    ),
    Activity(
        "drive_back",
        "Drive back for the time t with the k that the last drive forward used, stop, settle.",
        (_DRIVEN, *MOTION),
    ),
    Activity(
        "measure_ratio",
        "At rest, measure the nearest marker again; k_i from the change of heading and the distance driven.",
        (_RATIO, _MARKER_GONE, *CAMERA, *MOTION),
    ),
    Activity(
        "update_ratio",
        "k <- k + (k_i - 1) / 2, unless the correction is quiet.",
        (Returned("ratio_updated", "k is refined, or left as it is when quiet.", (QUIET,)),),
    ),
    Activity(
        "drive_off",
        "Drive straight for one stretch, stop, capture, find floor markers.",
        (
            Returned("marker_seen", "At least one marker is still in the frame."),
            _MARKER_GONE,
            *CAMERA,
            *MOTION,
        ),
    ),
    Activity(
        "hand_over",
        "Stop and record that the robot's own controller may take over.",
        (Returned("control_handed", "The robot stands outside the field."),),
    ),
    Activity(
        "seek_lane",
        "Turn one step towards the lane's direction, stop, capture, find the lane.",
        (
            Returned("lane_seen", "The lane is in the frame and the robot heads along it."),
            _LANE_MISSED,
            *CAMERA,
            *MOTION,
        ),
    ),
    Activity(
        "follow_lane",
        "Follow the lane for one stretch with the lane controller; look for the reserved marker.",
        (
            Returned("lane_followed", "One more stretch was driven in the lane."),
            Returned("lane_missed", "The lane's lines are not in the frame.", (TURNED,)),
            Returned(
                "first_marker_seen", "The marker with the reserved number is near and the robot stands."
            ),
            *CAMERA,
            *MOTION,
        ),
    ),
    Activity(
        "drive_to_next_marker",
        "Drive straight to the next marker of the section, stop, settle.",
        (
            Returned("next_marker_reached", "The robot stands before the next marker."),
            _MARKER_GONE,
            *CAMERA,
            *MOTION,
        ),
    ),
    Activity(
        "refine_ratio",
        "At rest, measure the marker reached; one more k_i from the change of heading.",
        (_RATIO, _MARKER_GONE, *CAMERA),
    ),
    Activity(
        "judge_refinement",
        "Apply the new k only when its values are constant and differ significantly.",
        (Returned("ratio_applied", "A new k is in use."), Returned("ratio_kept", "The k in use is kept.")),
    ),
)
"""Every activity that a state may name."""

CONTRACT: dict[str, Activity] = contract_of(*ACTIVITIES)
"""The activities by name."""
