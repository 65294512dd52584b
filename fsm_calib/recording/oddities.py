"""What a person would notice when looking at a recording's curves: told, never silently mended.

Each check takes a channel and returns findings. Thresholds are those at which a small wheeled robot would
have to do something it cannot; each is named with its reason.
"""

from __future__ import annotations

import numpy as np

from fsm_calib.recording.channels import CommandTrack, PoseTrack, WheelPair
from fsm_calib.recording.clear_moves import agreement, clear_moves
from fsm_calib.recording.leaps import FASTEST_TURN, FEW_JUMPS, fastest_of, leaps
from fsm_calib.recording.recording import GAP_FACTOR, Finding, Recording
from fsm_calib.recording.runs import runs_of
from fsm_calib.recording.under_way import held_at
from fsm_calib.recording.unknown_commands import unknown_spans
from fsm_calib.types import FloatArray

MOST_JUMPS = 0.5  # share of rows; beyond it the columns are not what they are called
FROZEN_SECONDS = 2.0  # s without any change while another channel shows motion
MOVING_SHARE = 0.05  # of the largest command: less is standing
LONGEST_GAP = 0.5  # s; shorter holes are covered by the robot's own motion
STRANGE_HEADING = 0.5  # resultant of (direction of motion - heading): 1 if the robot drives where it looks
LOOKS_AHEAD = 0.95  # resultant of a robot that drives where it looks; 600 of 624 drives have more
MIRRORED = 1 / 3  # of 1 - resultant that turning the headings round may leave; 1.2 is the least of 624 drives
FEWEST_MOVES = 30  # moves needed to judge headings
DEGREES = 2.0 * np.pi * 1.05  # a wrapped heading beyond it is no radian


def findings_of(recording: Recording) -> list[Finding]:
    """Return all that looks odd."""
    found: list[Finding] = []
    pose = recording.pose
    if pose is not None and len(pose) > 2:
        found += _jumps(pose, fastest_of(recording)) + _gaps(recording) + _headings(pose) + _degrees(pose)
        found += _frozen(recording, pose)
    for name in ("wheel_angle", "wheel_rate", "wheel_speed"):
        found += _one_sided(name, getattr(recording, name))
    found += _lost(recording) + _clipped(recording.command) + _clocks(recording)
    return found


def _jumps(pose: PoseTrack, fastest: float) -> list[Finding]:
    """Tell of poses that no robot could have reached, and of units that make all of them so."""
    far = leaps(pose.time, pose.x, pose.y, pose.theta, fastest)
    count, rows = int(far.sum()), len(far) - 1
    if not count:
        return []
    first = float(pose.time[far][0])
    if count > FEW_JUMPS * rows:
        sentence = (
            f"{count} of {rows} steps beat {fastest:g} m/s or {FASTEST_TURN:g} rad/s: a wrong unit or column?"
        )
        kind = "impossible" if count > MOST_JUMPS * rows else "unit_slip"
        return [Finding("pose", kind, sentence, "kept", count, first)]
    sentence = f"{count} jumps that no robot of this size can make (first at {first:.3f} s); none is fitted"
    return [Finding("pose", "jump", sentence, "kept", count, first)]


def _gaps(recording: Recording) -> list[Finding]:
    pose = recording.pose
    if pose is None:
        return []
    limit = max(LONGEST_GAP, GAP_FACTOR * float(np.median(np.diff(pose.time))))
    gaps = recording.gaps("pose", limit)
    if not gaps:
        return []
    longest = max(end - start for start, end in gaps)
    sentence = f"{len(gaps)} gaps longer than {limit:.2f} s, the longest {longest:.2f} s"
    return [Finding("pose", "gap", sentence, "kept", len(gaps), gaps[0][0])]


def _headings(pose: PoseTrack) -> list[Finding]:
    """Tell where the robot does not drive where it looks (forward or backward)."""
    if not np.isfinite(pose.theta).all():
        return []
    direction, heading = clear_moves(pose)
    if len(direction) < FEWEST_MOVES:
        return []
    agree, mirror = agreement(direction, heading), agreement(direction, -heading)
    mirrored = agree < LOOKS_AHEAD < mirror and 1.0 - mirror < MIRRORED * (1.0 - agree)
    if agree >= STRANGE_HEADING and not mirrored:
        return []
    if mirror > max(STRANGE_HEADING, 1.5 * agree) or mirrored:
        sentence = "the heading turns against the path: x and y are exchanged, or theta is clockwise"
        return [Finding("pose", "mirrored", sentence, "kept", len(direction), float(pose.time[0]))]
    sentence = "the heading has nothing to do with the path: are columns swapped, or is theta in degrees?"
    return [Finding("pose", "heading", sentence, "kept", len(direction), float(pose.time[0]))]


def _degrees(pose: PoseTrack) -> list[Finding]:
    theta = pose.theta[np.isfinite(pose.theta)]
    if len(theta) < 3:
        return []
    size = float(np.abs(theta).max())
    wraps = int((np.abs(np.diff(theta)) > 0.8 * 2.0 * size).sum())
    if size > DEGREES and size <= 361.0 and wraps:
        sentence = f"headings up to {size:.0f} that wrap: degrees in place of radians?"
        return [Finding("pose", "unit_slip", sentence, "kept", len(theta), float(pose.time[0]))]
    return []


def _frozen(recording: Recording, pose: PoseTrack) -> list[Finding]:
    """Tell where the pose stood still to the last digit while the wheels were driven."""
    driven = _driving(recording, pose.time)
    if driven is None:
        return []
    same = (np.diff(pose.x) == 0) & (np.diff(pose.y) == 0) & driven[1:]
    spells = [(pose.time[a], pose.time[min(b, len(pose) - 1)]) for a, b in runs_of(same)]
    long = [(a, b) for a, b in spells if b - a > FROZEN_SECONDS]
    if not long:
        return []
    sentence = f"the pose is frozen for {sum(b - a for a, b in long):.1f} s while the wheels were driven"
    return [Finding("pose", "frozen", sentence, "kept", len(long), float(long[0][0]))]


def _driving(recording: Recording, times: FloatArray) -> np.ndarray | None:
    """Return whether the wheels were driven at `times`; None where no input was logged."""
    track = recording.command or recording.wheel_rate or recording.wheel_speed
    if track is None or not len(track):
        return None
    size = np.maximum(np.abs(track.left), np.abs(track.right))
    return held_at(track, size > MOVING_SHARE * max(float(size.max()), 1e-12), times)


def _one_sided(name: str, track: WheelPair | None) -> list[Finding]:
    """Tell of a wheel that never moved while the other did."""
    if track is None or len(track) < 3:
        return []
    spread = [float(np.ptp(side)) for side in (track.left, track.right)]
    if min(spread) == 0.0 and max(spread) > 0.0:
        side = "left" if spread[0] == 0.0 else "right"
        sentence = f"the {side} column never changes while the other does: a dead sensor or wheel?"
        return [Finding(name, "frozen", sentence, "kept", len(track), float(track.time[0]))]
    return []


def _lost(recording: Recording) -> list[Finding]:
    """Tell of commands that never reached the log, and for how long nobody knows them."""
    track = recording.commands
    if track is None or track.lost is None or not track.lost.any():
        return []
    missing, rows = int(track.lost.sum()), np.flatnonzero(track.lost)
    dark = np.diff(unknown_spans(track), axis=1)
    since = float(track.time[max(int(rows[0]) - 1, 0)])
    leaps = "once" if len(rows) == 1 else f"{len(rows)} times, first"
    sentence = (
        f"{missing} commands never reached the log (their numbers leap {leaps} after {since:.2f} s); what the robot "
        f"did for these {float(dark[np.isfinite(dark)].sum()):.1f} s is left out"
    )
    name = "command" if recording.command is not None else "twist"
    return [Finding(name, "lost", sentence, "kept", missing, since)]


def _clipped(command: CommandTrack | None) -> list[Finding]:
    if command is None or command.unit != "normalized" or not len(command):
        return []
    far = np.maximum(np.abs(command.left), np.abs(command.right)) > 1.0 + 1e-6
    if not far.any():
        return []
    first = float(command.time[far][0])
    sentence = (
        f"{int(far.sum())} commands lie beyond -1 to 1 (first at {first:.3f} s); a diagnosis drives its simulation "
        "by full command there, unless the robot clearly followed them"
    )
    return [Finding("command", "unit_slip", sentence, "kept", int(far.sum()), first)]


def _clocks(recording: Recording) -> list[Finding]:
    """Tell of channels that hardly share any time: their clocks have different zeros."""
    spans = {name: (c.time[0], c.time[-1]) for name, c in recording.channels.items() if len(c) > 1}
    found = []
    reference = next(iter(spans), None)
    for name, (start, end) in spans.items():
        first, last = spans[reference] if reference else (start, end)
        shared = min(end, last) - max(start, first)
        shortest = min(end - start, last - first)
        if shared < 0.2 * shortest:
            sentence = f"hardly shares time with {reference}: the two clocks have different zeros"
            found.append(Finding(name, "clocks", sentence, "kept", 0, float(start)))
    return found
