"""Where on the floor, or when, could it be? Linear scans that give place and event effects their starts.

A candidate's effect on the increments is written down to first order (drag inside an area, a weak motor during a
span, a kick) and all candidates pass the whitening filter as columns; what each could win is one small projection.
The winners, kept apart from each other, become starts of full fits.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fsm_calib.diagnosis.adequacy import Residual, project
from fsm_calib.diagnosis.features import body_columns, place_centres
from fsm_calib.diagnosis.fit import Fit
from fsm_calib.diagnosis.scan_areas import (
    Area,
    Columns,
    apart,
    boxes,
    discs,
    drag_columns,
    settled,
    slip_columns,
    strips,
)
from fsm_calib.diagnosis.scan_markers import jumps_of, likely_discs
from fsm_calib.diagnosis.simulator import Simulator
from fsm_calib.diagnosis.situation import Situation
from fsm_calib.types import FloatArray
from fsm_calib.world2d.parameters import parameter_table

PITCH = 0.12  # m between candidate centres: a third of a common patch's diameter
SPAN_STEP = 1.5  # s between candidate begins and ends of a span
PUSH_STEP = 0.25  # s between candidate kicks
PUSH_LENGTH = 0.25  # s
PUSH_APART = 1.0  # s between kicks that are not the same one: four times its length
MASS, INERTIA = 1.1, 0.0065  # kg, kg m2 of a plain robot: a push's first guess
KEEP = 3
GROWTH = 3.0  # times what a candidate promises: as much as moving it and fitting it in full has won of others
CHUNK = 96


@dataclass(frozen=True, slots=True)
class Candidate:
    """Start values by full parameter name, for one recording or all (-1), and the promised log-likelihood.

    elsewhere : what the best other moment promises, from which this one has to stand out.
    """

    changes: Mapping[str, float]
    promise: float
    run: int = -1
    elsewhere: float = 0.0


@dataclass(frozen=True, eq=False)
class Scanner:
    """Scans against one parent fit; worth : log-likelihood below which nobody will ask for a candidate."""

    simulators: tuple[Simulator, ...]
    situations: list[Situation]
    parent: Fit
    residual: Residual
    worth: float = 0.0

    def hopeless(self, promise: float) -> bool:
        """Return whether a candidate promises too little even if it still grows."""
        return GROWTH * promise < self.worth

    def scores(self, blocks: Sequence[FloatArray], width: int) -> tuple[FloatArray, FloatArray]:
        """Return promise (c,) and amplitudes (c, width) of candidates with `width` adjacent columns each."""
        total = blocks[0].shape[2]
        parts = [slice(i, min(total, i + CHUNK * width)) for i in range(0, total, CHUNK * width)]
        found = [self._scores([b[:, :, part] for b in blocks], width) for part in parts]
        return np.concatenate([p for p, _ in found]), np.concatenate([a for _, a in found])

    def _scores(self, blocks: Sequence[FloatArray], width: int) -> tuple[FloatArray, FloatArray]:
        """Return `scores` of a chunk; projected products come from the products of what is projected out."""
        r = self.residual
        white = r.engine.white_columns(r.whiteners, blocks)
        inside = r.basis.T @ white
        score = (white.T @ r.psi - inside.T @ (r.basis.T @ r.psi)).reshape(-1, width)
        by_candidate = white.reshape(len(white), -1, width), inside.reshape(len(inside), -1, width)
        whole, lost = (np.einsum("nci,ncj->cij", part, part, optimize=True) for part in by_candidate)
        gram = whole - lost
        size = np.maximum(np.trace(gram, axis1=1, axis2=2), 1e-12)
        solved = np.linalg.solve(gram + 1e-9 * size[:, None, None] * np.eye(width), score[:, :, None])[
            :, :, 0
        ]
        return 0.5 * np.sum(score * solved, axis=1), solved

    def places(self) -> FloatArray:
        """Return candidate centres (m, 2) [m]."""
        return place_centres(self.situations, PITCH)

    def drag_areas(self) -> list[Candidate]:
        """Return areas of rough floor, felt under each wheel or under the body's middle."""
        areas = [
            replace(area, spread=spread)
            for area in [*boxes(self.places()), *strips(self.situations)]
            for spread in (0.0, 1.0)
        ]
        return self._areas("rough_floor_patch", areas, drag_columns, 1)

    def slippery_areas(self) -> list[Candidate]:
        """Return discs of low friction: there the robot neither starts, stops nor turns as told."""
        return self._areas("low_friction_patch", discs(self.places()), slip_columns, 3)

    def markers(self) -> list[Candidate]:
        """Return discs inside which the poses are turned about their centre, or turned and shifted."""
        jumps = [
            jumps_of(simulator.prepared, simulated)
            for simulator, simulated in zip(self.simulators, self.parent.simulated, strict=True)
        ]
        turned, shifted = likely_discs(jumps, False), likely_discs(jumps, True)
        cost = float(np.log(self.residual.engine.count))  # of two numbers more
        best = turned[0].promise if turned else 0.0
        found = turned + [disc for disc in shifted if disc.promise > best + cost]
        return [Candidate(disc.changes, disc.promise) for disc in found if not self.hopeless(disc.promise)]

    def _areas(self, name: str, areas: list[Area], columns: Columns, width: int) -> list[Candidate]:
        """Return the best areas that lie apart, each moved and resized until it promises most."""
        one_sided = name == "rough_floor_patch"

        def judge(tried: Sequence[Area]) -> FloatArray:
            blocks = [columns(run, s, tried) for run, s in enumerate(self.situations)]
            promise, amplitude = self.scores(blocks, width)
            return np.where(amplitude[:, 0] > 0, promise, 0.0) if one_sided else promise

        promise = judge(areas)
        found = []
        for area in apart(areas, promise, KEEP, 1.5 * PITCH):
            if self.hopeless(float(promise[areas.index(area)])):
                continue
            best, gain = settled(area, judge)
            found.append(Candidate({f"{name}.{k}": v for k, v in best.numbers(name).items()}, gain))
        return found

    def spans(self) -> list[Candidate]:
        """Return spans of one recording in which one wheel's motor is weaker."""
        table = parameter_table()
        found: list[Candidate] = []
        for side in ("left", "right"):
            place = table.place(f"gain_{side}")
            slot = next(i for i, s in enumerate(self.parent.slots) if s.place == place)
            gain = float(self.parent.values[0, place])
            for run, simulator in enumerate(self.simulators):
                found += self._spans_of(run, simulator, side, gain * self.parent.columns[run][:, :, slot])
        return sorted(found, key=lambda c: -c.promise)[:KEEP]

    def _spans_of(self, run: int, simulator: Simulator, side: str, column: FloatArray) -> list[Candidate]:
        time = simulator.prepared.time
        edges = np.append(np.arange(max(time[0], 0.0), time[-1] - SPAN_STEP, SPAN_STEP), time[-1])
        cells = np.zeros((*column.shape, len(edges) - 1))
        index = np.clip(np.searchsorted(edges, time, side="right") - 1, 0, len(edges) - 2)
        cells[np.arange(len(time)), :, index] = column
        blocks = [
            cells if i == run else np.zeros((*f.shape, cells.shape[2]))
            for i, f in enumerate(self.parent.simulated)
        ]
        x = project(self.residual, blocks)
        score, gram = np.r_[0.0, np.cumsum(x.T @ self.residual.psi)], np.zeros((len(edges), len(edges)))
        gram[1:, 1:] = np.cumsum(np.cumsum(x.T @ x, axis=0), axis=1)
        i, j = np.triu_indices(len(edges), 1)
        power = gram[j, j] - gram[i, j] - gram[j, i] + gram[i, i]
        amplitude = (score[j] - score[i]) / np.maximum(power, 1e-12)
        promise = 0.5 * amplitude**2 * power * (np.abs(amplitude) < 1.0) * (np.abs(amplitude) > 0.005)
        best = int(np.argmax(promise))
        begin, end = float(edges[i[best]]), float(edges[j[best]])
        changes = {
            f"motor_fault.loss_{side}": float(np.clip(-amplitude[best], -0.4, 0.9)),
            "motor_fault.start": begin,
            "motor_fault.duration": end - begin,
        }
        return [Candidate(changes, float(promise[best]), run)]

    def pushes(self) -> list[Candidate]:
        """Return kicks of one recording, most promising first, each with what the best kick apart from it promises."""
        tried = [self._pushes_of(run, s) for run, s in enumerate(self.situations)]
        found = []
        for run, (starts, promise, amplitude) in enumerate(tried):
            others = max((float(p.max()) for i, (_, p, _) in enumerate(tried) if i != run), default=0.0)
            for b in _peaks(promise, starts):
                apart = promise[np.abs(starts - starts[b]) > PUSH_APART]
                elsewhere = max(others, float(apart.max(initial=0.0)))
                changes = _push(self.situations[run], float(starts[b]), amplitude[b])
                found.append(Candidate(changes, float(promise[b]), run, elsewhere))
        return sorted(found, key=lambda c: -c.promise)[:KEEP]

    def _pushes_of(self, run: int, s: Situation) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return moments (m,) [s] of one recording, what kicks promise there (m,), and their amplitudes (m, 3)."""
        starts = np.arange(max(s.time[0], 0.0) + 0.5, s.time[-1] - 1.0, PUSH_STEP)
        own = _kick_columns(s, starts)
        blocks = [
            own if i == run else np.zeros((*f.shape, own.shape[2]))
            for i, f in enumerate(self.parent.simulated)
        ]
        return starts, *self.scores(blocks, 3)


def _push(s: Situation, start: float, amplitude: FloatArray) -> dict[str, float]:
    """Return the push that brings about speed errors `amplitude` forward, sideways and at the rim [m/s]."""
    heading = float(np.interp(start, s.time, s.heading))
    ahead, left, turn = amplitude * [MASS, MASS, INERTIA / s.half]
    c, d = np.cos(heading), np.sin(heading)
    return {
        "external_push.impulse_x": float(np.clip(c * ahead - d * left, -3, 3)),
        "external_push.impulse_y": float(np.clip(d * ahead + c * left, -3, 3)),
        "external_push.impulse_turn": float(np.clip(turn, -0.3, 0.3)),
        "external_push.start": start,
    }


def _peaks(promise: FloatArray, starts: FloatArray) -> list[int]:
    kept: list[int] = []
    for b in np.argsort(-promise):
        if all(abs(starts[b] - starts[k]) > 2 * PUSH_STEP for k in kept):
            kept.append(int(b))
        if len(kept) == KEEP:
            break
    return kept


def _kick_columns(s: Situation, starts: FloatArray) -> FloatArray:
    """Return three columns a start: a speed error of 1 m/s forward, sideways, at the rim, fading after the push."""
    shape = np.clip((s.time[:, None] - starts) / PUSH_LENGTH, 0.0, 1.0) * np.exp(
        -np.maximum(s.time[:, None] - starts - PUSH_LENGTH, 0.0) / 0.1
    )
    out = np.zeros((len(s.dt), 5, 3 * len(starts)))
    out[:, :, 0::3] = body_columns(s, forward=shape)
    out[:, :, 1::3] = body_columns(s, lateral=shape)
    out[:, :, 2::3] = body_columns(s, turn=shape / s.half)
    return out
