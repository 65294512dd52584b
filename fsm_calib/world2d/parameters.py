"""The parameter vector P: the base robot, then every effect of the registry; a table of names and places.

Names are ``gain_left`` for the base and ``battery_sag.per_charge`` for effects. P is a plain float64 array,
because fits perturb it by the hundred; `ParameterTable` gives it meaning.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from fsm_calib.errors import InputError, UnknownNameError
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import Effect, Parameter, per_catalogue, registry
from fsm_calib.world2d.scale import Scale

KINEMATICS = (
    "Duckietown kinematics node: motor constant 27 rad/s, radius 0.0318 m; DB18 model 0.6 m/s at full command"
)
SPREAD = "gains of 32 real robots: right over left 0.78 to 1.19 (Duckietown calibration logs)"
MODEL = "duckietown-world pwm_dynamics.py: 0.2 and 0.25 s in the DB18 model; 1.1 kg, 0.2 N m: 0.08, 0.15 s"
ROTOR = "a rotor of 1.2e-7 kg m2 behind 48:1 gears; a third of a Duckiebot's inertia, assumed"
SLIP_RATIO = (
    "0.03 to 0.1 on car tyres, more on soft rubber (Pacejka 2012, section 1.2.1); contacts of simulators: 0"
)
CELLS = "two lithium cells: 8.4 V full, 7.4 V nominal, 6.6 V empty; no-load speeds are in proportion to the voltage"
ASSUMED = "assumed; no published measurement was found"

BASE: tuple[Parameter, ...] = (
    Parameter(
        "gain_left",
        "K_l",
        "m/s",
        0.636,
        0.05,
        10.0,
        0.66,
        f"{KINEMATICS}; {SPREAD}",
        mirror="swap:gain_right",
    ),
    Parameter(
        "gain_right",
        "K_r",
        "m/s",
        0.636,
        0.05,
        10.0,
        0.60,
        f"{KINEMATICS}; {SPREAD}",
        mirror="swap:gain_left",
    ),
    Parameter("axle_length", "b", "m", 0.100, 0.03, 1.0, 0.102, "Duckietown kinematics node: baseline 0.1 m"),
    Parameter("tau_forward", "tau_v", "s", 0.08, 0.005, 1.5, 0.09, MODEL),
    Parameter("tau_turn", "tau_w", "s", 0.15, 0.005, 1.5, 0.17, MODEL),
    Parameter(
        "wheel_radius_left",
        "R_l",
        "m",
        0.0318,
        0.005,
        0.5,
        0.032,
        KINEMATICS,
        mirror="swap:wheel_radius_right",
    ),
    Parameter(
        "wheel_radius_right",
        "R_r",
        "m",
        0.0318,
        0.005,
        0.5,
        0.032,
        KINEMATICS,
        mirror="swap:wheel_radius_left",
    ),
    Parameter("mass", "m", "kg", 1.1, 0.2, 1000.0, 1.1, f"DB18 with battery, {ASSUMED}", fitted=False),
    Parameter("friction", "mu", "1", 0.75, 0.05, 50.0, 0.75, f"rubber on foam mats, {ASSUMED}", fitted=False),
    Parameter(
        "slip_speed",
        "s0",
        "m/s",
        0.0125,
        1e-5,
        0.2,
        0.0125,
        f"tyre lag of 2 to 3 ms, {ASSUMED}",
        fitted=False,
    ),
    Parameter("caster_share", "c", "1", 0.0, 0.0, 0.6, 0.1, f"weight on the caster, {ASSUMED}", fitted=False),
    Parameter("wheel_inertia", "J", "kg m2", 2.8e-4, 0.0, 10.0, 2.8e-4, ROTOR, fitted=False),
    Parameter("slip_ratio", "kappa", "1", 0.0, 0.0, 2.0, 0.1, SLIP_RATIO, step=2e-3, prior=0.2, fitted=False),
    Parameter("charge", "c_b", "1", 1.0, 0.3, 3.0, 0.93, CELLS, step=1e-3, prior=0.1, fitted=False),
)
"""The base robot, in the order of `dynamics`' places."""

NUISANCE = ("gain_left", "gain_right", "axle_length", "tau_forward", "tau_turn")
"""What a fit may always move."""


@dataclass(frozen=True, eq=False)
class ParameterTable:
    """Where each parameter lies in P.

    entries : the parameters in order; names : their full names; index : name to place; owner : name of the
    effect of each place ("" for the base); first : place of each effect's first parameter.
    """

    entries: tuple[Parameter, ...]
    names: tuple[str, ...]
    index: Mapping[str, int]
    owner: tuple[str, ...]
    first: Mapping[str, int]

    @property
    def null(self) -> FloatArray:
        """A new vector with the default base and every effect off, shape (n,)."""
        return np.array([entry.null for entry in self.entries])

    def place(self, name: str) -> int:
        """Return the place of a full name.

        Raises
        ------
        UnknownNameError
            When there is no such parameter; offers the nearest.
        """
        try:
            return self.index[name]
        except KeyError:
            raise UnknownNameError("parameter", name, self.index) from None

    def of_effect(self, name: str) -> tuple[int, ...]:
        """Return the places of an effect's parameters."""
        return tuple(i for i, owner in enumerate(self.owner) if owner == name)

    def active_effects(self, vector: FloatArray) -> tuple[str, ...]:
        """Return the names of the effects that `vector` switches on."""
        on = [
            o
            for o, e, x in zip(self.owner, self.entries, vector, strict=True)
            if o and e.strength and x != e.null
        ]
        return tuple(dict.fromkeys(on))

    def check(self, vector: FloatArray, where: str = "") -> None:
        """Refuse a vector with a wrong length, a NaN or a value outside the physical bounds of a robot of its axle and
        speed (InputError).
        """
        vector = np.asarray(vector)
        if vector.shape != (len(self.names),):
            raise InputError(f"{vector.shape} parameters, expected ({len(self.names)},)", where=where)
        gains = max(vector[self.index["gain_left"]], vector[self.index["gain_right"]])
        scale = Scale.of(float(vector[self.index["axle_length"]]), float(gains))
        for name, entry, value in zip(self.names, self.entries, vector, strict=True):
            low, high = scale.bounds(entry)
            if not low <= value <= high and value != entry.null:
                raise InputError(
                    f"{name} is {value:g} {entry.unit}, not in {low:g} to {high:g} {entry.unit}",
                    where=where,
                    cure="Give a value within these physical bounds of a robot of this axle and speed.",
                )

    def mirrored(self, vector: FloatArray) -> FloatArray:
        """Return the parameters of the robot's mirror image in a mirrored world."""
        image = np.array(vector, dtype=float)
        for i, entry in enumerate(self.entries):
            if entry.mirror == "negate":
                image[i] = -vector[i]
            elif entry.mirror.startswith("swap:"):
                prefix = f"{self.owner[i]}." if self.owner[i] else ""
                image[i] = vector[self.index[prefix + entry.mirror[5:]]]
        return image


@per_catalogue
def parameter_table() -> ParameterTable:
    """Return the table of the base and all registered effects."""
    entries, names, owner, first = list(BASE), [p.name for p in BASE], [""] * len(BASE), {}
    for effect in registry().values():
        first[effect.name] = len(entries)
        entries += effect.parameters
        names += [f"{effect.name}.{p.name}" for p in effect.parameters]
        owner += [effect.name] * len(effect.parameters)
    index = {name: i for i, name in enumerate(names)}
    return ParameterTable(tuple(entries), tuple(names), index, tuple(owner), first)


def null_parameters() -> FloatArray:
    """Return a new parameter vector: the default robot, every effect off."""
    return parameter_table().null


def parameters(values: Mapping[str, float] | Iterable[tuple[str, float]] = ()) -> FloatArray:
    """Return a checked vector with the given full names set and the rest at their null values.

    Raises
    ------
    UnknownNameError, InputError
        For a name that does not exist or a value outside its bounds.
    """
    table = parameter_table()
    vector = table.null
    for name, value in dict(values).items():
        vector[table.place(name)] = value
    table.check(vector)
    return vector


def typical_parameters(effect: Effect, base: FloatArray | None = None) -> FloatArray:
    """Return a vector with `effect` at its typical size on the given base (default: `null_parameters`)."""
    table = parameter_table()
    vector = table.null if base is None else np.array(base, dtype=float)
    for i in table.of_effect(effect.name):
        vector[i] = table.entries[i].typical
    return vector
