"""How much of the error over the horizon does each effect take away, and is that worth a name?"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fsm_calib.diagnosis.candidates.ranked import EXACT
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.proof.heldout import noise_floor, squared_error
from fsm_calib.diagnosis.replay.simulator import scale_of
from fsm_calib.diagnosis.verdict.model import Model
from fsm_calib.diagnosis.verdict.posterior import Belief
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

TELLING = (
    1.5  # times the squared error with an effect is that without it: a fifth more error, as anybody would see
)
RULED = ("m", "rad")  # units of what a ruler or a protractor shows


@dataclass(frozen=True, slots=True)
class Taken:
    """What an effect takes away of the squared error over the horizon: as a share of the base's, and how many times as
    large the model's is without it.
    """

    share: float
    times: float


def shares_of(engine: Engine, base: Fit, model: Model) -> dict[str, float]:
    """Return the share of the base's error over the horizon, squared, that each effect of the model takes away."""
    return {name: taken.share for name, taken in taken_by(engine, base, model).items()}


def taken_by(engine: Engine, base: Fit, model: Model) -> dict[str, Taken]:
    """Return what each effect of the model takes away of the error over the horizon, by name.

    Position and heading in units of the model's noise, means over the windows of the fitted recordings; the shares of
    effects that stand in for each other, or hide each other, do not add up to one.
    """
    supports, simulators = model.supports, engine.simulators
    if not supports:
        return {}
    unit = noise_floor(simulators, model.fit)
    before = max(squared_error(simulators, base, unit), 1e-12)
    after = squared_error(simulators, model.fit, unit)
    less = {s.name: squared_error(simulators, s.without, unit) for s in supports}
    return {
        name: Taken(min(max((value - after) / before, 0.0), 1.0), value / max(after, 1e-12))
        for name, value in less.items()
    }


def worth_saying(engine: Engine, base: Fit, model: Model, named: Sequence[Belief]) -> tuple[Belief, ...]:
    """Return the sure names without those of which every robot has a little, where it is too little to matter.

    No equation is exact to less than a hundredth (EXACT), so that a caster's drag or a scrubbing tyre that takes less
    of the error may be any other of its kind; it stays in the model. Beside a skid that takes nearly all of a light
    robot's error a tag 8 mm off its place takes less, too: what errs clearly more without it is said. So is what a
    ruler shows to be as far off as a load or a slipped tag is (`Parameter.typical`): a mass 41 mm ahead of the axle
    took 0.001, beside scrubbing tyres. The first name is said whatever it takes.
    """
    usual = {belief.name for belief in named[1:] if registry()[belief.name].usual}
    if not usual:
        return tuple(named)
    taken = taken_by(engine, base, model)
    little = {name for name in usual if name in taken and not _matters(taken[name])}
    return tuple(b for b in named if b.name not in little or _is_far_off(engine, model.fit, b.name))


def _matters(taken: Taken) -> bool:
    return taken.share >= EXACT or taken.times >= TELLING


def _is_far_off(engine: Engine, fit: Fit, name: str) -> bool:
    """Return whether a length or an angle of an effect is as large as is typical of it, on a robot of this size."""
    scale, table = scale_of(engine.simulators[0]), parameter_table()
    measured = [p for p in registry()[name].parameters if p.strength and p.unit in RULED]
    sizes = [float(np.abs(fit.values[:, table.place(f"{name}.{p.name}")] - p.null).max()) for p in measured]
    least = [p.typical_size * scale.factor(p.unit) for p in measured]
    return any(size >= typical > 0.0 for size, typical in zip(sizes, least, strict=True))
