r"""Sides and signs that were mixed up: commands or wheels exchanged or reversed, headings a quarter turn off.

A diagnosis that takes them as stated fits a robot that turns against its commands, and names the effect that does so
best. So, before anything is fitted, all drives of a robot are asked at once. Over stretches of a second

    dtheta = J_r q_r - J_l q_l,   J >= 0                dz exp(-i theta_m) = alpha (q_l + q_r) / 2 + beta dtheta

must hold as stated. Where they hold clearly better with other signs these are taken, and told; where the direction of
motion, arg alpha, is a quarter turn or more from the headings, these are turned by whole quarters: what is left is how
the sensor stands on the robot. Symbols as in `identify.align_heading`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from fsm_calib.diagnosis.identify.align import Alignment
from fsm_calib.diagnosis.identify.align_heading import (
    are_exchanged,
    complex_linear,
    forward_of,
    moves_of,
    robust_linear,
)
from fsm_calib.diagnosis.identify.command import asked_travel
from fsm_calib.diagnosis.identify.notes import sign_notes
from fsm_calib.diagnosis.replay.wheels import Wheels, wheels_of
from fsm_calib.errors import DataError
from fsm_calib.recording.channels import PoseTrack, TwistTrack
from fsm_calib.recording.recording import Recording
from fsm_calib.types import FloatArray

EXPLAINED = 0.5  # of the motion may be left where it follows the wheels at all
CLEARLY = 2.0  # times as much must be left as stated
QUARTER = np.pi / 2.0
BOTH = ((1, 1), (-1, -1))  # signs of the two sides of a robot that is told twists
ONE = ((1, -1), (-1, 1))
Travel = Callable[[Recording, PoseTrack], Wheels]
SOURCES: tuple[tuple[str, tuple[str, ...], Travel], ...] = (
    ("commands", ("command", "twist"), asked_travel),
    ("wheel channels", ("wheel_angle", "wheel_rate", "wheel_speed"), lambda r, pose: wheels_of(r)),
)


def as_wired(
    train: Sequence[Recording], new: Sequence[Recording] = ()
) -> tuple[list[Recording], list[Recording], list[str]]:
    """Return both with sides, signs and headings as the drives of `train` tell them, and a sentence for each change."""
    drives, others, told = list(train), list(new), []
    for what, names, travel in SOURCES:
        moves = _moves(drives, travel)
        if moves is None:
            continue
        twists = "twist" in names and any(r.twist is not None for r in drives)
        found = _signs(moves, BOTH if twists else (*BOTH, *ONE))
        quarters = _quarters(found, moves)
        told += sign_notes(found, True, what)
        if quarters:
            told.append(
                f"the robot drives {90 * quarters:+d} deg from where its headings point, as the {what} tell: "
                "they are turned by that"
            )
        drives, others = ([_mended(r, names, found, quarters) for r in group] for group in (drives, others))
    return drives, others, told


def _moves(recordings: Sequence[Recording], travel: Travel) -> tuple[FloatArray, ...] | None:
    """Return q_l, q_r, dtheta and dz exp(-i theta_m) of all drives; None where no drive tells them."""
    found = []
    for recording in recordings:
        pose = recording.pose
        if pose is None or not pose.has_heading or not np.isfinite(pose.x).any():
            continue
        try:
            found.append(moves_of(travel(recording, pose), pose))
        except DataError:
            continue
    return tuple(map(np.concatenate, zip(*found, strict=True))) if found else None


def _signs(moves: tuple[FloatArray, ...], ways: Sequence[tuple[int, int]]) -> Alignment:
    """Return the signs and sides with which the robot turns as measured; those stated, unless others clearly do."""
    left, right, turn, move = moves
    wheels = np.column_stack([-left, right])
    rest = {way: _size(turn - wheels * way @ robust_linear(wheels * way, turn, True)) for way in ways}
    best = min(rest, key=lambda way: rest[way])
    if rest[best] > EXPLAINED * _size(turn) or rest[1, 1] < CLEARLY * rest[best]:
        best = (1, 1)
    exchanged = are_exchanged(best, forward_of(best[0] * left + best[1] * right, turn, move))
    return Alignment(*((1, 1) if exchanged else best), exchanged, 1.0, 1.0, 0.0, 0.0, 0.0)


def _quarters(found: Alignment, moves: tuple[FloatArray, ...]) -> int:
    """Return the quarter turns from the headings to where the robot drives; 0 unless the wheels tell that clearly."""
    left, right, turn, move = moves
    both = 0.5 * (found.left_sign * left + found.right_sign * right)
    _, pivoting = _fitted(turn[:, None], move)
    (alpha, _), driving = _fitted(np.column_stack([both, turn]), move)
    quarters = round(float(np.angle(alpha)) / QUARTER) if driving < EXPLAINED * pivoting else 0
    return abs(quarters) if abs(quarters) == 2 else quarters  # half round is half round either way


def _fitted(design: FloatArray, move: np.ndarray) -> tuple[np.ndarray, float]:
    """Return complex coefficients of `design` (n, k) for the motion [m], and the size of what is left."""
    numbers = complex_linear(design, move)
    return numbers, _size(move - design @ numbers)


def _size(values: np.ndarray) -> float:
    return float(np.sum(np.abs(values)))


def _mended(recording: Recording, names: Sequence[str], found: Alignment, quarters: int) -> Recording:
    """Return the recording with signs and sides of some channels, and its headings, changed."""
    tracks = {name: getattr(recording, name) for name in names}
    changes = {
        name: _changed(t, found) for name, t in tracks.items() if t is not None and not found.as_stated
    }
    if quarters and recording.pose is not None:
        changes["pose"] = replace(recording.pose, theta=recording.pose.theta + quarters * QUARTER)
    return replace(recording, **changes)


def _changed(track: Any, found: Alignment) -> Any:
    """Return a track of commands or wheels with its signs or sides changed; exchanged wheels turn the other way."""
    if isinstance(track, TwistTrack):
        aside = -1 if found.exchanged else found.left_sign
        return replace(track, v=found.left_sign * track.v, omega=aside * track.omega)
    left, right = found.sides(track.left, track.right)
    return replace(track, left=left, right=right)
