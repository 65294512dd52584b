r"""Climbing along a curved valley: steps of Levenberg and Marquardt that bend with it (geodesic acceleration).

    s1 = A^-1 J'W r            A = J'WJ + damping diag(J'WJ), priors in it
    s2 = A^-1 J'W r2           r2 = (2/h) ((r(x + h s1) - r(x)) / h + J s1)
    x <- x + s1 + s2 / 2       where 2 |s2| <= BEND |s1|

r [1] (N,) the whitened innovations at the free numbers x (m,), J (N, m) minus their derivatives, W their robust
weights, h [1] the share of a step after which the bend is measured; the lengths |.| count each number by its own
deviation (the diagonal of J'WJ). Where two numbers do nearly the same, K (u + d) for a motor's gain and what its
driver adds to a command, a straight step leaves the valley at once and is damped until it creeps; one that bends
follows it for the price of one more roll-out.
Source: Transtrum & Sethna, Improvements to the Levenberg-Marquardt algorithm for nonlinear least-squares minimization,
arXiv:1201.5885 (2012), sections 3 and 5.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fsm_calib.diagnosis.fitting.fit import SMALL_GAIN, Engine, Fit, Point, jacobian
from fsm_calib.diagnosis.fitting.newton import damped_step, normal_equations
from fsm_calib.diagnosis.fitting.slot import Slot, slot_bounds, with_slots
from fsm_calib.diagnosis.likelihood.robust import Whitener, robust_weights
from fsm_calib.types import FloatArray

STEPS = 20  # along one valley
AHEAD = 0.1  # of a step: where the bend is measured
BEND = 0.75  # of a step: one that bends more is too long
FIRST_DAMPING, LEAST_DAMPING = 1e-3, 1e-7  # of the normal equations' diagonal
SHORTER, LONGER = 5.0, 0.1  # times the damping after a step that fails, or leads higher
TRIED = 8  # steps that are tried from a point, each shorter than the one before


@dataclass(frozen=True, eq=False)
class Slope:
    """How the residual changes around a point: J (N, m), W (N,), J'WJ (m, m) and J'W r (m,)."""

    columns: FloatArray
    weights: FloatArray
    normal: FloatArray
    gradient: FloatArray


@dataclass(frozen=True, eq=False)
class Valley:
    """The free numbers of one model at one noise, and how to climb along them."""

    engine: Engine
    whiteners: Sequence[Whitener]
    slots: tuple[Slot, ...]
    values: FloatArray

    def climb(self, numbers: FloatArray) -> FloatArray:
        """Return the highest numbers (m,) that are reached from `numbers`."""
        here, damping = self._at(numbers), FIRST_DAMPING
        for _ in range(STEPS):
            there, damping = self._higher(here, self._slope(here), damping)
            gain, here = there.score - here.score, there
            if gain < SMALL_GAIN:
                break
        return here.numbers

    def _at(self, numbers: FloatArray) -> Point:
        values = with_slots(self.values, self.slots, numbers)
        return self.engine.point(self.whiteners, values, self.slots, numbers)

    def _slope(self, here: Point) -> Slope:
        raw = jacobian(self.engine.simulators, here.values, self.slots, here.simulated)
        columns = self.engine.white_columns(self.whiteners, raw)
        nu = self.engine.nu
        normal, gradient = normal_equations(columns, here.residual, self.slots, here.numbers, nu)
        return Slope(columns, robust_weights(here.residual, nu), normal, gradient)

    def _higher(self, here: Point, slope: Slope, damping: float) -> tuple[Point, float]:
        """Return the first higher point along steps that are shorter and shorter, and the next damping."""
        low, high = slot_bounds(self.slots)
        for _ in range(TRIED):
            straight = self._step(slope, slope.gradient, damping, here.numbers)
            bend = self._step(slope, self._bending(here, slope, straight), damping, here.numbers)
            if 2.0 * _length(bend, slope) <= BEND * _length(straight, slope):
                there = self._at(np.clip(here.numbers + straight + 0.5 * bend, low, high))
                if there.score > here.score:
                    return there, max(damping * LONGER, LEAST_DAMPING)
            damping *= SHORTER
        return here, damping

    def _step(self, slope: Slope, gradient: FloatArray, damping: float, numbers: FloatArray) -> FloatArray:
        return damped_step(slope.normal, gradient, damping, self.slots, numbers) - numbers

    def _bending(self, here: Point, slope: Slope, straight: FloatArray) -> FloatArray:
        """Return J'W r2 (m,): the gradient of what a straight step changes to second order."""
        ahead = self._at(here.numbers + AHEAD * straight)
        second = (2.0 / AHEAD) * ((ahead.residual - here.residual) / AHEAD + slope.columns @ straight)
        return np.asarray(slope.columns.T @ (slope.weights * second))


def _length(step: FloatArray, slope: Slope) -> float:
    """Return the length of a step (m,), each number by its own deviation."""
    return float(np.sqrt(np.sum(np.diag(slope.normal) * step * step)))


def along_the_valley(engine: Engine, fit: Fit) -> FloatArray:
    """Return the parameters (R, p) of a fit's model, at its noise, where the valley that it stands in ends."""
    valley = Valley(engine, engine.whiteners(fit.noise), fit.slots, fit.values)
    return with_slots(fit.values, fit.slots, valley.climb(fit.slot_values()))
