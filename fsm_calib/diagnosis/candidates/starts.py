"""Where a fit starts, and what a form could win from there at all: judged before anything is fitted.

A start's simulated change is one more whitened column beside the fitted model's. It tells how much likelihood the
start wins as it stands, and with what amplitude (a secant, so that saturations and gaps, which have no derivative at
their null value, are seen). The columns of all its starts together tell what the form could win to first order.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fsm_calib.diagnosis.candidates.held_back import motors_to_try, stronger
from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis, scaled
from fsm_calib.diagnosis.fitting.fit import AT_A_TIME, Fit
from fsm_calib.diagnosis.fitting.slot import ALL_RUNS
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.diagnosis.replay.simulator import Simulator
from fsm_calib.diagnosis.shapes.score_tests import NO_POWER, Residual, free_part, winnings
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import Effect, registry

CHECKED = 4  # starts whose promise is checked by simulation
NO_CHANGE = 1e-9  # squared whitened units: below it a start changes nothing that is seen
LARGEST_RESCALE = 4.0  # a secant is trusted over a factor of four in amplitude
ROUNDING = 1e-6  # of its power: less is left of a derivative by rounding
LIKE = 0.1  # of its power: a change of which the others leave no more tells nothing that they do not tell

Changes = Mapping[str, float]


@dataclass(frozen=True, eq=False)
class Start:
    """Where a fit starts: parameters of each recording (R, p) and the log-likelihood it promises to win."""

    values: FloatArray
    promise: float


@dataclass(frozen=True, eq=False)
class Probe:
    """One declared start, tried by simulation.

    declared : with what it wins as it stands (-inf where it changes nothing); scaled : its strengths scaled by what
    the data ask for, with what it would win if the effect were linear, None where they ask for the other sign; column :
    what it changes (N,), whitened, without what the parent's numbers can do.
    """

    declared: Start
    scaled: Start | None
    column: FloatArray


@dataclass(frozen=True, eq=False)
class Prober:
    """Judges starts against one parent fit without fitting."""

    simulators: tuple[Simulator, ...]
    parent: Fit
    residual: Residual

    def columns(self, values: FloatArray) -> list[FloatArray]:
        """Return the simulated change of each recording at parameters `values` (R, p), (n, 5, 1)."""
        return self._changes([values])

    def _changes(self, tried: Sequence[FloatArray]) -> list[FloatArray]:
        """Return the simulated changes of each recording at several parameters (R, p), (n, 5, m)."""
        return [
            np.moveaxis(simulator.increments(np.array([values[run] for values in tried])) - before, 0, 2)
            for run, (simulator, before) in enumerate(
                zip(self.simulators, self.parent.simulated, strict=True)
            )
        ]

    def _white(self, tried: Sequence[FloatArray]) -> FloatArray:
        """Return what several parameters (R, p) change, whitened (N, m)."""
        return self.residual.engine.white_columns(self.residual.whiteners, self._changes(tried))

    def gain(self, columns: Sequence[FloatArray]) -> float:
        """Return the log-likelihood that a change wins as it stands, base re-fitted linearly; -inf for none at all."""
        return float(self._gains(self.residual.engine.white_columns(self.residual.whiteners, columns))[0])

    def _gains(self, white: FloatArray) -> FloatArray:
        """Return `gain` of whitened changes (N, m)."""
        return np.where(np.sum(white * white, axis=0) > NO_CHANGE, winnings(self.residual, white), -np.inf)

    def probes(self, hypothesis: Hypothesis, choices: Sequence[Changes]) -> list[Probe]:
        """Try declared starts by simulation."""
        return [
            probe
            for i in range(0, len(choices), AT_A_TIME)
            for probe in self._probes(hypothesis, choices[i : i + AT_A_TIME])
        ]

    def _probes(self, hypothesis: Hypothesis, choices: Sequence[Changes]) -> list[Probe]:
        tried = [with_values(self.parent.values, choice, hypothesis.run) for choice in choices]
        white = self._white(tried)
        gains, free = self._gains(white), free_part(self.residual, white)
        return [
            Probe(Start(values, float(gain)), self._scaled(hypothesis, choice, column), column)
            for values, choice, gain, column in zip(tried, choices, gains, free.T, strict=True)
        ]

    def _scaled(self, hypothesis: Hypothesis, changes: Changes, column: FloatArray) -> Start | None:
        """Return a start with its strengths scaled by what the data ask for, within what a secant is trusted over."""
        effect = registry()[hypothesis.effect]
        power, score = float(column @ column), float(column @ self.residual.psi)
        amplitude = score / max(power, NO_POWER)
        if power <= NO_POWER or (amplitude <= 0 and not _two_sided(effect, hypothesis)):
            return None
        size = np.clip(abs(amplitude), 1 / LARGEST_RESCALE, LARGEST_RESCALE)
        scale = float(np.sign(amplitude) * size)
        promise = scale * score - 0.5 * scale * scale * power
        return Start(with_values(self.parent.values, scaled(effect, changes, scale), hypothesis.run), promise)

    def held_back(self, hypothesis: Hypothesis, choices: Sequence[Changes], promised: float) -> list[Start]:
        """Return the best start with stronger motors than a weak parent's, where it promises more than `promised`."""
        motors = motors_to_try(self.simulators, self.parent.values)
        tried = self._started(stronger(self.parent.values, hypothesis, choices, motors))
        best = max(tried, key=lambda start: start.promise, default=None)
        return [] if best is None or best.promise <= promised else [best]

    def _started(self, tried: Sequence[FloatArray]) -> list[Start]:
        """Return starts at several parameters (R, p), with what each wins as it stands."""
        parts = [tried[i : i + AT_A_TIME] for i in range(0, len(tried), AT_A_TIME)]
        gains = [float(gain) for part in parts for gain in self._gains(self._white(part))]
        return [Start(values, gain) for values, gain in zip(tried, gains, strict=True)]

    def reach(self, probes: Sequence[Probe], steps: Sequence[Probe] = ()) -> float:
        """Return the log-likelihood that any mixture of what some starts change could win, to first order.

        Half of the squared length of the residual's part in the span of their k columns, less k / 2, which noise alone
        has there. steps : of single derivatives, of which what no start tells counts however little it is: far from a
        map's origin a floor that curves is nearly a plane.
        """
        if not probes:
            return 0.0
        first = _directions(_unit([probe.column for probe in probes]))
        further = [probe.column - first @ (first.T @ probe.column) for probe in steps]
        least = [ROUNDING * max(float(probe.column @ probe.column), NO_CHANGE) for probe in steps]
        told = [c for c, power in zip(further, least, strict=True) if float(c @ c) > power]
        within = np.column_stack([first, _directions(_unit(told))]) if told else first
        inside = within.T @ self.residual.psi
        return 0.5 * float(inside @ inside - len(inside))

    def best_starts(
        self,
        hypothesis: Hypothesis,
        choices: Sequence[Changes],
        keep: int,
        probes: Sequence[Probe] | None = None,
    ) -> list[Start]:
        """Return the most promising starts; numbers that belong to a recording are chosen for each by itself.

        What declared starts promise was simulated. That of scaled ones is a guess, checked by simulation for the
        leaders: an effect with a threshold is far from linear. probes : of the choices, where they have been tried.
        """
        tried = self.probes(hypothesis, choices) if probes is None else probes
        starts = [probe.declared for probe in tried]
        guessed = sorted((p.scaled for p in tried if p.scaled), key=lambda start: -start.promise)[:CHECKED]
        starts += self._started([start.values for start in guessed])
        own = [n for n in hypothesis.names if registry()[hypothesis.effect].parameter(n).per_recording]
        if own and hypothesis.run == ALL_RUNS and len(self.simulators) > 1:
            starts.append(self._mixed(choices))
        return sorted(starts, key=lambda start: -start.promise)[:keep]

    def _mixed(self, choices: Sequence[Changes]) -> Start:
        """Combine the best choice of each recording."""
        tried = [with_values(self.parent.values, choice) for choice in choices]
        promises = np.hstack(
            [self._promised_by_run(tried[i : i + AT_A_TIME]) for i in range(0, len(tried), AT_A_TIME)]
        )
        best = promises.argmax(axis=1)
        values = np.array([tried[choice][run] for run, choice in enumerate(best)])
        return Start(values, float(np.maximum(promises.max(axis=1), 0.0).sum()))

    def _promised_by_run(self, tried: Sequence[FloatArray]) -> FloatArray:
        """Return what several parameters (R, p) promise where they hold in one recording alone, (R, m).

        0.5 A^2 P, negative for an amplitude A < 0; P the power of a change without what the base can do.
        """
        r, white, promises = self.residual, self._white(tried), []
        for rows in map(r.rows, range(len(self.simulators))):
            inside = r.basis[rows].T @ white[rows]
            score = r.psi[rows] @ white[rows] - r.psi_inside @ inside
            power = np.sum(white[rows] ** 2, axis=0) - np.sum(inside * inside, axis=0)
            promises.append(0.5 * score * np.abs(score) / np.maximum(power, NO_POWER))
        return np.array(promises)


def distinct_of(probes: Sequence[Probe]) -> list[int]:
    """Return the starts whose changes are not mixtures of those before, the largest first (pivoted Gram-Schmidt).

    A start of whose change the chosen ones leave less than the share `LIKE` of its power is left out.
    """
    left = _unit([probe.column for probe in probes])
    chosen: list[int] = []
    while len(chosen) < len(probes):
        power = np.sum(left * left, axis=0)
        largest = int(np.argmax(power))
        if power[largest] <= LIKE:
            break
        chosen.append(largest)
        direction = left[:, largest] / np.sqrt(power[largest])
        left = left - np.outer(direction, direction @ left)
    return chosen


def _unit(changes: Sequence[FloatArray]) -> FloatArray:
    """Return changes (N,) as columns (N, k) of length one."""
    columns = np.column_stack(changes)
    return np.asarray(columns / np.sqrt(np.maximum(np.sum(columns * columns, axis=0), NO_CHANGE)))


def _directions(columns: FloatArray) -> FloatArray:
    """Return the directions (N, m), of length one and square to each other, in which columns of length one differ."""
    power, mixed = np.linalg.eigh(columns.T @ columns)
    told = power > LIKE
    return np.asarray(columns @ (mixed[:, told] / np.sqrt(power[told])))


def _two_sided(effect: Effect, hypothesis: Hypothesis) -> bool:
    """Return whether a strength of the hypothesis may lie on either side of its null value."""
    strengths = [effect.parameter(n) for n in effect.strengths if n in hypothesis.names]
    return any(p.low < p.null for p in strengths)
