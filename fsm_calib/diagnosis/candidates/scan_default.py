"""Where or when could it be, for an effect that has no scan of its own? Tried by simulation, its strengths scaled.

Each candidate is simulated with the effect's declared start values; the change that this makes in the increments is
judged by the likelihood that it wins as it is, and scaled by what the data ask for within a factor of four (a secant:
exact for what is linear in its strength). Slower than the scans that know what an effect acts on (`scan.py`), and for
any effect of a place, a moment or a span.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import islice, pairwise, product

import numpy as np

from fsm_calib.diagnosis.candidates.distinct import apart
from fsm_calib.diagnosis.candidates.scan_areas import ROUNDS, Area, boxes, neighbours
from fsm_calib.diagnosis.candidates.scan_spans import Span, likely_span
from fsm_calib.diagnosis.candidates.scan_tried import responses
from fsm_calib.diagnosis.fitting.fit import AT_A_TIME, Fit
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.diagnosis.replay.simulator import Simulator
from fsm_calib.diagnosis.shapes.score_tests import NO_POWER, Residual, free_part, winnings
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import Effect

LARGEST_RESCALE = 4.0  # a secant is trusted over a factor of four in amplitude
EACH = 2  # start values of a strength: what the data ask for is within the factor of one of them
MOST_STRENGTHS = 4  # combinations of start values that are tried at every place
SETTLE_STEPS = (0.06, 0.03)  # m, by which centre and edges of the best places are moved
KEPT = 3
PLACES_APART = 0.18  # m
MOMENT_STEP, MOMENTS_APART = 0.25, 1.0  # s

Changes = Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Trial:
    """An effect tried out over one parent fit."""

    effect: Effect
    parent: Fit
    residual: Residual

    def strengths(self) -> list[dict[str, float]]:
        """Return combinations of the declared start values of the strengths, by full name; typical where none are."""
        name, values = self.effect.name, []
        for p in self.effect.parameters:
            if p.strength and p.fitted:
                starts = p.starts[:EACH] or (p.typical,)
                values.append([(f"{name}.{p.name}", x) for x in starts if x != p.null])
        return [dict(chosen) for chosen in islice(product(*(v for v in values if v)), MOST_STRENGTHS)]

    def promises(self, candidates: Sequence[Changes]) -> FloatArray:
        """Return the log-likelihood (m,) that each candidate promises with its strengths scaled."""
        engine, found = self.residual.engine, [np.empty(0)]
        for first in range(0, len(candidates), AT_A_TIME):
            columns = responses(self.parent, engine, candidates[first : first + AT_A_TIME])
            found.append(self.of_columns(columns))
        return np.concatenate(found)

    def of_columns(self, columns: Sequence[FloatArray]) -> FloatArray:
        """Return what simulated changes (n, 5, m) of each recording promise, (m,): as they are, or scaled."""
        white = self.residual.engine.white_columns(self.residual.whiteners, columns)
        x = free_part(self.residual, white)
        size = x.T @ self.residual.psi / np.maximum(np.sum(x * x, axis=0), NO_POWER)
        scale = np.clip(np.abs(size), 1.0 / LARGEST_RESCALE, LARGEST_RESCALE) * np.sign(size)
        scale = np.where((size > 0.0) | self._two_sided(), scale, 0.0)
        scaled = winnings(self.residual, white * scale)
        return np.maximum(np.maximum(winnings(self.residual, white), scaled), 0.0)

    def _two_sided(self) -> bool:
        return any(p.strength and p.low < p.null for p in self.effect.parameters)


def tried_places(
    trial: Trial, centres: FloatArray, size: float = 1.0
) -> list[tuple[dict[str, float], float]]:
    """Return the most promising places about `centres` (m, 2) [m], moved and resized uphill: changes, promise.

    size : of the robot, as `robot_size` tells it.
    """
    found = []
    for strength in trial.strengths():
        areas = boxes(centres, size)
        promise = trial.promises([{**area.numbers(trial.effect), **strength} for area in areas])
        at = np.array([(area.x, area.y) for area in areas])
        found += [
            (areas[i], strength, float(promise[i])) for i in apart(promise, at, KEPT, size * PLACES_APART)
        ]
    found.sort(key=lambda place: -place[2])
    at, promise = np.array([(a.x, a.y) for a, _, _ in found]), np.array([p for _, _, p in found])
    kept = apart(promise, at, KEPT, size * PLACES_APART) if found else []
    return [_settled(trial, *found[i], size) for i in kept]


def _settled(
    trial: Trial, area: Area, strength: Changes, promise: float, size: float
) -> tuple[dict[str, float], float]:
    """Move and resize a place while that promises more."""
    best, gain = area, promise
    for step in (size * step for step in SETTLE_STEPS):
        for _ in range(ROUNDS):
            tried = {tuple(a.numbers(trial.effect).values()): a for a in neighbours(best, step)}
            areas = list(tried.values())
            promises = trial.promises([{**a.numbers(trial.effect), **strength} for a in areas])
            i = int(np.argmax(promises))
            if promises[i] <= gain:
                break
            best, gain = areas[i], float(promises[i])
    return best.numbers(trial.effect), gain


def tried_span(trial: Trial, run: int, strength: Changes) -> Span:
    """Return the most promising span of one recording, at `strength`; the response to each cell is simulated."""
    simulator = trial.residual.engine.simulators[run]

    def cells(edges: FloatArray) -> FloatArray:
        times = [
            {f"{trial.effect.name}.start": float(a), f"{trial.effect.name}.duration": float(b - a)}
            for a, b in pairwise(edges)
        ]
        return _simulated(trial, simulator, run, [{**strength, **time} for time in times])

    return likely_span(trial.residual, run, cells, (1.0 / LARGEST_RESCALE, LARGEST_RESCALE))


def tried_moments(trial: Trial, run: int, strength: Changes) -> tuple[FloatArray, FloatArray]:
    """Return moments (m,) [s] of one recording and what the effect promises there, (m,)."""
    simulator, name = trial.residual.engine.simulators[run], trial.effect.name
    time = simulator.prepared.time
    starts = np.arange(max(float(time[0]), 0.0) + 0.5, float(time[-1]) - 1.0, MOMENT_STEP)
    candidates = [{**strength, f"{name}.start": float(start)} for start in starts]
    return starts, trial.of_columns(_alone(trial, run, _simulated(trial, simulator, run, candidates)))


def _simulated(trial: Trial, simulator: Simulator, run: int, candidates: Sequence[Changes]) -> FloatArray:
    """Return what candidates change in the increments of one recording, (n, 5, m)."""
    values, before = trial.parent.values[run : run + 1], trial.parent.simulated[run]
    changed = simulator.increments(np.vstack([with_values(values, c) for c in candidates]))
    return np.moveaxis(changed - before, 0, 2)


def _alone(trial: Trial, run: int, columns: FloatArray) -> list[FloatArray]:
    """Return columns (n, 5, m) of one recording, and nothing for the others."""
    blocks = [np.zeros((*s.shape, columns.shape[2])) for s in trial.parent.simulated]
    blocks[run] = columns
    return blocks
