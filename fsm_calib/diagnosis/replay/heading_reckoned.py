"""Where does a robot look whose tracker tells only where it is? Headings from the path and the turns of the wheels.

A robot drives where it looks, forward or backward, so the path's direction is its heading up to half a turn; between
clear moves the wheels' difference W tells how it turned, in a unit c that the path itself calibrates:

    c = argmax sum cos 2 (d(k + 1) - d(k) - c (W(k + 1) - W(k))),      theta(t) = c W(t) + slow(t)

d is the direction of the k-th clear move; slow(t) is the mean of d - c W over some seconds. Such headings give the
sensor's frame its direction, good to some hundredths of a radian; they are no measurement and are never scored.
"""

from __future__ import annotations

import numpy as np

from fsm_calib.diagnosis.replay.heading_unwrap import wheels_sum, wheels_turn
from fsm_calib.errors import DataError
from fsm_calib.recording.channels import PoseTrack
from fsm_calib.recording.recording import Recording
from fsm_calib.types import FloatArray

MOVE = 0.4  # s over which a move's direction is taken
CLEAR = 0.4  # of the longest usual move: a shorter one has no direction
SLOW = 2.0  # s over which the path corrects the wheels
LARGEST_TURN = 2.5  # rad between two moves that calibrate: beyond, half turns are lost
STRAIGHT, FAINT = 0.4, 0.02  # rad that a move may turn to count in full; what others count
FEWEST = 15  # moves


def headed_by_wheels(recording: Recording, track: PoseTrack) -> PoseTrack:
    """Return the positions with headings reckoned from the path and the wheels or commands.

    Raises
    ------
    DataError
        Nothing tells how the robot turned, or it hardly moved.
    """
    known = np.isfinite(track.x) & np.isfinite(track.y)
    time, x, y = track.time[known], track.x[known], track.y[known]
    turn, ahead = wheels_turn(recording, time), wheels_sum(recording, time)
    if turn is None or ahead is None or len(time) < FEWEST:
        raise DataError(
            f"{recording.source or recording.robot.name}: no pose channel with a heading, and no wheels or commands",
            cure="Record x, y and theta.",
        )
    first = np.arange(len(time))
    last = np.minimum(np.searchsorted(time, time + MOVE), len(time) - 1)
    dx, dy = x[last] - x[first], y[last] - y[first]
    way = np.hypot(dx, dy)
    clear = way > CLEAR * float(np.quantile(way, 0.95))
    if clear.sum() < FEWEST or float(np.ptp(turn)) == 0.0:
        raise DataError(
            f"{recording.source or recording.robot.name}: headings cannot be reckoned, the robot hardly moved",
            cure="Drive some metres of arcs, or record theta.",
        )
    direction = np.arctan2(dy, dx)[clear]
    middle = 0.5 * (turn[last] + turn[first])[clear]
    scale = _scale(direction, middle)
    straight = np.abs(scale * (turn[last] - turn[first])[clear]) < STRAIGHT
    backward = (ahead[last] - ahead[first])[clear] < 0.0
    # a move that turns much, or whose wheels change their direction, tells no heading
    weight = np.where(straight, 1.0, FAINT) * np.abs((ahead[last] - ahead[first])[clear])
    off = weight * np.exp(1j * (direction + np.pi * backward - scale * middle))
    return PoseTrack(time, x, y, scale * turn + _slow(time, 0.5 * (time[last] + time[first])[clear], off))


def _scale(direction: FloatArray, turn: FloatArray) -> float:
    """Return radians for a unit of the wheels' difference, by the directions of successive moves."""
    turned, told = np.diff(direction), np.diff(turn)
    typical = float(np.quantile(np.abs(told), 0.95)) or 1.0
    tried = np.linspace(-LARGEST_TURN, LARGEST_TURN, 2001) / typical
    scores = [float(np.cos(2.0 * (turned - c * told)).sum()) for c in tried]
    return float(tried[int(np.argmax(scores))])


def _slow(time: FloatArray, at: FloatArray, off: np.ndarray) -> FloatArray:
    """Return the mean angle of `off` (m,) complex at times `at` (m,), over some seconds about each time (n,)."""
    grid = np.arange(time[0], time[-1] + 0.5, 0.5)
    weight = np.exp(-0.5 * ((grid[:, None] - at) / SLOW) ** 2) + 1e-12
    return np.asarray(np.interp(time, grid, np.unwrap(np.angle(weight @ off))))
