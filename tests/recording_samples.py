"""Small recordings that the tests of the recording room share."""

import os
from pathlib import Path

import numpy as np
import pytest

import fsm_calib
from fsm_calib.recording import (
    CommandTrack,
    DisplacementTrack,
    PoseTrack,
    Recording,
    RobotFacts,
    StateTrack,
    TwistTrack,
    WheelPair,
)
from fsm_calib.recording.channels import YawRateTrack

ROOT = Path(fsm_calib.__file__).parent.parent
SHARED = Path(os.environ.get("FSM_CALIB_SHARED", ROOT.parent / "shared")) / "recordings"


def shared(name: str) -> Path:
    """Return a recording of a real robot; skip the test where these are missing."""
    path = SHARED / name
    if not path.exists():
        pytest.skip(f"needs {name} below FSM_CALIB_SHARED/recordings")
    return path


def every_channel(seed: int = 0, twist: bool = False) -> Recording:
    """Return a recording that has every channel, with numbers that need all 17 digits."""
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.uniform(0.05, 0.15, 40))
    x, y = np.cumsum(rng.uniform(0.001, 0.02, (2, 40)), axis=1)
    theta = np.arctan2(np.gradient(y), np.gradient(x))
    lasts = np.diff(t, append=t[-1] + 0.1)
    starts = np.concatenate([[0.0], np.cumsum(lasts)[:-1]])
    command = {"twist": TwistTrack(t, rng.normal(size=40), rng.normal(size=40), 0.4)} if twist else {
        "command": CommandTrack(t, rng.uniform(-1, 1, 40), rng.uniform(-1, 1, 40), "normalized", 0.35)
    }  # fmt: skip
    tick = 2.0 * np.pi / 135.0
    return Recording(
        RobotFacts("sample", 0.0318, 0.1, 27.0),
        pose=PoseTrack(t, x, y, theta),
        wheel_angle=WheelPair(t, np.arange(40) * tick, np.arange(40) * 2 * tick, "rad", tick),
        wheel_rate=WheelPair(starts, rng.normal(size=40), rng.normal(size=40), "rad/s", 0.0, lasts),
        wheel_speed=WheelPair(t, rng.normal(size=40), rng.normal(size=40), "m/s"),
        yaw_rate=YawRateTrack(t, rng.normal(size=40)),
        displacement=DisplacementTrack(starts, lasts, *rng.normal(size=(3, 40)), of="base"),
        state=StateTrack(t[:3], ("wheels.aligning", "wheels.shuttling, back", "lane")),
        **command,
    )  # fmt: skip
