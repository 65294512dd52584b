"""Commands from another computer's clock, laid on the poses' clock to milliseconds.

The reader brings two clocks together by what moved when (`recording.two_clocks`), to some hundredths of a second. What
is left is fitted here as `identify` fits a delay. On another clock nobody can tell a delay of the robot from one of the
clocks, so it is put down to the clocks and told.
"""

from __future__ import annotations

from fsm_calib.diagnosis.each_told import each_told
from fsm_calib.diagnosis.late_commands import fitted_delay, with_commands_moved
from fsm_calib.recording.recording import Recording
from fsm_calib.recording.two_clocks import NEAR

SURE = 0.005  # s, largest standard deviation of a shift that is worth its while


def with_fine_clocks(recordings: list[Recording], processes: int = 1) -> tuple[list[Recording], list[str]]:
    """Return the recordings with commands of another clock moved by what the poses tell, and a sentence for each."""
    return each_told(_laid, recordings, processes)


def _laid(recording: Recording) -> tuple[Recording, str]:
    moved = any(f.kind == "clocks" and f.channel in ("command", "twist") for f in recording.checks)
    found = fitted_delay(recording) if moved and recording.commands is not None else None
    if found is None:
        return recording, ""  # with too few poses for a fit of its own the reader's shift stays
    shift, sd = found
    if not (sd < SURE and abs(shift) < NEAR):
        return recording, ""
    said = f"{recording.source}: its commands, on another clock, are laid {1e3 * shift:+.0f} ms nearer to the poses"
    return with_commands_moved(recording, shift), said
