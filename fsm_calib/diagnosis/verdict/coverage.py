"""What the drives can tell, before any name is said: manoeuvres that they lack, effects that look alike in them.

A manoeuvre is there when the robot's path shows it for some seconds. Whether two effects look alike is asked of the
likelihood: the change that an effect of a declared size makes is whitened, what the base robot can take over is left
out, and of the rest x_A only what the other effect's changes, freely scaled, cannot follow speaks for the first:

    gain(A over B) = (1/2) |x_A - Q_B Q_B' x_A|^2     [nat]         Q_B: orthonormal changes of B

x_A is the strongest change of A's first closure, its simplest; Q_B holds those of all closures of B. Effects whose own
(1/2) |x_A|^2 stays below what detection asks for are faint: these drives do not show them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fsm_calib.diagnosis.candidates.hypotheses import declared_starts, hypotheses_of
from fsm_calib.diagnosis.candidates.starts import Prober
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.diagnosis.replay.prepared import Prepared
from fsm_calib.diagnosis.shapes.score_tests import project
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import Effect

LEAST = 2.0  # s of a manoeuvre, below which it counts as missing
MOVING, SLOW = 0.05, 0.4  # of the largest rim speed
STRAIGHT, SPIN = 0.2, 3.0  # speed of turning at the wheels over speed ahead, below and above
SECTORS, ENOUGH_SECTORS = 4, 3  # headings of straights: quarters of the compass, and how many make several
LONG = 60.0  # s of driving, before which warmth and batteries show little
ALIKE = 5.0  # nats: odds of 150 to 1, below which one effect is not told from another
SHARE = 0.07  # of an effect's change that is left beside another: what a right name may leave, too
MOST_CHANGES = 4  # declared sizes of an effect that are simulated
NO_POWER = 1e-9


@dataclass(frozen=True, slots=True)
class Coverage:
    """What drives can tell: manoeuvres that they lack, sets of effects alike in them, effects too faint in them."""

    lack: tuple[str, ...]
    alike: tuple[tuple[str, ...], ...]
    faint: tuple[str, ...]

    def as_json(self) -> dict[str, list[Any]]:
        """Return plain values."""
        return {
            "lack": list(self.lack),
            "alike": [list(names) for names in self.alike],
            "faint": list(self.faint),
        }


@dataclass(frozen=True, slots=True, eq=False)
class Changes:
    """What an effect of declared sizes changes, whitened, (N, m): in all of its closures, and in the first of them."""

    of_all: FloatArray
    of_first: FloatArray


def coverage_of(
    drives: Sequence[Prepared], prober: Prober, effects: Iterable[Effect], detect: float
) -> Coverage:
    """Return what drives can tell of effects that act anywhere and always; detect : evidence that detection needs."""
    changes = {e.name: _changes(e, prober) for e in effects if not e.scan}
    power = {
        name: 0.5 * float(np.max(np.sum(x.of_all**2, axis=0), initial=0.0)) for name, x in changes.items()
    }
    faint = tuple(name for name, gain in power.items() if 2.0 * gain < detect)
    seen = {name: x for name, x in changes.items() if name not in faint}
    return Coverage(missing(drives), alike(seen), faint)


def missing(drives: Sequence[Prepared]) -> tuple[str, ...]:
    """Return the manoeuvres that the paths of the drives lack."""
    seconds = _seconds(drives)
    lack = [name for name, spent in seconds.items() if spent < LEAST]
    if sum(float(p.time[-1] - p.time[0]) for p in drives) < LONG:
        lack.append("more than a minute of driving")
    return tuple(lack)


def _seconds(drives: Sequence[Prepared]) -> dict[str, float]:
    """Return for how long [s] the drives show each manoeuvre."""
    dt = np.concatenate([np.diff(p.track.time, append=p.track.time[-1]) for p in drives])
    theta = np.concatenate([p.track.theta for p in drives])
    vx, vy = (np.concatenate([getattr(p.track, name) for p in drives]) for name in ("vx", "vy"))
    ahead = vx * np.cos(theta) + vy * np.sin(theta)
    turn = np.concatenate([p.geometry[0] * p.track.omega for p in drives])
    rim = np.abs(ahead) + np.abs(turn)
    top = float(np.quantile(rim, 0.98))
    moving = rim > MOVING * top
    straight, spin = moving & (np.abs(turn) < STRAIGHT * np.abs(ahead)), np.abs(turn) > SPIN * np.abs(ahead)
    arc = moving & ~straight & ~spin
    masks = {
        "straights forwards": straight & (ahead > 0.0),
        "straights in reverse": straight & (ahead < 0.0),
        "spins to the left": moving & spin & (turn > 0.0),
        "spins to the right": moving & spin & (turn < 0.0),
        "arcs to the left": arc & (turn > 0.0),
        "arcs to the right": arc & (turn < 0.0),
        "slow driving": moving & (rim < SLOW * top),
        "rests": ~moving,
    }
    found = {name: float(dt[mask].sum()) for name, mask in masks.items()}
    sector = np.floor(theta * SECTORS / (2.0 * np.pi)).astype(int) % SECTORS
    spent = sorted((float(dt[straight & (sector == i)].sum()) for i in range(SECTORS)), reverse=True)
    return {**found, "straights on several headings": spent[ENOUGH_SECTORS - 1]}


def alike(changes: Mapping[str, Changes]) -> tuple[tuple[str, ...], ...]:
    """Return sets of effects of which each is mistaken for another of its set; by name."""
    bases = {name: _orthonormal(x.of_all) for name, x in changes.items()}
    names = list(changes)
    sets = {name: {name} for name in names}
    for i, a in enumerate(names):
        for b in names[i + 1 :]:
            if _follows(changes[a].of_first, bases[b]) and _follows(changes[b].of_first, bases[a]):
                joined = sets[a] | sets[b]
                for name in joined:
                    sets[name] = joined
    found = {tuple(sorted(group)) for group in sets.values() if len(group) > 1}
    return tuple(sorted(found))


def _follows(x: FloatArray, basis: FloatArray) -> bool:
    """Return whether other changes can follow the strongest of `x` (N, m) to within `ALIKE`, or `SHARE` of it."""
    strongest = x[:, int(np.argmax(np.sum(x * x, axis=0)))]
    left = strongest - basis @ (basis.T @ strongest)
    return 0.5 * float(left @ left) < max(ALIKE, 0.5 * SHARE * float(strongest @ strongest))


def _orthonormal(x: FloatArray) -> FloatArray:
    """Return an orthonormal basis (N, k) of the columns of `x` (N, m)."""
    u, size, _ = np.linalg.svd(x, full_matrices=False)
    return np.asarray(u[:, size > 1e-6 * max(float(size[0]), NO_POWER)])


def _changes(effect: Effect, prober: Prober) -> Changes:
    """Return what an effect of declared sizes changes beyond the base robot."""
    forms = list(hypotheses_of(effect, 1))
    starts = [(form is forms[0], start) for form in forms for start in declared_starts(form)]
    some = starts[:: max(1, len(starts) // MOST_CHANGES)][:MOST_CHANGES]
    columns = [prober.columns(with_values(prober.parent.values, start)) for _, start in some]
    joined = [np.concatenate(blocks, axis=2) for blocks in zip(*columns, strict=True)]
    of_all = project(prober.residual, joined)
    return Changes(of_all, of_all[:, [first for first, _ in some]])
