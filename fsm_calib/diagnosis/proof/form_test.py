r"""Does a shape without a name do better than the named effect? The contest that a name has to win.

A wrong neighbour of the truth leaves little that stands out (its own numbers and the base robot's take up the rest),
but a free shape of the right quantity fits better than it does. So the named model is compared with un-named forms
(`forms.py`), by evidence, at the named model's noise:

    instead = max_k [2 (L_0 + g_k) - c_k] - [2 L_M - k_M ln N]      L_0: the base robot alone, linearised at its re-fit
    beside  = max_k [2 g_k - k (ln N + 2 ln P)]                     on top of the named model, linearised at its fit

L [1] log-likelihood, g_k what k forms win, chosen one by one, largest score first; N innovations, P forms. The costs:
c_k = k ln N + 2 (k - 1) ln P; ln N a number (Schwarz, Ann. Stat. 6 (1978) 461), 2 ln P a choice among P (Chen & Chen,
Biometrika 95 (2008) 759); the first form pays for no choice, as the names pay nothing for theirs.
Assumes that forms act linearly, which favours the name: its own equation is simulated in full. The base robot is
re-fitted in full, too: beside the wheels' cross-talk, or where a place makes it slide, it ends far from where the
named model has it, and what is linearised there misjudges the forms by hundreds. Poses that jump where the robot
crosses the edge of a disc (`scan_markers.py`) count as one more form beside the name. What is late by a millisecond is
no form: tyres and motors lag by as much more or less than the base's equations say (`LATE`), so that both
models may be late by a little, forward and turning.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fsm_calib.diagnosis.candidates.ranked import evidence_of
from fsm_calib.diagnosis.candidates.scan_markers import jump_evidence
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.likelihood.robust import robust_weights
from fsm_calib.diagnosis.proof.linear import Linear
from fsm_calib.diagnosis.proof.pose_jump import jumped
from fsm_calib.diagnosis.shapes.features import apart_columns
from fsm_calib.diagnosis.shapes.form_frame import frames_of
from fsm_calib.diagnosis.shapes.forms import forms
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import registry

JUMPS = "the pose's jumps at a place"
MOST_INSTEAD = 5  # forms that may stand in for an effect
MOST_BESIDE = 3
REFIT_STEPS = 8  # of the base robot at the named model's noise
LATE = 0.002  # s, standard deviation of what the base is late by beyond its own lags: tyres lag by 2 to 3 ms (assumed)
NEW = 0.02  # of a column's length that the columns before it must leave
NOTHING = 1e-9  # length of a whitened column that a form does not have


@dataclass(frozen=True, eq=False)
class Contest:
    """Evidence of the best un-named forms over the name's, instead of it and beside it, with their quantities.

    stand_in : of the forms that are beside it, those alone instead of it; `instead` where nothing is left beside it.
    Where poses jump they are wrong by more than is modelled, and any forms that could do the name's job count: held
    against names only by what more jumps there are without them, two pairs of a Duckiebot's laps under watchtowers
    contradicted each other at 0.9 (a Warthog's skid steering, 0.87 then, is refused).
    explained : evidence of the name over the base robot; loose : no exact equation can be had (a place, a moment, a
    robot that turns velocities into wheel commands by a controller of its own). jump : of a jump of the measured poses
    in a moment's place (`pose_jump.py`); -inf for other effects.
    """

    instead: float
    instead_quantities: tuple[str, ...]
    beside: float
    beside_quantities: tuple[str, ...]
    stand_in: float
    explained: float
    loose: bool = False
    jump: float = -np.inf

    def numbers(self) -> dict[str, float]:
        """Return the three evidences by name."""
        return {"instead": self.instead, "beside": self.beside, "explained": self.explained}


@dataclass(frozen=True, eq=False)
class Pool:
    """Whitened un-named columns of unit length, a block (N, p) a quantity that they depend on; P in all."""

    blocks: tuple[tuple[str, FloatArray], ...]

    @cached_property
    def quantities(self) -> tuple[str, ...]:
        """The quantity of each column."""
        return tuple(quantity for quantity, block in self.blocks for _ in range(block.shape[1]))

    def of(self, quantities: Sequence[str]) -> Pool:
        """Return the columns that depend on some quantities."""
        return Pool(tuple(block for block in self.blocks if block[0] in quantities))

    def column(self, place: int) -> FloatArray:
        """Return a column (N,) by its place among all."""
        for _, block in self.blocks:
            if place < block.shape[1]:
                return block[:, place]
            place -= block.shape[1]
        raise IndexError(place)

    def products(self, rows: FloatArray) -> FloatArray:
        """Return the products of rows (N,) or (k, N) with all columns, (P,) or (k, P)."""
        return np.concatenate([rows @ block for _, block in self.blocks], axis=-1)

    def squares(self, weight: FloatArray) -> FloatArray:
        """Return the squared lengths (P,) of all columns with weights (N,)."""
        return np.concatenate([weight @ (block * block) for _, block in self.blocks])


@dataclass(frozen=True, eq=False)
class Remainder:
    """What a fit leaves: the model and the forms linearised where it is, and the best forms beside it.

    beside : their evidence, with the quantities that they depend on.
    """

    engine: Engine
    fit: Fit
    model: Linear
    pool: Pool
    beside: float
    quantities: tuple[str, ...]

    @classmethod
    def of(cls, engine: Engine, fit: Fit) -> Remainder:
        """Let un-named forms join a fit, one by one."""
        model, pool = _linearised(engine, fit)
        log_n, choice = _costs(engine, pool)
        _, path = _climb(model, pool, MOST_BESIDE)
        evidence = [2.0 * gain - (k + 1) * (log_n + choice) for k, (_, gain) in enumerate(path)]
        return cls(engine, fit, model, pool, *_best(evidence, path, pool))

    @cached_property
    def jumps(self) -> float:
        """Evidence of jumps of the measured pose at a place."""
        prepared = [s.prepared for s in self.engine.simulators]
        return jump_evidence(prepared, self.fit.simulated, self.engine.count)

    def beside_of(self, effects: Sequence[str]) -> tuple[float, tuple[str, ...]]:
        """Return the best forms beside `effects`, or jumps of the measured pose where these say more."""
        own_edges = any(registry()[name].jumps for name in effects)  # exact to a frame only
        if own_edges or self.jumps <= self.beside:
            return self.beside, self.quantities
        return self.jumps, (JUMPS,)


def contest(remainder: Remainder, parent: Fit, effects: Sequence[str]) -> Contest:
    """Let un-named forms compete with `effects`, which the fit of `remainder` adds to `parent`."""
    engine, fit, named = remainder.engine, remainder.fit, remainder.model
    bare, pool = named, remainder.pool
    if effects:
        refitted = engine.fit(parent.values, parent.slots, fit.noise, steps=REFIT_STEPS, refresh=True)
        bare, pool = _linearised(engine, refitted)
    extra = len(fit.slots) - len(parent.slots)
    log_n, choice = _costs(engine, remainder.pool)
    target = 2.0 * named.solved()[2] - extra * log_n
    beside, quantities = remainder.beside_of(effects)
    instead, instead_quantities = _in_its_place(bare, pool, target, log_n, choice)
    same = pool.of(quantities if beside > 0.0 else ())
    loose = any(registry()[name].scan for name in effects) or any(
        s.prepared.recording.command is None for s in engine.simulators
    )
    return Contest(
        instead,
        instead_quantities,
        beside,
        quantities,
        _in_its_place(bare, same, target, log_n, choice)[0] if same.quantities else instead,
        evidence_of(fit, parent, engine.count),
        loose,
        jumped(engine, bare, fit, effects) - target,
    )


def _in_its_place(
    bare: Linear, pool: Pool, target: float, log_n: float, choice: float
) -> tuple[float, tuple[str, ...]]:
    """Return by how much evidence the best forms of a pool beat a name that reaches `target`, and their quantities."""
    begun, path = _climb(bare, pool, MOST_INSTEAD)
    evidence = [
        2.0 * (begun + gain) - (k + 1) * log_n - k * choice - target for k, (_, gain) in enumerate(path)
    ]
    return _best(evidence, path, pool)


def _costs(engine: Engine, pool: Pool) -> tuple[float, float]:
    """Return what a number costs and what a choice among the forms does."""
    return float(np.log(engine.count)), 2.0 * float(np.log(len(pool.quantities)))


def _linearised(engine: Engine, fit: Fit) -> tuple[Linear, Pool]:
    """Return a fitted model and the forms, both linearised where it is."""
    whiteners, frames = engine.whiteners(fit.noise), frames_of(engine.simulators, fit)
    late = [apart_columns(f.s, f.s.acceleration[:, None], f.s.spin[:, None]) for f in frames]
    own, lateness = (engine.white_columns(whiteners, columns) for columns in (fit.columns, late))
    model = Linear(
        engine.residual(whiteners, fit.simulated),
        np.hstack([own, lateness]),
        np.append(fit.slot_values() - np.array([s.centre for s in fit.slots]), np.zeros(lateness.shape[1])),
        np.append([s.spread for s in fit.slots], np.full(lateness.shape[1], LATE)),
        engine.nu,
    )
    return model, _pool((f.quantity, engine.white_columns(whiteners, f.columns)) for f in forms(frames))


def _pool(blocks: Iterable[tuple[str, FloatArray]]) -> Pool:
    """Return the columns that are more than nothing."""
    kept = []
    for quantity, block in blocks:
        length = np.linalg.norm(block, axis=0)
        some = np.flatnonzero(length > NOTHING)
        whole = len(some) == len(length)
        kept.append(
            (quantity, np.divide(block, length, out=block) if whole else block[:, some] / length[some])
        )
    return Pool(tuple(kept))


def _climb(model: Linear, pool: Pool, most: int) -> tuple[float, list[tuple[int, float]]]:
    """Return the score without forms, and form by form (place in the pool, score won so far)."""
    residual, off, begun = model.solved()
    path: list[tuple[int, float]] = []
    for _ in range(most):
        chosen = _most_promising(model, residual, off, pool)
        if chosen is None:
            break
        model = model.with_columns(pool.column(chosen))
        residual, off, now = model.solved()
        path.append((chosen, now - begun))
    return begun, path


def _most_promising(model: Linear, residual: FloatArray, off: FloatArray, pool: Pool) -> int | None:
    """Return the form with the largest score test, priors as rows of data; None where all are spanned already."""
    weight = robust_weights(residual, model.nu)
    root = np.sqrt(weight)[:, None]
    held = np.flatnonzero(model.spread > 0.0)
    rows = np.zeros((len(held), model.columns.shape[1]))
    rows[np.arange(len(held)), held] = 1.0 / model.spread[held]
    stacked = np.vstack([root * model.columns, rows])
    spanned, _ = np.linalg.qr(stacked / np.maximum(np.linalg.norm(stacked, axis=0), 1e-12))
    error = np.concatenate([root[:, 0] * residual, -off[held] / model.spread[held]])
    inside = pool.products((root * spanned[: len(root)]).T)  # what is left of a pool is as large as the pool
    length = np.sqrt(np.maximum(pool.squares(weight) - np.sum(inside * inside, axis=0), 0.0))
    product = pool.products(root[:, 0] * error[: len(root)]) - (spanned.T @ error) @ inside
    score = np.where(length > NEW, np.abs(product) / np.maximum(length, NEW), 0.0)
    return int(np.argmax(score)) if score.any() else None


def _best(
    evidence: Sequence[float], path: Sequence[tuple[int, float]], pool: Pool
) -> tuple[float, tuple[str, ...]]:
    if not path:
        return -np.inf, ()
    last = int(np.argmax(evidence))
    return float(evidence[last]), tuple(dict.fromkeys(pool.quantities[i] for i, _ in path[: last + 1]))
