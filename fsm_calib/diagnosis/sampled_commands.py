"""Commands that a logger sampled: each change happened somewhere between a row and the row before.

A log with a row every 50 ms holds what the robot was told *last*, so that its commands stand there late, by half a row
in the mean, and the poses seem as much early. No robot answers early. So where rows are regular and most repeat the one
before, commands that the poses follow early are laid as much earlier, by a row at most. Commands of a robot whose own
loop wrote the log stand there when they were given, and stay: its poses are not early.
"""

from __future__ import annotations

import numpy as np

from fsm_calib.diagnosis.each_told import each_told
from fsm_calib.diagnosis.late_commands import fitted_delay, with_commands_moved
from fsm_calib.recording.channels import CommandTrack, TwistTrack
from fsm_calib.recording.recording import Recording

FEWEST_ROWS = 50
LEAST_REGULAR, LEAST_REPEATED = 0.9, 0.5  # shares of the rows of a log that was sampled
SAME_STEP = 0.1  # of the usual step between rows
SURELY_EARLY = 3.0  # standard deviations of the fitted delay


def with_changes_placed(recordings: list[Recording], processes: int = 1) -> tuple[list[Recording], list[str]]:
    """Return the recordings with sampled commands where the poses follow them, and a sentence for each."""
    return each_told(_placed, recordings, processes)


def row_step(track: CommandTrack | TwistTrack) -> float | None:
    """Return the time [s] between the rows of a log that was sampled; None of commands as they were sent."""
    if len(track) < FEWEST_ROWS:
        return None
    sides = (track.left, track.right) if isinstance(track, CommandTrack) else (track.v, track.omega)
    step = np.diff(track.time)
    usual = float(np.median(step))
    regular = float(np.mean(np.abs(step - usual) < SAME_STEP * usual))
    repeated = float(np.mean((np.diff(sides[0]) == 0.0) & (np.diff(sides[1]) == 0.0)))
    return usual if regular >= LEAST_REGULAR and repeated >= LEAST_REPEATED else None


def _placed(recording: Recording) -> tuple[Recording, str]:
    track = recording.commands
    step = row_step(track) if track is not None else None
    found = fitted_delay(recording) if step is not None and recording.pose is not None else None
    if step is None or found is None:
        return recording, ""
    delay, sd = found
    if not -delay > SURELY_EARLY * sd:
        return recording, ""
    early = min(-delay, step)
    said = (
        f"{recording.source}: its commands were sampled every {1e3 * step:.0f} ms; they are laid "
        f"{1e3 * early:.0f} ms earlier, where the poses follow them"
    )
    return with_commands_moved(recording, -early), said
