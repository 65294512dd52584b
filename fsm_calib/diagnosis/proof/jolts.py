r"""Does an event come where the robot is jolted most? Then what is inexact there is the likelier explanation.

A push comes at any time. What equations get wrong comes where most happens: at a reversal from full speed tyres slide
and a body pitches, and what is left of that one push mends. With q [1] the share of the drives' time in which the
robot's own speed changes at least as much as in the event's moment, q is uniform for real events, and for patches on
inexact laws it is dense near zero (a density as 1 / (q + e), e [1] = `gates.EXACT`):

    density(q) = 1 / ((q + e) log(1 + 1 / e))        0 <= q <= 1
    V(t) = |max u - min u|                           from t - BEFORE to t + AFTER

u [m/s] = (forward, left, turning times half the axle), simulated without the event; V [m/s] its change about t [s].
(The hardest reversals of two carts of 22 and 27 kg were called pushes, with 281 and 1361 units of evidence.) What comes
several times in a drive comes at its times independently, so that the log densities add up.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from fsm_calib.diagnosis.candidates.hypotheses import is_event
from fsm_calib.diagnosis.candidates.plausible import SHORTEST_SPAN
from fsm_calib.diagnosis.fitting.begins import begins_of
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.fitting.values import switched_off
from fsm_calib.diagnosis.proof.gates import EXACT
from fsm_calib.diagnosis.proof.pose_jump import AFTER, BEFORE
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import Effect, registry
from fsm_calib.world2d.effects.numbered import length_of
from fsm_calib.world2d.parameters import parameter_table

GRID = 0.05  # s between the times at which the jolts of a drive are looked at


def against_patch(engine: Engine, fit: Fit, effects: Sequence[str]) -> float:
    """Return the log odds that the jolts at the momentary ones of `effects` cost their name, 0 or more.

    The least of several recordings: one in which they come in quiet times is enough.
    """
    moments = _moments(fit, effects)
    if not moments:
        return 0.0
    without = switched_off(fit.values, effects)
    jolts = [_jolts(engine, without, run) for run in range(len(engine.simulators))]
    everywhere = np.concatenate([size for _, size in jolts])
    against = []
    for run, starts in moments.items():
        times, sizes = jolts[run]
        here = sizes[np.minimum(np.searchsorted(times, starts), len(sizes) - 1)]
        against.append(sum(math.log(density(float(np.mean(everywhere >= size)))) for size in here))
    return max(min(against), 0.0)


def _moments(fit: Fit, effects: Sequence[str]) -> dict[int, list[float]]:
    """Return by recording when [s] some effects happened for a moment: pushes, spans as short or that came again."""
    found = dict[int, list[float]]()
    for effect in (registry()[name] for name in effects if is_event(registry()[name])):
        for run in fit.runs_of(effect.name):
            starts = begins_of(fit, effect.name, run)
            if effect.when == "moment" or len(starts) > 1 or _length(fit, effect, run) < SHORTEST_SPAN:
                found.setdefault(run, []).extend(starts)
    return found


def _length(fit: Fit, effect: Effect, run: int) -> float:
    """Return how long [s] an effect lasts in a recording, the first time."""
    return float(fit.values[run, parameter_table().place(f"{effect.name}.{length_of('start')}")])


def density(share: float) -> float:
    """Return how dense patches lie where so large a share of the drives' time jolts the robot as much [1]."""
    return 1.0 / ((share + EXACT) * math.log1p(1.0 / EXACT))


def _jolts(engine: Engine, without: FloatArray, run: int) -> tuple[FloatArray, FloatArray]:
    """Return times (m,) [s] of a drive and by how much the robot's own speed changes about each, (m,) [m/s]."""
    simulator = engine.simulators[run]
    time, half = simulator.prepared.time, 0.5 * without[run, parameter_table().place("axle_length")]
    steps = np.diff(time, prepend=time[0])
    moved = steps > 0.0
    speeds = (
        simulator.increments(without[run][None])[0][moved, :3]
        * np.array([1.0, 1.0, half])
        / steps[moved, None]
    )
    at = time[moved]
    times = np.arange(at[0], at[-1], GRID)
    first, last = np.searchsorted(at, times - BEFORE), np.searchsorted(at, times + AFTER, side="right")
    sizes = [
        float(np.linalg.norm(np.ptp(speeds[a:b], axis=0))) if b > a else 0.0
        for a, b in zip(first, last, strict=True)
    ]
    return times, np.array(sizes)
