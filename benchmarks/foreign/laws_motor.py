"""Laws inside the drive: friction, play, heat, battery, brushes. Fields of `foreign.motor`, sources there."""

from __future__ import annotations

import numpy as np

from foreign.catalogue import Sizes, law, which_wheels
from foreign.setup import Setup


def put(setup: Setup, which: str, **fields: float) -> None:
    """Set fields of some wheels' motors."""
    for wheel in setup.wheels(which):
        wheel.update(fields)


@law("motor_deadband", "static_friction", most=4)
def static_friction(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A resting wheel starts only above a duty; once it turns, nothing is lost (Armstrong-Helouvry's rising stiction)."""
    d, which = 0.10 * s, which_wheels(rng)
    put(setup, which, stick=d, stick_rate=0.04 * setup.left["no_load"])
    return {"wheels": which, "threshold": d}


@law("command_saturation", "current_limit", most=2.5)
def current_limit(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A chopper limits the current: torque is capped, speed is not."""
    top = 0.16 / s**1.5
    put(setup, "both", current_limit=top)
    return {"wheels": "both", "current_share_of_stall": top}


@law("motor_reverse_asymmetry", "brush_advance", most=4)
def brush_advance(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Brushes set off the neutral plane: another back-EMF and torque constant in reverse."""
    k, which = float(1.0 + rng.choice([-1, 1]) * 0.11 * s), which_wheels(rng)
    put(setup, which, reverse_emf=max(k, 0.3), reverse_torque=max(k, 0.3))
    return {"wheels": which, "reverse_over_forward": 1.0 / max(k, 0.3)}


@law("motor_asymmetric_lag", "driver_filter", most=5)
def driver_filter(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A driver whose output follows with one time constant up and another down."""
    slow, fast = 0.12 * s, 0.0
    up, down = (slow, fast) if rng.random() < 0.5 else (fast, slow)
    which = which_wheels(rng, 0.8)
    put(setup, which, ramp_up=up, ramp_down=down)
    return {"wheels": which, "up_s": up, "down_s": down}


@law("motor_asymmetric_lag", "slow_decay", most=2.0)
def slow_decay(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """The bridge freewheels: braking current is lost, so the robot slows down later than it speeds up."""
    k, which = min(0.5 * s, 0.97), which_wheels(rng, 0.8)
    put(setup, which, coast=k)
    return {"wheels": which, "braking_lost": k}


@law("coulomb_friction", "stribeck", most=4)
def stribeck(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Dry friction with Stribeck's extra near rest."""
    which, top = which_wheels(rng), 0.05 * s * setup.stall
    put(
        setup,
        which,
        coulomb=top,
        breakaway=float(rng.uniform(0.2, 0.6)) * top,
        stribeck=float(rng.uniform(0.5, 2.0)),
    )
    return {"wheels": which, "torque_Nm": top, "share_of_stall": 0.05 * s}


@law("coulomb_friction", "dry_and_viscous", most=4)
def dry_and_viscous(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Dry and viscous friction of a greased gear."""
    which, top = which_wheels(rng), 0.05 * s * setup.stall
    put(setup, which, coulomb=top, viscous=0.4 * top / setup.left["no_load"])
    return {"wheels": which, "torque_Nm": top, "share_of_stall": 0.05 * s}


@law("coulomb_friction", "lugre", most=4)
def lugre(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """LuGre bristles: presliding displacement, breakaway, sliding."""
    which, top = which_wheels(rng), 0.05 * s * setup.stall
    put(setup, which, coulomb=top, breakaway=0.4 * top, stribeck=0.8, bristle=0.03)
    return {"wheels": which, "torque_Nm": top, "share_of_stall": 0.05 * s}


def play(setup: Setup, which: str, gap: float, hertz: float, damping: float) -> None:
    """Give some wheels a gear with play; the mesh rings at `hertz` with a damping ratio."""
    for wheel in setup.wheels(which):
        free = wheel["rotor"] * 0.2
        stiff = free * (2 * np.pi * hertz) ** 2
        wheel.update(gap=gap, mesh=stiff, mesh_damping=2 * damping * np.sqrt(stiff * free))


@law("gear_backlash", "stiff_mesh", most=8)
def stiff_mesh(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Play in a stiff spur gear."""
    which, gap = which_wheels(rng), 0.12 * s
    play(setup, which, gap, 60.0, 0.7)
    return {"wheels": which, "play_rad": gap}


@law("gear_backlash", "rubber_coupling", most=8)
def rubber_coupling(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Play in a soft coupling."""
    which, gap = which_wheels(rng), 0.12 * s
    play(setup, which, gap, 18.0, 0.4)
    return {"wheels": which, "play_rad": gap}


@law("gear_backlash", "dry_lost_motion", most=8)
def lost_motion(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A worn key and a gear with dry friction."""
    which, gap = which_wheels(rng, 0.4), 0.14 * s
    play(setup, which, gap, 45.0, 0.9)
    put(setup, which, coulomb=0.006 * setup.stall)
    return {"wheels": which, "play_rad": gap}


@law("battery_sag", "discharge", most=5)
def discharge(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Open-circuit voltage falls with the charge taken, and there is a series resistance."""
    setup.supply.update(slope=0.035 * s, series=0.05 * s)
    return {"series_share": 0.05 * s, "ocv_per_charge": 0.035 * s}


@law("battery_sag", "series", most=5)
def series(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A tired pack: inner resistance alone; the voltage dips whenever a motor pulls."""
    setup.supply.update(series=0.25 * s)
    return {"series_share": 0.25 * s}


@law("battery_sag", "polarised", most=5)
def polarised(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Thevenin's pair: the voltage sinks within seconds under load and recovers at rest."""
    setup.supply.update(series=0.06 * s, polar=0.35 * s, polar_time=float(rng.uniform(4, 12)))
    return {"series_share": 0.06 * s, "polar_share": 0.35 * s, "polar_s": setup.supply["polar_time"]}


@law("battery_sag", "shepherd_knee", most=5)
def shepherd_knee(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Near empty: Shepherd's exponential knee."""
    setup.supply.update(knee=0.22 * s, knee_charge=float(rng.uniform(3, 6)), series=0.04 * s)
    return {"series_share": 0.04 * s, "knee": 0.22 * s}


@law("motor_warmup", "winding", most=5)
def winding(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Copper warms by current and running: the winding's resistance grows, loaded speed falls."""
    which = which_wheels(rng)
    put(
        setup,
        which,
        heat_resistance=2.5 * s,
        heat_load=6.0,
        heat_run=0.6,
        heat_time=float(rng.uniform(15, 40)),
        viscous=0.12 * setup.stall / setup.left["no_load"],
    )
    return {"wheels": which, "resistance_growth": 2.5 * s}


@law("motor_warmup", "magnet", most=5)
def magnet(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Warm ferrite magnets weaken: the no-load speed grows while torque falls."""
    which = which_wheels(rng)
    put(setup, which, heat_magnet=0.13 * s, heat_load=4.0, heat_run=1.2, heat_time=float(rng.uniform(12, 35)))
    return {"wheels": which, "flux_loss": 0.13 * s}


@law("motor_warmup", "grease", most=5)
def grease(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Cold grease thins while the gear runs: viscous friction fades."""
    which = which_wheels(rng)
    put(
        setup,
        which,
        viscous=0.2 * s * setup.stall / setup.left["no_load"],
        heat_grease=0.8,
        heat_run=2.0,
        heat_time=float(rng.uniform(10, 30)),
    )
    return {"wheels": which, "viscous_share": 0.2 * s}
