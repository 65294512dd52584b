"""Wheels as the input of a drive: their rates where no commands were logged, angles where no rates were either."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fsm_calib.recording.channels import WheelPair
from fsm_calib.recording.recording import Recording

INPUT_STEP = 0.1  # s: differences over less are mostly the encoders' steps


def with_input(recording: Recording) -> Recording:
    """Return the recording with wheel rates made of its wheel angles where these are all that tells what drove it.

    Angles become rates [rad/s], held until the next; ticks become rim speeds [m/s] where `metres_per_tick` is stated.
    The angles are then the input and are no measurement besides.
    """
    pair, facts = recording.wheel_angle, recording.robot
    logged = (recording.command, recording.twist, recording.wheel_rate, recording.wheel_speed)
    if pair is None or any(track is not None for track in logged) or len(pair) < 3:
        return recording
    if pair.unit == "tick" and facts.metres_per_tick is None:
        return recording
    every = max(1, round(INPUT_STEP / float(np.median(np.diff(pair.time)))))
    thin = pair.rows(slice(None, None, every))
    step = np.diff(thin.time)
    scale = 1.0 if pair.unit == "rad" else float(facts.metres_per_tick or 1.0)
    left, right = (np.append(scale * np.diff(side) / step, 0.0) for side in (thin.left, thin.right))
    if pair.unit == "tick":
        return replace(
            recording, wheel_angle=None, wheel_speed=WheelPair(thin.time, left, right, "m/s", stamp="start")
        )
    rates = WheelPair(thin.time, left, right, "rad/s", stamp="start")
    return replace(recording, wheel_angle=None, wheel_rate=rates)


def driving_rates(recording: Recording) -> WheelPair | None:
    """Return the wheel rates that drive the simulation of a recording; None where commands do."""
    if recording.command is not None or recording.twist is not None:
        return None
    return recording.wheel_rate or recording.wheel_speed


def with_driving_rates(recording: Recording, rates: WheelPair) -> Recording:
    """Return the recording with others in the place of the rates that drive its simulation."""
    name = "wheel_rate" if recording.wheel_rate is not None else "wheel_speed"
    return replace(recording, **{name: rates})  # type: ignore[arg-type]
