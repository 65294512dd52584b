"""The picture that convinces: the speed error against what gave the effect away, before and after.

The error of one recording is taken over short pieces: how far the robot came, less how far the simulation says, over
`PIECE`, as a speed. It is averaged over pieces of like circumstances (the wheel's angle, the command, the heading, ...,
by the effect's first regime), each with the standard error of its mean. Circumstances come from commands, simulated
speeds and the smoothed path, as in `diagnosis.shapes`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fsm_calib.diagnosis.diagnose import Diagnosis
from fsm_calib.diagnosis.fitting.fit import Engine
from fsm_calib.diagnosis.proof.transfer import on_new_recording
from fsm_calib.diagnosis.replay.prepared import Prepared
from fsm_calib.diagnosis.replay.situation import Situation, situation
from fsm_calib.report.palette import AFTER, BEFORE, TEXT
from fsm_calib.report.plot import Axes, Box, figure
from fsm_calib.report.plot_scale import limits
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import Effect, registry

PIECE = 0.24
"""Length of the pieces [s]: longer than a frame, shorter than what changes along them."""
SLOWEST = 0.03
"""The robot counts as moving above this speed of a wheel [m/s]."""
BINS = 16
FEWEST = 5
"""Pieces in a bin that is drawn."""
SIZE = (760.0, 320.0)
BOX = Box(70.0, 46.0, 670.0, 220.0)
CHANNEL = {"forward": 0, "lateral": 1, "turn": 2, "sensor": 0}
UNITS = (
    (1e3, "forward error [mm/s]"),
    (1e3, "sideways error [mm/s]"),
    (np.degrees(1.0), "turning error [deg/s]"),
)

Quantity = Callable[[Situation], FloatArray]
BY_REGIME: dict[str, tuple[str, Quantity]] = {
    "wheel_phase": ("angle of the wheel [deg]", lambda s: np.degrees(s.roll[:, 0]) % 360.0),
    "heading": ("heading [deg]", lambda s: np.degrees(s.heading) % 360.0),
    "place": ("place along x [m]", lambda s: s.x),
    "late": ("time [s]", lambda s: s.time),
    "early": ("time [s]", lambda s: s.time),
    "once": ("time [s]", lambda s: s.time),
    "span": ("time [s]", lambda s: s.time),
    "after_reversal": ("way since the last reversal [m]", lambda s: np.minimum(s.travel, 0.4)),
    "transient": ("time since the command changed [s]", lambda s: np.minimum(s.age, 1.0)),
    "turning": ("yaw rate, simulated [deg/s]", lambda s: np.degrees(s.omega)),
    "fast_turn": ("yaw rate, simulated [deg/s]", lambda s: np.degrees(s.omega)),
    "driving": ("speed, simulated [m/s]", lambda s: s.v),
    "slow": ("speed, simulated [m/s]", lambda s: s.v),
    "small_command": ("mean command", lambda s: 0.5 * (s.left + s.right)),
    "large_command": ("mean command", lambda s: 0.5 * (s.left + s.right)),
    "reverse": ("mean command", lambda s: 0.5 * (s.left + s.right)),
}
"""By an effect's regime: what the error is drawn against."""


@dataclass(frozen=True, eq=False)
class Binned:
    """Means of the error in bins of a quantity: middles, means and standard errors, each of shape (b,)."""

    middle: FloatArray
    mean: FloatArray
    error: FloatArray


def signature(diagnosis: Diagnosis) -> str:
    """Return the figure of the first named effect as SVG; empty where none is named or nothing can be drawn."""
    if not diagnosis.verdict.effects:
        return ""
    effect = registry().get(diagnosis.verdict.effects[0].name)
    regime = next((r for r in effect.regimes if r in BY_REGIME), None) if effect is not None else None
    if effect is None or regime is None:
        return ""
    label, quantity = BY_REGIME[regime]
    prepared, around, before, after, name = _one_recording(diagnosis)
    channel = _channel(effect, prepared)
    if regime == "wheel_phase" and diagnosis.verdict.effects[0].parameters.keys() & {"right"}:
        label, quantity = "angle of the right wheel [deg]", lambda s: np.degrees(s.roll[:, 1]) % 360.0
    values = quantity(around)
    drawn = [binned(prepared, around, simulated, values, channel) for simulated in (before, after)]
    if any(len(part.middle) < 3 for part in drawn):
        return ""
    return _drawn(drawn, label, channel, f"{effect.name.replace('_', ' ')}, {name}")


def _channel(effect: Effect, prepared: Prepared) -> int:
    """Return the first of the effect's channels that can be measured: forward, left, turn as 0, 1, 2."""
    rows = [CHANNEL[name] for name in effect.channels]
    return rows[0] if prepared.poses.placed else 2


def _one_recording(diagnosis: Diagnosis) -> tuple[Prepared, Situation, FloatArray, FloatArray, str]:
    """Return a recording with increments simulated before and after: one that was not fitted, where there is one."""
    decision = diagnosis.decision
    if diagnosis.holdout_simulators:
        simulator = diagnosis.holdout_simulators[0]
        alone = Engine((simulator,))
        values = on_new_recording(alone, decision.base), on_new_recording(alone, decision.model.fit)
        before, after = (simulator.increments(part)[0] for part in values)
        return (
            simulator.prepared,
            situation(simulator, values[0][0]),
            before,
            after,
            "a drive that was not fitted",
        )
    simulator = decision.engine.simulators[0]
    before, after = decision.base.simulated[0], decision.model.fit.simulated[0]
    return simulator.prepared, situation(simulator, decision.base.values[0]), before, after, "the first drive"


def binned(
    prepared: Prepared, around: Situation, simulated: FloatArray, values: FloatArray, channel: int
) -> Binned:
    """Return the speed error of pieces, averaged in bins of `values` (n,), with the sign of the motion taken out."""
    time, ends = prepared.time, prepared.seen[:, 2]
    off = prepared.y[:, channel] - np.cumsum(simulated[:, channel] - prepared.step[:, channel])
    frames = np.flatnonzero(ends)
    last = np.searchsorted(time[frames], time[frames] + PIECE)
    pairs = [(a, frames[b]) for a, b in zip(frames, last, strict=True) if b < len(frames)]
    first, second = np.array(pairs, dtype=int).reshape(-1, 2).T
    breaks = np.cumsum(prepared.restart)
    span = time[second] - time[first]
    middle = (first + second) // 2
    speed = np.maximum(np.abs(around.v), around.half * np.abs(around.omega))
    keep = (breaks[first] == breaks[second]) & (span < 2.0 * PIECE) & (speed[middle] > SLOWEST)
    first, second, middle, span = first[keep], second[keep], middle[keep], span[keep]
    sign = np.where(around.v[middle] < 0.0, -1.0, 1.0) if channel == 0 else np.ones(len(middle))
    error = sign * (off[second] - off[first]) / span
    return _means(values[middle], error)


def _means(values: FloatArray, error: FloatArray) -> Binned:
    if len(values) < FEWEST:
        return Binned(*(np.zeros(0) for _ in range(3)))
    low, high = np.quantile(values, [0.01, 0.99])
    edges = np.linspace(low, high, BINS + 1)
    place = np.clip(np.digitize(values, edges) - 1, 0, BINS - 1)
    rows = []
    for number in range(BINS):
        inside = error[place == number]
        if len(inside) >= FEWEST:
            overlap = np.sqrt(6.0)  # pieces of six frames share five of them with the next
            deviation = float(inside.std(ddof=1) / np.sqrt(len(inside)) * overlap)
            rows.append((0.5 * (edges[number] + edges[number + 1]), float(inside.mean()), deviation))
    table = np.array(rows).reshape(-1, 3)
    return Binned(table[:, 0], table[:, 1], table[:, 2])


def _drawn(parts: list[Binned], label: str, channel: int, name: str) -> str:
    scale, unit = UNITS[channel]
    every = np.concatenate(
        [scale * (part.mean + side * part.error) for part in parts for side in (-1.0, 1.0)]
    )
    axes = Axes(BOX, limits(parts[0].middle, 0.03), limits(np.append(every, 0.0), 0.08))
    axes.line(np.array([(axes.x.low, 0.0), (axes.x.high, 0.0)]), TEXT, 1.0, "2 4")
    for part, colour, said in zip(parts, (BEFORE, AFTER), ("without the effect", "with it"), strict=True):
        points = np.column_stack([part.middle, scale * part.mean])
        for (x, y), error in zip(points, scale * part.error, strict=True):
            axes.line(np.array([(x, y - error), (x, y + error)]), colour, 1.0)
        axes.line(points, colour, 1.8)
        axes.dots(points, colour, 5.0, label=said)
    axes.frame(label, unit)
    return figure(*SIZE, f"Speed error against {label.split(' [')[0]}: {name}", axes)
