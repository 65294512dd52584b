"""One recording type, its readers and writers."""

from fsm_calib.recording.channels import (
    CommandTrack,
    DisplacementTrack,
    PoseTrack,
    StateTrack,
    TwistTrack,
    WheelPair,
    YawRateTrack,
)
from fsm_calib.recording.read import read_recording
from fsm_calib.recording.recording import (
    Finding,
    Recording,
    RobotFacts,
    held_at,
    held_integral,
    resample_pose,
)

__all__ = [
    "CommandTrack",
    "DisplacementTrack",
    "Finding",
    "PoseTrack",
    "Recording",
    "RobotFacts",
    "StateTrack",
    "TwistTrack",
    "WheelPair",
    "YawRateTrack",
    "held_at",
    "held_integral",
    "read_recording",
    "resample_pose",
]
