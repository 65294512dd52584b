"""Why recordings do not tell where a robot pulls, and what would."""

from __future__ import annotations

from collections.abc import Sequence

from fsm_calib.recording.recording import Recording


def why_no_pull(recordings: Sequence[Recording]) -> str:
    """Return the reason and its cure, without a full stop; a pull is told by the commands of each wheel."""
    first = recordings[0]
    if first.twist is not None:
        return (
            "its commands are speeds of the robot, not of its wheels; record the wheels' own commands, or let "
            "fsm-calib diagnose --report DIR fit the gain of each wheel"
        )
    if first.command is None:
        return "no commands were recorded; record those of the wheels"
    return "drive straights and arcs to both sides, and record poses beside the wheels' commands"
