r"""What may still hide, alone or beside what was found: each effect's odds by what the drives say of sizes that matter.

An effect of size s would change the drives by x(s), and wins w(s) of log-likelihood as it stands, the numbers that were
free before re-fitted; for a robot without it, about -|x(s)|^2 / 2. Sizes are a quarter, a half and all of what is
typical, in every declared form and direction, alike before the drives; a smaller one changes no drive by more than its
noise. So

    odds against none of it = prior odds x mean over sizes and forms of exp w(s)

Drives that do not show an effect at all leave its odds as they were; those that would have shown it bring them down.
Where drives show a larger size, one that changes nothing in them (a limit beyond every command) does not matter.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fsm_calib.diagnosis.candidates.hypotheses import declared_starts, has_phase, hypotheses_of, scaled
from fsm_calib.diagnosis.candidates.ranked import Ranked
from fsm_calib.diagnosis.candidates.starts import Probe, Prober
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import Effect
from fsm_calib.world2d.parameters import parameter_table

SHARES = (0.25, 0.5, 1.0)  # of an effect's typical size
ANY_PHASE = 1.8  # rad: standard deviation of a phase that may be anything
LEAST_SPREAD = 0.3  # of a size: those between the three are as likely
SAME = 1e-9

Changes = dict[str, float]


@dataclass(frozen=True, eq=False)
class Unseen:
    """An effect that may hide: the mean likelihood ratio of its sizes (log), likely numbers, how far they spread.

    values : (p,) of a roll-out; parameter : full name of the strength that is uncertain, and its standard deviation.
    """

    name: str
    log_ratio: float
    values: FloatArray
    parameter: str
    spread: float


def unseen(
    prober: Prober, values: FloatArray, fitted: Mapping[str, Ranked], effects: Sequence[Effect]
) -> Iterator[Unseen]:
    """Yield effects, none of them of a place or a moment, by what the drives say of their sizes that matter.

    prober : on the fit that they would join; values : (p,) of it as it would act in another drive; fitted : effects
    that were fitted on top of it, by name. Those whose phase is of one drive are told by their fit.
    """
    for effect in effects:
        form = next(hypotheses_of(effect, 1))
        tried = [(share, scaled(effect, way, share)) for way in ways_of(effect) for share in SHARES]
        probes = prober.probes(form, [changes for _, changes in tried])
        if has_phase(effect):
            won = _won_at_any_phase(effect, tried, probes, fitted.get(effect.name))
        else:
            won = np.array([probe.declared.promise for probe in probes])
        shown = np.isfinite(won)
        if shown.any():
            tried, won = [way for way, is_shown in zip(tried, shown, strict=True) if is_shown], won[shown]
        yield _weighed(effect, tried, np.where(np.isfinite(won), won, 0.0), values)


def ways_of(effect: Effect) -> list[Changes]:
    """Return an effect of typical size in every declared form and direction."""
    starts = [start for form in hypotheses_of(effect, 1) for start in declared_starts(form)]
    alone = [{f"{effect.name}.{p.name}": p.typical} for p in effect.parameters if p.strength and p.fitted]
    ways: dict[tuple[tuple[str, float], ...], Changes] = {}
    for start in (*starts, *alone):
        if (size := size_of(effect, start)) > 0.0:
            for side in (1.0, -1.0):
                way = scaled(effect, start, side / size)
                if abs(size_of(effect, way) - 1.0) < SAME:
                    moved = {n: v for n, v in way.items() if v != effect.parameter(n.split(".")[1]).null}
                    ways[tuple(sorted(moved.items()))] = way
    return list(ways.values())


def size_of(effect: Effect, changes: Mapping[str, float]) -> float:
    """Return the largest strength of `changes` as a share of what is typical; of its start where none is typical."""
    sizes = [0.0]
    for full, value in changes.items():
        p = effect.parameter(full.split(".")[1])
        usual = p.typical_size or max((abs(start - p.null) for start in p.starts), default=0.0)
        if p.strength and usual > 0.0:
            sizes.append(abs(value - p.null) / usual)
    return max(sizes)


def _won_at_any_phase(
    effect: Effect, tried: Sequence[tuple[float, Changes]], probes: Sequence[Probe], fitted: Ranked | None
) -> FloatArray:
    """Return what sizes win where every drive has a phase of its own: about the fit's size, less what phases may win.

    A phase that may be anything and is known to 1 / sqrt(power of a drive) costs the log of how many such there are.
    """
    gain, best, drives = 0.0, 0.0, 1
    if fitted is not None:
        table, fit = parameter_table(), fitted.fit
        strengths = [f"{effect.name}.{name}" for name in effect.strengths]
        best = size_of(effect, {name: float(fit.values[0, table.place(name)]) for name in strengths})
        drives = sum(table.entries[slot.place].per_recording for slot in fit.slots)
        gain = max(fitted.gain, 0.0)
    power = np.array([probe.column @ probe.column for probe in probes])
    shares = np.array([share for share, _ in tried])
    phases = 0.5 * drives * np.log1p(ANY_PHASE**2 * power / max(drives, 1))
    return np.asarray(gain - 0.5 * power * (1.0 - best / shares) ** 2 - phases)


def _weighed(
    effect: Effect, tried: Sequence[tuple[float, Changes]], won: FloatArray, before: FloatArray
) -> Unseen:
    """Return an effect by what its sizes win."""
    top = float(won.max())
    weight = np.exp(won - top)
    log_ratio = top + math.log(float(weight.mean()))
    shares = np.array([share for share, _ in tried])
    mean = float(weight @ shares / weight.sum())
    spread = math.sqrt(float(weight @ (shares - mean) ** 2 / weight.sum()))
    share, changes = tried[int(np.argmax(won))]
    changes = scaled(effect, changes, mean / share)
    full = max(changes, key=lambda name: size_of(effect, {name: changes[name]}))
    size = abs(changes[full] - effect.parameter(full.split(".")[1]).null)
    values = with_values(before[None], changes)[0]
    return Unseen(effect.name, log_ratio, values, full, size * max(spread / mean, LEAST_SPREAD))
