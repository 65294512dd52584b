"""The fit: Student-t reweighted Gauss-Newton on whitened innovations, never worse than where it started.

Minimises -log L(parameters) for fixed noise. Jacobian columns are finite differences of the simulated increments,
whitened by the same filter as the residual. Columns of parameters that a parent fit already differentiated may be
reused (chord method): they change little when an effect is added, and the likelihood, not the Jacobian, decides
whether a step is taken. Source: Nocedal & Wright, Numerical Optimization, 2nd ed. 2006, chapter 10.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fsm_calib.diagnosis.fitting.newton import clipped, damped_step, log_prior, normal_equations, promised
from fsm_calib.diagnosis.fitting.slot import ALL_RUNS, Slot, slot_bounds, slot_numbers, with_slots
from fsm_calib.diagnosis.likelihood.noise import JITTER, Noise
from fsm_calib.diagnosis.likelihood.robust import Whitener, fit_noise, log_density
from fsm_calib.diagnosis.replay.simulator import Simulator
from fsm_calib.types import FloatArray
from fsm_calib.world2d.parameters import parameter_table

SMALL_GAIN = 0.1  # log-likelihood units: a smaller gain ends the iteration

AT_A_TIME = 16  # columns that are worked on at once
SAMPLED = 64  # rows of a column that are looked at first
REMEMBERED = 4  # filters at so many noises
NEGLIGIBLE = 0.01  # log-likelihood units: a fit that may be given up does not try a step that promises less
OPTIMISM = 3.0  # a fit is given up where even so many times the promise of its step would not fulfil its hope
TRUSTED = 0.6  # a Jacobian whose promise came true to this share serves for the next step, too (chord method)
LEAST_DAMPING = 1e-6  # of the normal equations' diagonal
DAMPED = 5  # steps that are tried, each shorter than the one before
PATIENCE = 2  # steps within which a fit must show that it gets anywhere


@dataclass(frozen=True, eq=False)
class Fit:
    """A fitted model of R recordings.

    values : (R, p) parameters; slots : what was free; noise; log_likelihood at `values`; log_prior; covariance :
    (m, m) of the slots; simulated : increments (n, 5) of each recording; jacobians : the raw Jacobian in parts, each
    (n, 5, m_i) for every recording. A fit on top of another shares the part that it took over.
    """

    values: FloatArray
    slots: tuple[Slot, ...]
    noise: Noise
    log_likelihood: float
    log_prior: float
    covariance: FloatArray
    simulated: tuple[FloatArray, ...]
    jacobians: tuple[Sequence[FloatArray], ...]

    @cached_property
    def columns(self) -> tuple[FloatArray, ...]:
        """The raw Jacobian (n, 5, m) of each recording."""
        return tuple(
            parts[0] if len(parts) == 1 else np.concatenate(parts, axis=2)
            for parts in zip(*self.jacobians, strict=True)
        )

    @property
    def parts(self) -> tuple[object, ...]:
        """The large parts that fits on top of this one hold, too (`workers.each`)."""
        arrays = [*self.simulated, *(block for part in self.jacobians for block in part)]
        return (
            self,
            self.values,
            self.noise,
            self.simulated,
            *self.jacobians,
            self.columns,
            *self.columns,
            *arrays,
        )

    @property
    def score(self) -> float:
        """Log-likelihood plus log-prior: what the fit maximises."""
        return self.log_likelihood + self.log_prior

    @property
    def size(self) -> int:
        """How many numbers were free: those in the slots, and the jitter of commands where there is one."""
        return len(self.slots) + int(self.noise.jitter > 0.0)

    def slot_values(self) -> FloatArray:
        """Return the current numbers in the slots, shape (m,)."""
        return slot_numbers(self.values, self.slots)

    def slot_bounds(self) -> FloatArray:
        """Return the lowest and the highest numbers that the slots may have, shape (2, m)."""
        return slot_bounds(self.slots)

    def numbers(self) -> Iterator[tuple[Slot, float, float]]:
        """Yield each slot with its number and the variance of it."""
        variances = np.diagonal(self.covariance)
        for slot, value, variance in zip(self.slots, self.slot_values(), variances, strict=True):
            yield slot, float(value), float(variance)

    def runs_of(self, effect: str) -> tuple[int, ...]:
        """Return the recordings in which an effect has numbers of their own."""
        owner = parameter_table().owner
        return tuple(sorted({s.run for s in self.slots if s.run != ALL_RUNS and owner[s.place] == effect}))


def simulate_all(simulators: Sequence[Simulator], values: FloatArray) -> tuple[FloatArray, ...]:
    """Return the simulated increments of every recording at its own parameters, `values` (R, p)."""
    return tuple(s.increments(v[None])[0] for s, v in zip(simulators, values, strict=True))


def jacobian(
    simulators: Sequence[Simulator],
    values: FloatArray,
    slots: Sequence[Slot],
    simulated: Sequence[FloatArray],
) -> tuple[FloatArray, ...]:
    """Return the finite-difference Jacobian of the increments, (n, 5, m) for each recording."""
    columns = []
    for run, (simulator, here) in enumerate(zip(simulators, simulated, strict=True)):
        rows, where, steps = [], [], []
        for j, slot in enumerate(slots):
            if slot.run in (ALL_RUNS, run):
                now = values[run, slot.place]
                step = slot.step if now + slot.step <= slot.high else -slot.step
                vector = values[run].copy()
                vector[slot.place] = now + step
                rows.append(vector)
                where.append(j)
                steps.append(step)
        full = np.zeros((*here.shape, len(slots)))
        if rows:
            moved = simulator.increments(np.array(rows))
            full[:, :, where] = np.moveaxis((moved - here) / np.array(steps)[:, None, None], 0, -1)
        columns.append(full)
    return tuple(columns)


def _whiten_into(out: FloatArray, whitener: Whitener, columns: FloatArray) -> None:
    """Whiten columns (n, 5, m) into `out` (N, m), some at a time; those that are zero here cost nothing."""
    used = np.flatnonzero(_nonzero(columns))
    if len(used) == columns.shape[2] <= AT_A_TIME:
        out[:] = whitener.columns(columns)
        return
    out[:] = 0.0
    for begin in range(0, len(used), AT_A_TIME):
        some = used[begin : begin + AT_A_TIME]
        out[:, some] = whitener.columns(columns[:, :, some])


def _nonzero(columns: FloatArray) -> NDArray[np.bool_]:
    """Return which columns (n, 5, m) hold anything, (m,): most show it in the first row of a few that is looked at."""
    found = np.asarray(columns[:: max(1, len(columns) // SAMPLED)].any(axis=(0, 1)))
    rest = np.flatnonzero(~found)
    found[rest] = columns[:, :, rest].any(axis=(0, 1))
    return found


@dataclass(frozen=True, eq=False)
class WhiteKnown:
    """Raw columns of a parent fit, the filters that they passed, and what came out, (N, q)."""

    raw: Sequence[FloatArray]
    whiteners: Sequence[Whitener]
    white: FloatArray


@dataclass(frozen=True, eq=False)
class Point:
    """Where a fit stands: parameters (R, p), those of its slots (m,), what they simulate, leave (N,) and score."""

    values: FloatArray
    numbers: FloatArray
    simulated: tuple[FloatArray, ...]
    residual: FloatArray
    score: float


@dataclass(frozen=True, eq=False)
class Engine:
    """The recordings of one robot and how to fit them.

    It remembers filters and whitened columns that many fits in a row share; results do not depend on it.
    """

    simulators: tuple[Simulator, ...]
    _filters: dict[bytes, list[Whitener]] = field(default_factory=dict, init=False, repr=False)
    _last_known: list[WhiteKnown] = field(default_factory=list, init=False, repr=False)

    @property
    def nu(self) -> float:
        """Degrees of freedom of the innovations' t distribution."""
        return self.simulators[0].prepared.settings.degrees_of_freedom

    @property
    def processes(self) -> int:
        """How many processes may fit side by side."""
        return self.simulators[0].prepared.settings.processes

    @property
    def count(self) -> int:
        """The number of scored innovations N."""
        return sum(s.prepared.innovations for s in self.simulators)

    def whiteners(self, noise: Noise) -> list[Whitener]:
        """Return one filter a recording; the last few noises are remembered, since many fits share one."""
        key = noise.vector().tobytes()
        kept = self._filters
        if key not in kept:
            if len(kept) >= REMEMBERED:
                kept.pop(next(iter(kept)))
            kept[key] = [Whitener.at(s.prepared, noise) for s in self.simulators]
        return kept[key]

    def log_likelihood(self, whiteners: Sequence[Whitener], simulated: Sequence[FloatArray]) -> float:
        """Return the log-likelihood of simulated increments."""
        return self.judged(whiteners, simulated)[1]

    def residual(self, whiteners: Sequence[Whitener], simulated: Sequence[FloatArray]) -> FloatArray:
        """Return the whitened innovations of all recordings in a row, shape (N,)."""
        return self.judged(whiteners, simulated)[0]

    def judged(
        self, whiteners: Sequence[Whitener], simulated: Sequence[FloatArray]
    ) -> tuple[FloatArray, float]:
        """Return the whitened innovations of all recordings in a row and their log-likelihood."""
        parts = [w.residual(s) for w, s in zip(whiteners, simulated, strict=True)]
        densities = [
            log_density(r, w.log_scale, self.nu).sum() for r, w in zip(parts, whiteners, strict=True)
        ]
        return np.concatenate(parts), float(sum(densities))

    def of_recording(self, run: int, whiteners: Sequence[Whitener], rows: FloatArray) -> FloatArray:
        """Return the log-likelihood (m,) of one recording at each of the parameters `rows` (m, p)."""
        simulator, white = self.simulators[run], whiteners[run]
        residuals = (white.residual(simulated) for simulated in simulator.increments(rows))
        return np.array([log_density(r, white.log_scale, self.nu).sum() for r in residuals])

    def white_known(self, whiteners: Sequence[Whitener], known: Sequence[FloatArray]) -> FloatArray:
        """Return whitened columns (N, q) that a parent fit has computed; the last ones are remembered."""
        last = self._last_known
        if not last or last[0].raw is not known or last[0].whiteners is not whiteners:
            last[:] = [WhiteKnown(known, whiteners, self.white_columns(whiteners, known))]
        return last[0].white

    def white_columns(self, whiteners: Sequence[Whitener], columns: Sequence[FloatArray]) -> FloatArray:
        """Return whitened Jacobian columns of all recordings, shape (N, m): minus the residual's derivatives."""
        counts = [w.prepared.innovations for w in whiteners]
        out = np.empty((sum(counts), columns[0].shape[2]))
        begin = 0
        for whitener, block, count in zip(whiteners, columns, counts, strict=True):
            _whiten_into(out[begin : begin + count], whitener, block)
            begin += count
        return np.negative(out, out=out)

    def fit(
        self,
        values: FloatArray,
        slots: Sequence[Slot],
        noise: Noise,
        *,
        known: Sequence[FloatArray] | None = None,
        steps: int = 12,
        refresh: bool = False,
        hope: float = -np.inf,
        linear: bool = False,
    ) -> Fit:
        """Climb from `values` (R, p).

        known : raw columns (n, 5, q) of the first q slots for each recording, not computed again; refresh : compute
        all columns at the end, for the covariance; hope : a score that must be passed within `PATIENCE` steps, else
        the fit is given up; linear : the model is nearly linear here, so that what a step promises may end it at once.
        """
        slots, whiteners = tuple(slots), self.whiteners(noise)
        here = self.point(whiteners, values, slots, slot_numbers(values, slots))
        fixed = self.white_known(whiteners, known) if known and known[0].shape[2] else None
        first = 0 if fixed is None else fixed.shape[1]
        normal = np.eye(len(slots))
        raw: tuple[FloatArray, ...] = ()
        white, shared = np.empty((0, 0)), known if first and known else None
        damping, fresh = LEAST_DAMPING, False
        for iteration in range(steps):
            if not fresh:
                raw = jacobian(self.simulators, here.values, slots[first:], here.simulated)
                white = self.white_columns(whiteners, raw)
                white = white if fixed is None else np.hstack([fixed, white])
            here_fresh, fresh = not fresh, True
            normal, gradient = normal_equations(white, here.residual, slots, here.numbers, self.nu)
            tried = damped_step(normal, gradient, damping, slots, here.numbers)
            won = promised(normal, gradient, tried - here.numbers)
            settled = hope > -np.inf and won < NEGLIGIBLE and not clipped(slots, here.numbers, tried)
            if settled or (linear and here.score + OPTIMISM * won < hope):
                break
            there, damping = self._uphill(whiteners, here, slots, (normal, gradient), damping)
            gain, here = there.score - here.score, there
            if (gain < SMALL_GAIN and here_fresh) or (iteration + 1 >= PATIENCE and here.score < hope):
                break
            fresh = TRUSTED * won < gain < won / TRUSTED
        if refresh or not raw:
            raw = jacobian(self.simulators, here.values, slots, here.simulated)
            white = self.white_columns(whiteners, raw)
            normal, _ = normal_equations(white, here.residual, slots, here.numbers, self.nu)
            shared = None
        prior = log_prior(slots, here.numbers)
        covariance: FloatArray = np.asarray(np.linalg.pinv(normal, hermitian=True), dtype=float)
        parts = (raw,) if shared is None else (shared, raw)
        return Fit(here.values, slots, noise, here.score - prior, prior, covariance, here.simulated, parts)

    def point(
        self, whiteners: Sequence[Whitener], values: FloatArray, slots: Sequence[Slot], numbers: FloatArray
    ) -> Point:
        """Return what a fit knows at `values` (R, p), whose slots hold `numbers` (m,)."""
        simulated = simulate_all(self.simulators, values)
        residual, likelihood = self.judged(whiteners, simulated)
        return Point(values, numbers, simulated, residual, likelihood + log_prior(slots, numbers))

    def _uphill(
        self,
        whiteners: Sequence[Whitener],
        here: Point,
        slots: Sequence[Slot],
        equations: tuple[FloatArray, FloatArray],
        damping: float,
    ) -> tuple[Point, float]:
        """Return the first higher point along steps that are damped more and more, and the damping of the next step.

        equations : normal matrix and gradient. Where no step leads higher that is the point itself.
        """
        for _ in range(DAMPED):
            tried = damped_step(*equations, damping, slots, here.numbers)
            there = self.point(whiteners, with_slots(here.values, slots, tried), slots, tried)
            if there.score > here.score:
                return there, max(damping * 0.1, LEAST_DAMPING)
            damping = max(damping * 30.0, 1e-3)
        return here, damping

    def refit_noise(self, fit: Fit, names: Sequence[int], steps: int = 3) -> Fit:
        """Return the same parameters with the likeliest noise."""
        prepared = [s.prepared for s in self.simulators]
        free = (*names, JITTER) if fit.noise.jitter > 0.0 else names
        noise = fit_noise(prepared, fit.simulated, fit.noise, free, steps)
        value = self.log_likelihood(self.whiteners(noise), fit.simulated)
        return replace(fit, noise=noise, log_likelihood=value) if value > fit.log_likelihood else fit
