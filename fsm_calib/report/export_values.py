"""The numbers of a diagnosis that other programs can take: the stated robot, the fitted one, the effects it has."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from fsm_calib.diagnosis.diagnose import Diagnosis
from fsm_calib.diagnosis.fitting.fit import Fit
from fsm_calib.diagnosis.replay.prepared import NOMINAL_AXLE, NOMINAL_RADIUS
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

SIDES = ("left", "right")


@dataclass(frozen=True)
class ExportValues:
    """A robot as it was stated and as its recordings show it.

    Left and right in pairs. radius, axle [m] : as stated; full_speed [m/s] : stated rim speed at command 1; gains
    [m/s] : fitted rim speed at command 1; rolling_radii [m] : that the wheels turn into path; fitted_axle [m]; mass
    [kg] : that the fit took for the robot's; effects : all values of each effect that the fit has, events of one
    recording left out; named : the effects that the verdict names; assumed : which sizes nobody stated.
    """

    robot: str
    radius: float
    axle: float
    full_speed: float
    gains: tuple[float, float]
    rolling_radii: tuple[float, float]
    fitted_axle: float
    mass: float
    effects: Mapping[str, Mapping[str, float]]
    named: tuple[str, ...]
    assumed: tuple[str, ...]
    measured_input: bool


def export_values(diagnosis: Diagnosis) -> ExportValues:
    """Return the numbers of a diagnosis.

    A wheel's rolling radius is the fitted one where its angle was measured beside the commands; else what its gain
    makes of the stated radius: R K / K_stated.
    """
    decision = diagnosis.decision
    fit, simulator = decision.model.fit, decision.engine.simulators[0]
    facts = simulator.prepared.recording.robot
    table, values = parameter_table(), fit.values[0]
    left, right = (float(values[table.place(f"gain_{side}")]) for side in SIDES)
    radius = facts.wheel_radius or NOMINAL_RADIUS
    ratios = (left / simulator.full_speed, right / simulator.full_speed)
    free = {table.names[slot.place] for slot in fit.slots}
    rolling = (radius * ratios[0], radius * ratios[1])
    if "wheel_radius_left" in free:
        a, b = (float(values[table.place(f"wheel_radius_{side}")]) for side in SIDES)
        rolling = (a, b)
    untold = {"wheel radius": facts.wheel_radius, "axle length": facts.axle_length}
    return ExportValues(
        robot=facts.name,
        radius=radius,
        axle=facts.axle_length or NOMINAL_AXLE,
        full_speed=simulator.full_speed,
        gains=(left, right),
        rolling_radii=rolling,
        fitted_axle=float(values[table.place("axle_length")]),
        mass=float(values[table.place("mass")]),
        effects=effects_of(fit),
        named=tuple(effect.name for effect in diagnosis.verdict.effects),
        assumed=tuple(name for name, value in untold.items() if not value),
        measured_input=simulator.measured_input,
    )


def effects_of(fit: Fit) -> dict[str, dict[str, float]]:
    """Return every value of the effects that a fit has, by effect; an event of one recording is no part of a robot."""
    table = parameter_table()
    return {
        name: {
            p.name: float(fit.values[0, table.place(f"{name}.{p.name}")]) for p in registry()[name].parameters
        }
        for name in table.active_effects(fit.values[0])
        if registry()[name].scan != "time"
    }
