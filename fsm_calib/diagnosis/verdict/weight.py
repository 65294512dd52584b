"""What forces weigh: commands and poses tell accelerations, so that a force is known as far as the robot's mass is.

The fit moves a robot of the base's mass m0 (`parameters.BASE`). A robot of mass m that moves alike has every force,
moment and damper m / m0 times as large; its lengths, times and speeds are the same.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from fsm_calib.diagnosis.replay.simulator import Simulator
from fsm_calib.diagnosis.verdict.verdict import Estimate, NamedEffect
from fsm_calib.world2d.parameters import parameter_table
from fsm_calib.world2d.units import holds_mass


def weight_of(simulators: Sequence[Simulator]) -> float:
    """Return the robot's mass over that of the base [1]; 1 where no mass is stated."""
    mass = simulators[0].prepared.recording.robot.mass
    return mass / _base_mass() if mass else 1.0


def weighed(numbers: dict[str, Estimate], weight: float) -> dict[str, Estimate]:
    """Return numbers of a robot that is `weight` times as heavy as the base."""
    return {
        name: Estimate(weight * e.value, weight * e.sd, e.unit) if holds_mass(e.unit) else e
        for name, e in numbers.items()
    }


def untold_mass(effects: Iterable[NamedEffect], simulators: Sequence[Simulator]) -> list[str]:
    """Return a sentence where a force was told of a robot whose mass nobody stated."""
    robot = simulators[0].prepared.recording.robot
    forces = [e.name for e in effects if any(holds_mass(p.unit) for p in e.parameters.values())]
    if robot.mass is not None or not forces:
        return []
    return [
        f"forces of {', '.join(forces)} are those of a robot of {_base_mass():g} kg: no mass was stated "
        "(robot: {mass: KG} in the manifest, or --urdf)"
    ]


def _base_mass() -> float:
    table = parameter_table()
    return float(table.null[table.place("mass")])
