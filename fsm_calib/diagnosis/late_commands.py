"""How late the robot follows its commands as they were logged, and the commands moved in time."""

from __future__ import annotations

from dataclasses import replace

from fsm_calib.diagnosis.identify.command import fit_commands
from fsm_calib.errors import DataError
from fsm_calib.recording.recording import Recording


def fitted_delay(recording: Recording) -> tuple[float, float] | None:
    """Return the delay and its standard deviation [s] as `identify` fits them; None with too few poses for a fit."""
    try:
        fit = fit_commands(recording)
    except DataError:
        return None
    return fit.values["delay"], fit.sd("delay")


def with_commands_moved(recording: Recording, shift: float) -> Recording:
    """Return the recording with its commands `shift` [s] later."""
    track = recording.commands
    if track is None:
        return recording
    name = "command" if track is recording.command else "twist"
    return replace(recording, **{name: replace(track, time=track.time + shift)})  # type: ignore[arg-type]
