"""Wheels whose clock wanders: rows stamped by counting them are laid on the clock of what tells how the robot moved.

A table of wheel rates with one time step throughout was often never stamped: its rows were numbered. Where messages
were lost, late or doubled, its clock then runs ahead and falls back by a second within a minute (`BorealTC`, LaRocque
et al., IROS 2024, indoor flooring), and a body seems to follow its wheels late, here and there early. No physics does.

The lag tau(t) [s] by which the poses follow the wheels is a random walk with Laplace steps over cells of `CELL` s,

    log p(tau) = sum_c log Laplace(tau_c - tau_(c-1); WALK),

and the moves z_i between poses are, in each column (turn [rad]; way forward [m]),

    z_i = [dl_i(tau), dr_i(tau)] b + sigma e_i,

with dl, dr the wheels' travel over the same time, tau earlier, and e of Student's distribution. The likeliest walk is
found exactly (Viterbi), b and sigma are fitted again along it, in turns. All is asked of wheels whose difference acts
through play, too: treads that stick (`skid_steer`) turn the body late after a turn the other way, which looks like a
lag that comes and goes. It is a wandering clock where the walk is clearly more probable than every constant, drifting
or bending lag: those are delays and drifting clocks, which have names and stay. Of a clock that wanders nobody can tell
a delay of the robot, so the whole walk is put down to it, and told.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fsm_calib.diagnosis.each_told import each_told
from fsm_calib.diagnosis.inputs import driving_rates, with_driving_rates
from fsm_calib.diagnosis.pose_moves import log_densities, log_likelihood_of, moves_between, student_fit
from fsm_calib.recording.channels import PoseTrack, WheelPair
from fsm_calib.recording.recording import Recording
from fsm_calib.recording.wheel_stamps import travel
from fsm_calib.types import FloatArray

CELL = 4.0  # s in which the lag is one number
LAGS: FloatArray = np.asarray(np.arange(-30, 31) * 0.05)  # s: real ones wander by 1.2, and start anywhere
TWISTS = (0.02, 0.04, 0.08)  # rad by which treads are twisted before they turn the body (`skid_steer`)
WALK = 0.1  # s, scale of a step from cell to cell
SHORTEST_STEP = 0.2  # s between the poses that are compared
FEWEST_CELLS = 8  # a bent lag has three numbers; less than half a minute tells no walk from it
CLEARLY = 30.0  # log-likelihood units; 29 real tables that do not wander have -1 and less, three that do 149 and more
LEAST_STEP = 1e-6  # s between rows that the walk lays on one another
ROUNDS = 8  # of walk and coefficients in turns


@dataclass(frozen=True)
class Walk:
    """How far the poses follow the wheels late: `lag` [s] at `time` [s], shape (cells,), linear between."""

    time: FloatArray
    lag: FloatArray


@dataclass(frozen=True)
class _Moves:
    """What is compared: `moved` (n, columns), the cell of each (n,), and the wheels' travel by lag (lags, n, 2)."""

    moved: FloatArray
    cell: np.ndarray
    travelled: FloatArray

    @classmethod
    def of(
        cls, steps: FloatArray, moved: FloatArray, cell: np.ndarray, ways: tuple[FloatArray, ...]
    ) -> _Moves:
        """Shift `steps` (n, 2) [s] by each lag; `ways` are times [s] and the travel of both wheels there."""
        time, *sides = ways
        shifted = steps[None] - LAGS[:, None, None]
        travelled = [np.diff(np.interp(shifted, time, side))[..., 0] for side in sides]
        return cls(moved, cell, np.stack(travelled, axis=2))

    def log_likelihood(self, laws: Sequence[tuple[FloatArray, float]]) -> FloatArray:
        """Return the log density of each move at each lag, shape (lags, n)."""
        sums = np.zeros(self.travelled.shape[:2])
        for column, (gains, scale) in zip(self.moved.T, laws, strict=True):
            sums += log_densities(column - self.travelled @ gains, scale)
        return sums

    def design(self, at: np.ndarray) -> FloatArray:
        """Return the wheels' travel (n, 2) where the moves lag by `LAGS[at]`, at (n,)."""
        return np.asarray(self.travelled[at, np.arange(len(at))])

    def laws(self, at: np.ndarray) -> list[tuple[FloatArray, float]]:
        """Return gains (2,) and scale of each column where the moves lag by `LAGS[at]`, at (n,)."""
        return [student_fit(self.design(at), column) for column in self.moved.T]

    def best(self, at: np.ndarray) -> float:
        """Return the log-likelihood where the moves lag by `LAGS[at]`, at (n,), gains and scales fitted."""
        return log_likelihood_of(self.moved, self.design(at))

    @cached_property
    def steady(self) -> tuple[float, int]:
        """Return the log-likelihood of the best lag that stays, and its row of `LAGS`."""
        return max((self.best(np.full(len(self.cell), i)), i) for i in range(len(LAGS)))


def with_steady_clocks(recordings: list[Recording], processes: int = 1) -> tuple[list[Recording], list[str]]:
    """Return the recordings with wheels of a wandering clock laid on the poses' clock, and a sentence for each."""
    return each_told(_laid, recordings, processes)


def _laid(recording: Recording) -> tuple[Recording, str]:
    pair, pose = driving_rates(recording), recording.pose
    walk = wandering(pair, pose) if pair is not None and pose is not None else None
    if pair is None or walk is None:
        return recording, ""
    later = pair.time + np.interp(pair.time, walk.time, walk.lag)
    time = np.maximum.accumulate(later) + LEAST_STEP * np.arange(len(pair))
    said = (
        f"{recording.source}: the wheels' clock wanders by {np.ptp(walk.lag):.1f} s beside the poses' (were its rows "
        "stamped by counting?) and is laid on theirs: no delay can be told; record the stamps of the messages"
    )
    return with_driving_rates(recording, replace(pair, time=time)), said


def wandering(pair: WheelPair, pose: PoseTrack) -> Walk | None:
    """Return how far the poses follow the wheels late over the recording; None where a bent line tells it as well."""
    step = float(np.median(np.diff(pair.time))) if len(pair) > 1 else np.inf
    moves = moves_between(pose, max(step, SHORTEST_STEP))
    if moves is None or pair.duration is not None:
        return None
    steps, moved = moves
    cell = ((steps[:, 0] - steps[0, 0]) / CELL).astype(int)
    if cell[-1] + 1 < FEWEST_CELLS:
        return None
    ways = travel(pair)
    at_once = _Moves.of(steps, moved, cell, ways)
    (gains, _), *_ = at_once.laws(np.full(len(cell), at_once.steady[1]))
    # of the body [rad] for each unit of the wheels' difference
    turn = max(0.5 * abs(float(gains[1] - gains[0])), 1e-9)
    stuck = [_stuck(*ways, slack=twist / turn) for twist in TWISTS]
    found = [_walk(told) for told in (at_once, *(_Moves.of(steps, moved, cell, late) for late in stuck))]
    score, path, _ = max(found, key=lambda walk: walk[0])
    if score - max(others for _, _, others in found) < CLEARLY:
        return None
    return Walk(steps[0, 0] + CELL * (np.arange(len(path)) + 0.5), np.asarray(LAGS[path]))


def _walk(told: _Moves) -> tuple[float, np.ndarray, float]:
    """Return the log-probability of the likeliest walk, the walk as rows of `LAGS`, and the best of what has a name."""
    steady, at = told.steady
    path, score = np.full(told.cell[-1] + 1, at), steady
    for _ in range(ROUNDS):
        path, score = _likeliest_walk(_by_cell(told.log_likelihood(told.laws(path[told.cell])), told.cell))
    return score, path, max(steady, _bent(told, path))


def _stuck(time: FloatArray, left: FloatArray, right: FloatArray, slack: float) -> tuple[FloatArray, ...]:
    """Return the travel of wheels (n,) whose difference acts through play of half width `slack`, in its unit."""
    passed, ahead = np.zeros(len(time)), 0.0
    for i, more in enumerate(np.diff(right - left), start=1):
        held = min(max(ahead + more, -slack), slack)
        passed[i], ahead = passed[i - 1] + ahead + more - held, held
    mean = 0.5 * (left + right)
    return time, mean - 0.5 * passed, mean + 0.5 * passed


def _bent(told: _Moves, path: np.ndarray) -> float:
    """Return the log-likelihood of the lags on the line, or the parabola, that follows the walk best."""
    cells = np.arange(len(path))
    curves = [np.polyval(np.polyfit(cells, LAGS[path], degree), cells) for degree in (1, 2)]
    nearest = [np.abs(LAGS[:, None] - curve).argmin(axis=0) for curve in curves]
    return max(told.best(at[told.cell]) for at in nearest)


def _by_cell(density: FloatArray, cell: np.ndarray) -> FloatArray:
    """Return the sums of `density` (lags, n) over the moves of each cell, shape (cells, lags)."""
    sums = np.zeros((cell[-1] + 1, len(density)))
    np.add.at(sums, cell, density.T)
    return sums


def _likeliest_walk(likelihood: FloatArray) -> tuple[np.ndarray, float]:
    """Return the likeliest lag of each cell as rows of `LAGS`, (cells,), and the log of its prior times likelihood."""
    step = -np.abs(LAGS[:, None] - LAGS[None]) / WALK
    step -= np.log(np.exp(step).sum(axis=0, keepdims=True))
    value, before = likelihood[0] - np.log(len(LAGS)), []
    for row in likelihood[1:]:
        reached = value[:, None] + step
        before.append(reached.argmax(axis=0))
        value = reached.max(axis=0) + row
    path = [int(value.argmax())]
    for came_from in reversed(before):
        path.append(int(came_from[path[-1]]))
    return np.array(path[::-1]), float(value.max())
