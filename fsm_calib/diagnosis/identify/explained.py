"""Whether commands moved the robot at all, asked before anything is fitted: other commands fit, too, and badly.

Over stretches of a second the turn and the forward motion y are regressed on both commands' integrals at several
lags X (a short impulse response, so that signs, gains, time constants and delays need not be known), and judged on
stretches that the regression has not seen:

    R2 = 1 - sum (y - X w)^2 / sum (y - mean y)^2        w from the other three quarters of the recording

with both sums' terms cut at the 98th percentile, against outliers. Real robots reach 0.6 to 1.0 in the turn or in the
forward motion; commands of another drive reach 0.4 at most and -0.1 in the median, 99 of 100 stay below the limit.
Where no heading was measured, a path alone separates the two too badly to refuse by; there, and behind this check, a
fit in which both time constants are longer than any robot's says the same.
"""

from __future__ import annotations

import numpy as np

from fsm_calib.errors import DataError
from fsm_calib.recording.channels import PoseTrack
from fsm_calib.recording.recording import Recording, held_integral
from fsm_calib.types import FloatArray

STRETCH = 1.0  # s
STEP = 0.5  # s from one stretch to the next
LAGS = (0.0, 0.3, 0.6, 1.0, 2.0)  # s
PARTS = 4  # of the recording; each is judged by the others
LEAST_SHARE = 0.3  # half of the least that real robots reach
FEWEST_STRETCHES = 30  # fewer tell nothing: three for each column of the regression
SLOWEST = 5.0  # s; real robots settle within one
LEAST_TURN, LEAST_WAY = 0.1, 0.03  # rad, m: deviation over stretches below which there is nothing to explain
FARTHEST = 98.0  # percentile at which single stretches are cut
DAMPING = 1e-3  # of the regression, as a share of its columns' mean power


def refuse_unexplained(recording: Recording) -> None:
    """Raise DataError where the robot's motion changes and its commands have nothing to do with that."""
    shares = explained_shares(recording)
    if shares and max(shares.values()) < LEAST_SHARE:
        said = " and ".join(f"{max(share, 0.0):.0%} of the {name}" for name, share in shares.items())
        raise _unexplained(recording, said)


def refuse_slow(recording: Recording, tau_forward: float, tau_turn: float) -> None:
    """Raise DataError where the fit of commands found no robot: both time constants [s] are longer than any has."""
    if min(tau_forward, tau_turn) > SLOWEST:
        raise _unexplained(recording, f"it would take {tau_forward:.0f} and {tau_turn:.0f} s to follow them")


def _unexplained(recording: Recording, why: str) -> DataError:
    return DataError(
        f"the commands do not explain the motion of {recording.source or 'the recording'}: {why}",
        cure="Are commands and poses of the same drive and robot, and do their clocks agree?",
    )


def explained_shares(recording: Recording) -> dict[str, float]:
    """Return R2 of the turn and of the forward motion, of those that change; empty where too little is known."""
    pose, commands = recording.pose, _commands(recording)
    if pose is None or commands is None or not len(commands[0]) or not pose.has_heading:
        return {}
    track = pose.rows(np.isfinite(pose.theta))
    starts = _starts(track.time, commands[0])
    if len(starts) < FEWEST_STRETCHES:
        return {}
    turn, way = _motion(track, starts)
    columns = _columns(commands, starts, float(track.time[-1]))
    told = {"turning": (turn, LEAST_TURN), "driving": (way, LEAST_WAY)}
    return {name: _share(columns, y) for name, (y, least) in told.items() if float(np.std(y)) > least}


def _commands(recording: Recording) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """Return times and both commands."""
    if recording.command is not None:
        return recording.command.time, recording.command.left, recording.command.right
    if recording.twist is not None:
        return recording.twist.time, recording.twist.v, recording.twist.omega
    return None


def _starts(seen: FloatArray, commanded: FloatArray) -> FloatArray:
    """Return starts of stretches [s] that hold two poses and have commands before them."""
    if len(seen) < 2:
        return np.zeros(0)
    starts = np.arange(max(seen[0], commanded[0] + LAGS[-1]), min(seen[-1], commanded[-1]) - STRETCH, STEP)
    rows = np.searchsorted(seen, starts + STRETCH) - np.searchsorted(seen, starts)
    return starts[rows >= 2]


def _motion(track: PoseTrack, starts: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return turn [rad] and forward motion [m], in the middle heading's frame, over each stretch."""
    heading, ends = np.unwrap(track.theta), starts + STRETCH
    (x0, y0, first), (x1, y1, last) = (
        [np.interp(times, track.time, values) for values in (track.x, track.y, heading)]
        for times in (starts, ends)
    )
    middle = (first + last) / 2.0
    return last - first, (x1 - x0) * np.cos(middle) + (y1 - y0) * np.sin(middle)


def _columns(
    commands: tuple[FloatArray, FloatArray, FloatArray], starts: FloatArray, end: float
) -> FloatArray:
    """Return the integrals of both commands over each stretch, at each lag."""
    time, *sides = commands
    columns = []
    for side in sides:
        times, integral = held_integral(time, side, end)
        for lag in LAGS:
            late = starts - lag
            columns.append(np.interp(late + STRETCH, times, integral) - np.interp(late, times, integral))
    return np.stack(columns, axis=1)


def _share(columns: FloatArray, y: FloatArray) -> float:
    """Return R2 of y on stretches that the regression has not seen."""
    design = np.column_stack([columns, np.ones(len(y))])
    part = np.arange(len(y)) * PARTS // len(y)
    left, whole = np.zeros(len(y)), np.zeros(len(y))
    for unseen in (part == number for number in range(PARTS)):
        seen = design[~unseen]
        power = seen.T @ seen
        power += DAMPING * np.trace(power) / len(power) * np.eye(len(power))
        weights = np.linalg.solve(power, seen.T @ y[~unseen])
        left[unseen] = y[unseen] - design[unseen] @ weights
        whole[unseen] = y[unseen] - y[~unseen].mean()
    cut = float(np.percentile(np.abs(whole), FARTHEST))
    rest, all_of_it = (float((np.minimum(np.abs(e), cut) ** 2).sum()) for e in (left, whole))
    return 1.0 - rest / max(all_of_it, 1e-300)
