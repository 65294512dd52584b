"""Real recordings beside those of the user's own simulator: what the real robot has that the simulator lacks.

The catalogue describes the simulator first: its recordings are diagnosed. The real recordings are then diagnosed in a
world that has the simulator's effects, the base robot fitted anew, so that only what differs is left to be named.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from fsm_calib.diagnosis.diagnose import Diagnosis, diagnose
from fsm_calib.diagnosis.replay.settings import DEFAULT_SETTINGS, Settings
from fsm_calib.diagnosis.sized import identified_facts, sized
from fsm_calib.diagnosis.verdict.explain import estimates
from fsm_calib.diagnosis.verdict.plain import number
from fsm_calib.diagnosis.verdict.verdict import Estimate
from fsm_calib.diagnosis.verdict.weight import weighed, weight_of
from fsm_calib.errors import DataError
from fsm_calib.recording.recording import Recording
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table


@dataclass(frozen=True, slots=True)
class Difference:
    """A number that both robots have: real minus simulated, its standard deviation, and z = difference / sd.

    name : full name in the parameter table; sd and z are nan where the data of one cannot tell the number.
    """

    name: str
    real: Estimate
    simulated: Estimate

    @property
    def value(self) -> float:
        """Real minus simulated [the parameter's unit]."""
        return self.real.value - self.simulated.value

    @property
    def sd(self) -> float:
        """Both standard deviations together [the parameter's unit]."""
        return math.hypot(self.real.sd, self.simulated.sd)

    @property
    def z(self) -> float:
        """The difference in its standard deviations [1]."""
        return self.value / self.sd if self.sd > 0.0 else math.nan


@dataclass(frozen=True, eq=False)
class Against:
    """The real robot's diagnosis in the simulator's world, the simulator's own, and where numbers differ.

    sizes : of the simulator's effects, by effect and parameter; differences : of every named effect and of the base.
    """

    real: Diagnosis
    simulated: Diagnosis
    sizes: dict[str, dict[str, Estimate]]
    differences: tuple[Difference, ...]

    def as_json(self) -> dict[str, Any]:
        """Return the real robot's verdict as `diagnose --json` has it, with `against`."""
        names = {effect.name for effect in self.real.verdict.effects}
        return self.real.verdict.as_json() | {
            "against": {
                "verdict": self.simulated.verdict.verdict,
                "reason": self.simulated.verdict.reason,
                "effects": {
                    name: {key: _plain(e) for key, e in numbers.items()}
                    for name, numbers in self.sizes.items()
                },
                "lacks": sorted(names - set(self.sizes)),
                "otherwise": sorted(names & set(self.sizes)),
                "alike": sorted(set(self.sizes) - names),
                "differences": [
                    {
                        "name": d.name,
                        "real": number(d.real.value),
                        "simulated": number(d.simulated.value),
                        "difference": number(d.value),
                        "sd": number(d.sd),
                        "z": number(d.z),
                        "unit": d.real.unit,
                    }
                    for d in self.differences
                ],
            }
        }


def diagnose_against(
    recordings: Sequence[Recording],
    simulated: Sequence[Recording],
    holdouts: Sequence[Recording] = (),
    *,
    without: Iterable[str] = (),
    settings: Settings = DEFAULT_SETTINGS,
    progress: Callable[[str], None] = lambda part: None,
    seed: int = 0,
) -> Against:
    """Say what a real robot has that a simulator lacks, or has otherwise.

    Parameters
    ----------
    recordings, holdouts, settings : of the real robot, as in `diagnose`.
    simulated : what the simulator's robot did, with the same commands or others.

    Raises
    ------
    DataError
        No simulated recording was given, or one of either kind cannot be diagnosed.
    """
    if not simulated:
        raise DataError("no simulated recording was given", cure="Give one after --against.")
    left_out = tuple(without)
    size, _ = identified_facts(recordings)
    # commands of both must have one unit, so the simulated robot's facts are the real one's where it states none
    real, new = ([sized(r, size) for r in group] for group in (recordings, holdouts))
    described = diagnose(
        [sized(s, real[0].robot) for s in simulated] if real else simulated,
        without=left_out,
        settings=settings,
        progress=progress,
        seed=seed,
    )
    found = diagnose(
        real,
        new,
        without=left_out,
        world=effects_of(described),
        settings=settings,
        progress=progress,
        seed=seed,
    )
    sizes = sizes_of(described)
    return Against(found, described, sizes, tuple(_differences(found, described, sizes)))


def effects_of(diagnosis: Diagnosis) -> dict[str, float]:
    """Return the values of the effects that a diagnosis fitted, by full name; events of one recording are left out."""
    table, values = parameter_table(), diagnosis.decision.model.fit.values[0]
    active = [name for name in table.active_effects(values) if registry()[name].scan != "time"]
    return {table.names[i]: float(values[i]) for name in active for i in table.of_effect(name)}


def sizes_of(diagnosis: Diagnosis) -> dict[str, dict[str, Estimate]]:
    """Return the fitted numbers of every effect that a diagnosis has, named or not; events are left out."""
    model = diagnosis.decision.model
    return {
        ranked.name: weighed(estimates(ranked, model.fit), weight_of(diagnosis.decision.engine.simulators))
        for ranked in model.effects
        if registry()[ranked.name].scan != "time"
    }


def _differences(
    found: Diagnosis, described: Diagnosis, sizes: dict[str, dict[str, Estimate]]
) -> Iterable[Difference]:
    """Yield the differences of the named effects' numbers, then those of the base robot."""
    for effect in found.verdict.effects:
        own = sizes.get(effect.name, {})
        for p in registry()[effect.name].parameters:
            nothing = Estimate(p.null, 0.0, p.unit)
            if p.fitted and (p.name in effect.parameters or p.name in own):
                real, simulated = effect.parameters.get(p.name, nothing), own.get(p.name, nothing)
                yield Difference(f"{effect.name}.{p.name}", real, simulated)
    for name, real in found.verdict.base.items():
        if name in described.verdict.base:
            yield Difference(name, real, described.verdict.base[name])


def _plain(estimate: Estimate) -> dict[str, Any]:
    return {"value": number(estimate.value), "sd": number(estimate.sd), "unit": estimate.unit}
