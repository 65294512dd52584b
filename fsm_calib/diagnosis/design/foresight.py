"""Rolls a manoeuvre out under every explanation: where it leads, and what a tracker would see of it, whitened."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property

import numpy as np

from fsm_calib.diagnosis.design.belief import Belief
from fsm_calib.diagnosis.design.primitives import Pace
from fsm_calib.diagnosis.design.separation import Columns
from fsm_calib.diagnosis.likelihood.robust import Whitener
from fsm_calib.diagnosis.replay.prepared import Prepared, expected
from fsm_calib.diagnosis.replay.simulator import make_simulator
from fsm_calib.recording.channels import CommandTrack, PoseTrack
from fsm_calib.recording.recording import Recording
from fsm_calib.types import FloatArray
from fsm_calib.world2d.rollout import Drive, simulate, simulate_many

Holds = Sequence[tuple[float, float, float]]
LEAD = 0.2  # s at rest before the first command
STEP = 0.01  # s of the roll-outs, as in a fit
PATH_STEP = 0.05  # s between the places of a path that are held against the area


def drive_of(holds: Holds) -> tuple[Drive, float]:
    """Return held commands as a drive that begins after `LEAD` [s], and when it ends [s]."""
    seconds, left, right = np.array(holds, dtype=float).T
    ends = LEAD + np.cumsum(seconds)
    time = np.concatenate([[0.0, LEAD], ends])
    zero = np.zeros(1)
    return (
        Drive(time, np.concatenate([zero, left, zero]), np.concatenate([zero, right, zero])),
        float(ends[-1]),
    )


@dataclass(frozen=True, eq=False)
class Foresight:
    """What a belief expects of manoeuvres; those that do not depend on the place are rolled out once."""

    belief: Belief
    _kept: dict[tuple[Holds, bool], FloatArray] = field(default_factory=dict, repr=False)
    _paths: dict[Holds, FloatArray] = field(default_factory=dict, repr=False)

    @cached_property
    def columns(self) -> Columns:
        """Where everything stands in the Gram matrix: means, the base's numbers, each explanation's own, a zero."""
        b, hypotheses = self.belief.base, self.belief.hypotheses
        own = max(len(h.places) for h in hypotheses) - b
        width = len(hypotheses) + b + sum(len(h.places) - b for h in hypotheses) + 1
        numbers = np.full((len(hypotheses), b + own), width - 1)
        covariances = np.zeros((len(hypotheses), b + own, b + own))
        at = len(hypotheses) + b
        for k, h in enumerate(hypotheses):
            m = len(h.places)
            numbers[k, :b] = len(hypotheses) + np.arange(b)
            numbers[k, b:m] = at + np.arange(m - b)
            covariances[k, :m, :m] = h.covariance
            at += m - b
        return Columns(width, np.arange(len(hypotheses)), numbers, covariances, b)

    @cached_property
    def _rows(self) -> tuple[FloatArray, np.ndarray, FloatArray, np.ndarray]:
        """Return parameter vectors of all columns, the row each is compared with, its step, whether place matters.

        Row 0 is the plain robot. The base's derivatives are taken there: they hardly differ between explanations.
        """
        belief, rows, against, steps, placed = self.belief, [self.belief.plain], [0], [1.0], [False]
        for h in belief.hypotheses:
            rows.append(h.values)
            against.append(0)
            steps.append(1.0)
            placed.append(h.needs_place)
        first = belief.hypotheses[0]
        for k in range(belief.base):
            rows.append(_moved(belief.plain, first.places[k], first.steps[k]))
            against.append(0)
            steps.append(float(first.steps[k]))
            placed.append(False)
        for number, h in enumerate(belief.hypotheses):
            for k in range(belief.base, len(h.places)):
                rows.append(_moved(h.values, h.places[k], h.steps[k]))
                against.append(1 + number)
                steps.append(float(h.steps[k]))
                placed.append(h.needs_place)
        return np.array(rows), np.array(against), np.array(steps), np.array(placed)

    def gram(self, holds: Holds, start: FloatArray) -> FloatArray:
        """Return the Gram matrix (width, width) of a manoeuvre that begins at rest at `start` (x, y [m], theta)."""
        placed = self._rows[3]
        if (holds, False) not in self._kept:
            self._kept[holds, False] = self._white(holds, np.zeros(3), ~placed)
        white = self._kept[holds, False]
        if placed.any():
            white = white.copy()
            white[:, placed[1:]] = self._white(holds, start, placed)[:, placed[1:]]
        return np.asarray(np.pad(white.T @ white, (0, 1)))

    def _white(self, holds: Holds, start: FloatArray, wanted: np.ndarray) -> FloatArray:
        """Return whitened columns (n, width - 1) of the wanted rows; the others are zero."""
        rows, against, steps, _ = self._rows
        needed = wanted.copy()
        needed[against[wanted]] = True
        needed[0] = True
        simulator = make_simulator(self._expected(holds, start))
        seen = np.zeros((len(rows), len(simulator.prepared.time), 5))
        seen[needed] = simulator.increments(rows[needed])
        raw = (seen - seen[against]) / steps[:, None, None]
        raw[~wanted] = 0.0
        whitener = Whitener.at(simulator.prepared, self.belief.noise)
        return whitener.columns(np.ascontiguousarray(np.moveaxis(raw[1:], 0, -1)))

    def _expected(self, holds: Holds, start: FloatArray) -> Prepared:
        """Return the drive that the likeliest explanation expects, at the tracker's frame rate."""
        drive, end = drive_of(holds)
        stamps = np.arange(int(end * self.belief.frame_rate) + 1) / self.belief.frame_rate
        states = simulate(self.belief.leader.values, drive, stamps, start, dt=STEP)
        c, s = np.cos(states[:, 2]), np.sin(states[:, 2])
        ahead, aside = states[:, 3], states[:, 4]
        rates = np.column_stack([c * ahead - s * aside, s * ahead + c * aside, states[:, 5]])
        recording = Recording(
            robot=self.belief.robot,
            command=CommandTrack(drive.time, drive.left, drive.right),
            pose=PoseTrack(stamps, states[:, 0], states[:, 1], states[:, 2]),
            source="a planned drive",
        )
        return expected(recording, rates)

    def paths(self, holds: Holds, starts: FloatArray) -> FloatArray:
        """Return the paths (h, n, 3) of all explanations that begin at rest at `starts` (h, 3)."""
        if holds not in self._paths:
            self._paths[holds] = self.rolled(
                holds, np.array([h.values for h in self.belief.hypotheses]), np.zeros(3)
            )
        return _from_starts(self._paths[holds], starts)

    def rolled(self, holds: Holds, values: FloatArray, start: FloatArray) -> FloatArray:
        """Return the paths (k, n, 3) of parameter vectors (k, p) from one start, a row every `PATH_STEP` [s]."""
        drive, end = drive_of(holds)
        grid = np.arange(0.0, end + PATH_STEP, PATH_STEP)
        return simulate_many(values, drive, grid, start, dt=STEP)[:, :, :3]

    @cached_property
    def pace(self) -> Pace:
        """How fast the likeliest explanation is after a second."""

        @cache
        def after_a_second(left: float, right: float) -> FloatArray:
            drive = Drive(np.zeros(1), np.array([left]), np.array([right]))
            values = self.belief.leader.values
            return np.asarray(simulate(values, drive, np.array([0.0, 1.0]), np.zeros(3), dt=STEP)[1])

        return Pace(
            lambda u: float(abs(after_a_second(u, u)[3])), lambda u: float(abs(after_a_second(-u, u)[5]))
        )


def _moved(values: FloatArray, place: int, step: float) -> FloatArray:
    moved = values.copy()
    moved[place] += step
    return moved


def _from_starts(paths: FloatArray, starts: FloatArray) -> FloatArray:
    """Lay body-frame paths (h, n, 3) at poses (h, 3)."""
    c, s = np.cos(starts[:, 2])[:, None], np.sin(starts[:, 2])[:, None]
    x, y = paths[:, :, 0], paths[:, :, 1]
    out = np.empty_like(paths)
    out[:, :, 0] = starts[:, 0, None] + c * x - s * y
    out[:, :, 1] = starts[:, 1, None] + s * x + c * y
    out[:, :, 2] = starts[:, 2, None] + paths[:, :, 2]
    return out
