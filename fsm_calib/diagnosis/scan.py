"""Where on the floor, or when, could it be? Linear scans that give place and event effects their starts.

A candidate's effect on the increments is written down to first order (drag inside an area, a weak motor during a
span, a kick) and all candidates pass the whitening filter as columns; what each could win is one small projection.
The winners, kept apart from each other, become starts of full fits.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fsm_calib.diagnosis.adequacy import Residual, project
from fsm_calib.diagnosis.features import Situation, _column, _left, _right, place_centres
from fsm_calib.diagnosis.fit import Fit
from fsm_calib.diagnosis.simulator import Simulator, through_sensor
from fsm_calib.types import FloatArray
from fsm_calib.world2d.parameters import parameter_table

PITCH = 0.10  # m between candidate centres: a third of the smallest patch's diameter
DISC_RADII = (0.15, 0.25)  # m
STRIPS = (0.08, 0.2)  # m, half widths
SPAN_STEP = 1.5  # s between candidate begins and ends of a span
PUSH_STEP = 0.25  # s between candidate kicks
PUSH_LENGTH = 0.25  # s
KEEP = 3
CHUNK = 96
MARKER_TURN = 0.05  # rad, small enough to be linear


@dataclass(frozen=True, slots=True)
class Candidate:
    """Start values by full parameter name, for one recording or all (-1), and the promised log-likelihood."""

    changes: Mapping[str, float]
    promise: float
    run: int = -1


@dataclass(frozen=True, eq=False)
class Scanner:
    """Scans against one parent fit."""

    simulators: tuple[Simulator, ...]
    situations: list[Situation]
    parent: Fit
    residual: Residual

    def scores(self, blocks: Sequence[FloatArray], width: int) -> tuple[FloatArray, FloatArray]:
        """Return promise (c,) and amplitudes (c, width) of candidates with `width` adjacent columns each."""
        total = blocks[0].shape[2]
        promise, amplitude = np.zeros(total // width), np.zeros((total // width, width))
        for begin in range(0, total, CHUNK * width):
            part = slice(begin, min(total, begin + CHUNK * width))
            x = project(self.residual, [b[:, :, part] for b in blocks])
            score = x.T @ self.residual.psi
            for i in range(x.shape[1] // width):
                own = slice(i * width, (i + 1) * width)
                gram = x[:, own].T @ x[:, own]
                gram += 1e-9 * max(float(np.trace(gram)), 1e-12) * np.eye(width)
                solved = np.linalg.solve(gram, score[own])
                promise[begin // width + i] = 0.5 * float(score[own] @ solved)
                amplitude[begin // width + i] = solved
        return promise, amplitude

    def places(self) -> FloatArray:
        """Return candidate centres (m, 2) [m]."""
        return place_centres(self.situations, PITCH)

    def drag_areas(self) -> list[Candidate]:
        """Return boxes and strips of rough floor."""
        boxes = [(x, y, r, r) for r in DISC_RADII for x, y in self.places()]
        xs = [s.x for s in self.situations]
        ys = [s.y for s in self.situations]
        for half in STRIPS:
            boxes += [(x, 0.0, half, 5.0) for x in _line(xs)] + [(0.0, y, 5.0, half) for y in _line(ys)]
        blocks = [_drag_columns(s, boxes) for s in self.situations]
        promise, amplitude = self.scores(blocks, 1)
        promise = np.where(amplitude[:, 0] > 0, promise, 0.0)
        names = ("x", "y", "half_x", "half_y")
        found = [
            Candidate({f"rough_floor_patch.{n}": v for n, v in zip(names, b, strict=True)}, p)
            for b, p in zip(boxes, promise, strict=True)
        ]
        return _apart(found, "rough_floor_patch")

    def slippery_areas(self) -> list[Candidate]:
        """Return discs of low friction: there the robot neither starts, stops nor turns as told."""
        discs = [(x, y, r) for r in DISC_RADII for x, y in self.places()]
        blocks = [_slip_columns(s, discs) for s in self.situations]
        promise, _ = self.scores(blocks, 3)
        names = ("x", "y", "radius")
        found = [
            Candidate({f"low_friction_patch.{n}": v for n, v in zip(names, d, strict=True)}, p)
            for d, p in zip(discs, promise, strict=True)
        ]
        return _apart(found, "low_friction_patch")

    def markers(self) -> list[Candidate]:
        """Return discs inside which the poses are turned about their centre."""
        table = parameter_table()
        discs = [(x, y, r) for r in DISC_RADII for x, y in self.places()]
        blocks = []
        for simulator, before, values in zip(
            self.simulators, self.parent.simulated, self.parent.values, strict=True
        ):
            block = np.zeros((*before.shape, len(discs)))
            for i, disc in enumerate(discs):
                vector = values.copy()
                for name, value in zip(("turn", "x", "y", "radius"), (MARKER_TURN, *disc), strict=True):
                    vector[table.place(f"misplaced_marker.{name}")] = value
                moved = before.copy()
                through_sensor(vector, simulator.prepared.reference, moved)
                block[:, :, i] = (moved - before) / MARKER_TURN
            blocks.append(block)
        promise, amplitude = self.scores(blocks, 1)
        names = [f"misplaced_marker.{n}" for n in ("turn", "x", "y", "radius")]
        turns = np.clip(amplitude[:, 0], -1.0, 1.0)
        found = [
            Candidate(dict(zip(names, (float(turn), *disc), strict=True)), gain)
            for disc, gain, turn in zip(discs, promise, turns, strict=True)
        ]
        return _apart(found, "misplaced_marker")

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
        """Return kicks of one recording."""
        found: list[Candidate] = []
        mass, inertia = 1.1, 0.0065
        for run, s in enumerate(self.situations):
            starts = np.arange(max(s.time[0], 0.0) + 0.5, s.time[-1] - 1.0, PUSH_STEP)
            own = _kick_columns(s, starts)
            blocks = [
                own if i == run else np.zeros((*f.shape, own.shape[2]))
                for i, f in enumerate(self.parent.simulated)
            ]
            promise, amplitude = self.scores(blocks, 3)
            for b in _peaks(promise, starts):
                heading = float(np.interp(starts[b], s.time, s.heading))
                ahead, left, turn = amplitude[b] * [mass, mass, inertia / s.half]
                c, d = np.cos(heading), np.sin(heading)
                changes = {
                    "external_push.impulse_x": float(np.clip(c * ahead - d * left, -3, 3)),
                    "external_push.impulse_y": float(np.clip(d * ahead + c * left, -3, 3)),
                    "external_push.impulse_turn": float(np.clip(turn, -0.3, 0.3)),
                    "external_push.start": float(starts[b]),
                }
                found.append(Candidate(changes, float(promise[b]), run))
        return sorted(found, key=lambda c: -c.promise)[:KEEP]


def _line(tracks: Sequence[FloatArray]) -> FloatArray:
    return np.arange(min(float(t.min()) for t in tracks), max(float(t.max()) for t in tracks), PITCH)


def _apart(found: list[Candidate], name: str) -> list[Candidate]:
    """Return the best candidates whose centres are not neighbours."""
    kept: list[Candidate] = []
    for c in sorted(found, key=lambda c: -c.promise):
        here = np.array([c.changes[f"{name}.x"], c.changes[f"{name}.y"]])
        if all(
            np.hypot(*(here - [k.changes[f"{name}.x"], k.changes[f"{name}.y"]])) > 1.5 * PITCH for k in kept
        ):
            kept.append(c)
        if len(kept) == KEEP:
            break
    return kept


def _peaks(promise: FloatArray, starts: FloatArray) -> list[int]:
    kept: list[int] = []
    for b in np.argsort(-promise):
        if all(abs(starts[b] - starts[k]) > 2 * PUSH_STEP for k in kept):
            kept.append(int(b))
        if len(kept) == KEEP:
            break
    return kept


def _wheel_speeds(s: Situation) -> tuple[FloatArray, FloatArray]:
    return s.v - s.half * s.omega, s.v + s.half * s.omega


def _drag_columns(s: Situation, boxes: Sequence[tuple[float, float, float, float]]) -> FloatArray:
    """Return increments of a unit loss of rim speed on each wheel that stands in a box."""
    b = np.array(boxes)
    out = np.zeros((len(s.dt), 5, len(boxes)))
    for side, (speed, put) in enumerate(zip(_wheel_speeds(s), (_left, _right), strict=True)):
        arm = s.half if side == 0 else -s.half
        x, y = s.x - arm * np.sin(s.heading), s.y + arm * np.cos(s.heading)
        inside = (np.abs(x[:, None] - b[:, 0]) < b[:, 2]) & (np.abs(y[:, None] - b[:, 1]) < b[:, 3])
        out += put(-1.0 * inside * np.tanh(speed / 0.02)[:, None], s)
    return out


def _slip_columns(s: Situation, discs: Sequence[tuple[float, float, float]]) -> FloatArray:
    """Return three columns a disc: lost forward acceleration, lost angular acceleration, slide to the side."""
    d = np.array(discs)
    inside = (np.hypot(s.x[:, None] - d[:, 0], s.y[:, None] - d[:, 1]) < d[:, 2]).astype(float)
    out = np.zeros((len(s.dt), 5, 3 * len(discs)))
    out[:, :, 0::3] = _column(s, forward=-inside * s.acceleration[:, None])
    out[:, :, 1::3] = _column(s, turn=-inside * s.spin[:, None])
    out[:, :, 2::3] = _column(s, lateral=-inside * (s.v * s.omega)[:, None])
    return out


def _kick_columns(s: Situation, starts: FloatArray) -> FloatArray:
    """Return three columns a start: a speed error of 1 m/s forward, sideways, at the rim, fading after the push."""
    shape = np.clip((s.time[:, None] - starts) / PUSH_LENGTH, 0.0, 1.0) * np.exp(
        -np.maximum(s.time[:, None] - starts - PUSH_LENGTH, 0.0) / 0.1
    )
    out = np.zeros((len(s.dt), 5, 3 * len(starts)))
    out[:, :, 0::3] = _column(s, forward=shape)
    out[:, :, 1::3] = _column(s, lateral=shape)
    out[:, :, 2::3] = _column(s, turn=shape / s.half)
    return out
