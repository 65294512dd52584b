r"""Does an event come where the robot is jolted most, or a wheel begins to turn? Then a patch is likelier.

A push comes at any time. What equations get wrong comes where most happens: at a reversal from full speed tyres slide
and a body pitches, and where a wheel begins to turn gears take up their play, friction lets go, a caster swivels; what
is left of that one push mends. With q [1] the share of the drives' time in which the robot's own speed changes at least
as much as in the event's moment, or a wheel begins to turn as near to it, q is uniform for real events, and for patches
on inexact laws it is dense near zero (a density as 1 / (q + e), e [1] = `ranked.EXACT`):

    density(q) = 1 / ((q + e) log(1 + 1 / e))        0 <= q <= 1
    V(t) = |max u - min u|                           from t - BEFORE to t + AFTER

u [m/s] = (forward, left, turning times half the axle), simulated without the event; V [m/s] its change about t [s].
(The hardest reversals of two carts of 22 and 27 kg were called pushes, with 281 and 1361 units of evidence; three
pushes of a robot whose commutator had burnt bars, 983 units, came 0.05 to 0.12 s from where a wheel began to turn, q of
0.06 to 0.12.) What comes several times in a drive comes at its times independently, so that the log densities add up.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fsm_calib.diagnosis.candidates.hypotheses import is_event
from fsm_calib.diagnosis.candidates.plausible import SHORTEST_SPAN, stands_out
from fsm_calib.diagnosis.candidates.ranked import EXACT, Ranked
from fsm_calib.diagnosis.fitting.begins import begins_of
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.fitting.values import switched_off
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import Effect, registry
from fsm_calib.world2d.effects.numbered import length_of
from fsm_calib.world2d.parameters import parameter_table

BEFORE, AFTER = 0.2, 0.4  # s from an event's start: a fit may be off by it, a motor answers within it
TOO_JOLTED = 2.8  # log odds: with so much against it the surest name is not said (`verdict/posterior.py`)
GRID = 0.05  # s between the times at which a drive is looked at
STANDS = 0.03  # of the fastest wheel's rate: below it a wheel stands


def against_patch(engine: Engine, fit: Fit, effects: Sequence[str]) -> float:
    """Return the log odds that the moments of the momentary ones of `effects` cost their name, 0 or more."""
    moments = _moments(fit, effects)
    if not moments:
        return 0.0
    motions = [
        _motion(engine, switched_off(fit.values, effects), run) for run in range(len(engine.simulators))
    ]
    jolted = _log_densities(motions, moments, lambda motion: motion.jolts)
    begun = _log_densities(motions, moments, lambda motion: -motion.apart)
    return max(min(jolted), sum(begun), 0.0)  # of jolts one recording in which they are quiet is enough


def is_quiet(engine: Engine, ranked: Ranked) -> bool:
    """Return whether an event may have its name in spite of the moments it comes at; True for other effects."""
    return against_patch(engine, ranked.fit, [ranked.name]) < TOO_JOLTED


def happened(engine: Engine, ranked: Ranked, detect: float) -> bool:
    """Return whether an event stands out as chance hardly does and no jolt explains it; True for other effects.

    detect : evidence that an effect needs.
    """
    return stands_out(ranked, detect) and is_quiet(engine, ranked)


@dataclass(frozen=True, eq=False)
class _Motion:
    """A drive as it is simulated without the events: at times (m,) [s] the jolt about each [m/s] and how long it is
    to where a wheel begins to turn [s].
    """

    times: FloatArray
    jolts: FloatArray
    apart: FloatArray


def _log_densities(
    motions: Sequence[_Motion],
    moments: Mapping[int, Sequence[float]],
    badness: Callable[[_Motion], FloatArray],
) -> list[float]:
    """Return the log density of patches at the moments of each recording; badness : (m,) at the times of a motion."""
    everywhere = np.concatenate([badness(motion) for motion in motions])
    found = []
    for run, starts in moments.items():
        times, here = motions[run].times, badness(motions[run])
        bad = here[np.minimum(np.searchsorted(times, starts), len(here) - 1)]
        found.append(sum(math.log(density(float(np.mean(everywhere >= one)))) for one in bad))
    return found


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
    """Return how dense patches lie where so large a share of the drives' time is as bad [1]."""
    return 1.0 / ((share + EXACT) * math.log1p(1.0 / EXACT))


def _motion(engine: Engine, without: FloatArray, run: int) -> _Motion:
    """Return what a drive does to the robot by itself."""
    simulator = engine.simulators[run]
    time, half = simulator.prepared.time, 0.5 * without[run, parameter_table().place("axle_length")]
    steps = np.diff(time, prepend=time[0])
    moved = steps > 0.0
    rates = simulator.increments(without[run][None])[0][moved] / steps[moved, None]
    at = time[moved]
    times = np.arange(at[0], at[-1], GRID)
    return _Motion(
        times, _jolts(at, rates[:, :3] * np.array([1.0, 1.0, half]), times), _apart(at, rates[:, 3:], times)
    )


def _jolts(at: FloatArray, speeds: FloatArray, times: FloatArray) -> FloatArray:
    """Return by how much speeds (n, 3) [m/s] at (n,) [s] change about each of the times (m,) [s]."""
    first, last = np.searchsorted(at, times - BEFORE), np.searchsorted(at, times + AFTER, side="right")
    sizes = [
        float(np.linalg.norm(np.ptp(speeds[a:b], axis=0))) if b > a else 0.0
        for a, b in zip(first, last, strict=True)
    ]
    return np.array(sizes)


def _apart(at: FloatArray, wheels: FloatArray, times: FloatArray) -> FloatArray:
    """Return how far [s] each of the times (m,) is from where a wheel begins to turn, forward or backward.

    at : (n,) [s]; wheels : (n, 2) [rad/s]. A wheel below `STANDS` of the fastest stands.
    """
    turns = np.where(np.abs(wheels) < STANDS * np.abs(wheels).max(initial=0.0), 0.0, np.sign(wheels))
    begun = np.any((np.diff(turns, axis=0) != 0.0) & (turns[1:] != 0.0), axis=1)
    begins = at[:-1][begun]
    if not begins.size:
        return np.full(len(times), at[-1] - at[0])
    return np.asarray(np.min(np.abs(times[:, None] - begins), axis=1))
