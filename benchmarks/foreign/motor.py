"""A brushed DC motor with its gear, driver, heat and friction, as torque on one wheel; used by every engine.

Sources: Franklin, Powell & Emami-Naeini, Feedback Control of Dynamic Systems (DC motor: V = R i + Ke w, torque = Kt i);
Armstrong-Helouvry, Dupont & Canudas de Wit, Automatica 30 (1994) (Stribeck curve); Canudas de Wit et al., IEEE TAC 40
(1995) (LuGre bristles); Nordin & Gutman, Automatica 38 (2002) (gear play as a spring with a gap); Plett, Battery
Management Systems I (2015) (open-circuit voltage, series resistance, one RC pair); Hughes & Drury, Electric Motors and
Drives (winding heat, copper 0.39 % per kelvin).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

ROTOR_ANGLE, ROTOR_RATE, BRISTLE, HEAT, CURRENT, DUTY, MOTOR_STATES = 0, 1, 2, 3, 4, 5, 6
CHARGE, POLAR, VOLTS, SUPPLY_STATES = 0, 1, 2, 3


class Motor(NamedTuple):
    """One wheel's drive; torques [N m] and rates [rad/s] at the wheel, voltage as a share of the nominal one."""

    stall: float  # torque at duty 1, rate 0
    no_load: float  # rate at duty 1, torque 0
    gain: float = 1.0  # share of the voltage that arrives
    rotor: float = 1e-4  # rotor and gear inertia seen at the wheel [kg m2]
    stick: float = 0.0  # duty below which a resting wheel does not start
    stick_rate: float = 0.0  # below this rate [rad/s] the wheel counts as resting
    coulomb: float = 0.0  # kinetic dry friction [N m]
    breakaway: float = 0.0  # extra friction near rest [N m]
    stribeck: float = 1.0  # rate over which the extra fades [rad/s]
    viscous: float = 0.0  # [N m s]
    bristle: float = 0.0  # deflection at which a LuGre bristle slides [rad]; 0 = no bristles
    reverse_emf: float = 1.0  # back-EMF constant in reverse over forward (brush advance)
    reverse_torque: float = 1.0  # torque constant in reverse over forward (gear efficiency)
    coast: float = 0.0  # share of the braking current that the driver's slow decay loses
    current_limit: float = 1e9  # in units of the stall current
    ramp_up: float = 0.0  # time constant of the driver while the duty grows [s]
    ramp_down: float = 0.0  # and while it falls [s]
    gap: float = 0.0  # gear play [rad at the wheel]
    mesh: float = 0.0  # stiffness of the meshed gear [N m/rad]
    mesh_damping: float = 0.0  # [N m s/rad]
    heat_resistance: float = 0.0  # growth of winding resistance at full heat
    heat_magnet: float = 0.0  # loss of torque constant at full heat
    heat_grease: float = 0.0  # loss of viscous friction at full heat
    heat_time: float = 30.0  # thermal time constant [s]
    heat_load: float = 0.0  # heat by current squared (share of full heat at stall current)
    heat_run: float = 0.0  # heat by running (share of full heat at no-load rate)
    ripple: float = 0.0  # torque ripple at resonance [N m]
    ripple_rate: float = 1.0  # rate of the resonance [rad/s]
    ripple_width: float = 1.0  # [rad/s]
    ripple_teeth: float = 12.0  # ripples in one turn


class Supply(NamedTuple):
    """The battery, voltages as shares of the nominal one, currents in units of one motor's stall current."""

    series: float = 0.0  # voltage drop per unit of current
    polar: float = 0.0  # drop of the RC pair per unit of current, settled
    polar_time: float = 8.0  # [s]
    slope: float = 0.0  # loss of open-circuit voltage per unit of charge
    knee: float = 0.0  # exponential loss near the end (Shepherd)
    knee_charge: float = 10.0
    brownout: float = 1e9  # total current at which the regulator folds back
    start: float = 0.0  # charge already taken


@njit(cache=True)
def supply_step(dt: float, draw: float, s: np.ndarray, p: Supply) -> None:
    """Advance the battery by `dt` under a draw; s[VOLTS] becomes the voltage for the next step."""
    s[CHARGE] += dt * draw
    s[POLAR] += dt * (p.polar * draw - s[POLAR]) / p.polar_time
    charge = p.start + s[CHARGE]
    volts = 1.0 - p.slope * charge - p.knee * np.exp(min(charge - p.knee_charge, 0.0) / (0.3 * p.knee_charge))
    volts -= p.series * draw + s[POLAR]
    if draw > p.brownout:
        volts *= p.brownout / draw
    s[VOLTS] += min(1.0, dt / 0.01) * (max(volts, 0.2) - s[VOLTS])


@njit(cache=True)
def friction_torque(dt: float, rate: float, s: np.ndarray, p: Motor) -> float:
    """Dry friction with Stribeck's extra near rest, regularised or as LuGre bristles, and viscous friction."""
    level = p.coulomb + p.breakaway * np.exp(-((rate / p.stribeck) ** 2))
    viscous = p.viscous * max(1.0 - p.heat_grease * s[HEAT], 0.1)
    if level <= 0.0:
        return viscous * rate
    if p.bristle > 0.0:
        stiff = level / p.bristle
        s[BRISTLE] += dt * (rate - abs(rate) * s[BRISTLE] / p.bristle)
        s[BRISTLE] = min(max(s[BRISTLE], -p.bristle), p.bristle)
        return stiff * s[BRISTLE] + viscous * rate
    return level * np.tanh(rate / 0.15) + viscous * rate


@njit(cache=True)
def wheel_torque(
    dt: float, duty: float, angle: float, rate: float, volts: float, s: np.ndarray, p: Motor
) -> float:
    """Return the torque on a wheel at `angle` [rad], `rate` [rad/s]; advances the motor's state `s` by `dt`.

    With gear play (`gap`) the rotor is a body of its own and only the mesh turns the wheel.
    """
    play = p.gap > 0.0
    shaft = s[ROTOR_RATE] if play else rate
    wanted = duty
    if abs(duty) < p.stick and abs(rate) < p.stick_rate:
        wanted = 0.0
    lag = p.ramp_up if abs(wanted) > abs(s[DUTY]) and wanted * s[DUTY] >= 0.0 else p.ramp_down
    s[DUTY] += (wanted - s[DUTY]) * (min(1.0, dt / lag) if lag > 0.0 else 1.0)
    emf = shaft / p.no_load * (p.reverse_emf if shaft < 0.0 else 1.0) * (1.0 - p.heat_magnet * s[HEAT])
    current = (p.gain * volts * s[DUTY] - emf) / (1.0 + p.heat_resistance * s[HEAT])
    if current * shaft < 0.0 and abs(shaft) > 0.05:
        current *= 1.0 - p.coast
    current = min(max(current, -p.current_limit), p.current_limit)
    s[CURRENT] = abs(current * s[DUTY])  # the battery feeds the bridge's duty share
    s[HEAT] += (
        dt * (p.heat_load * current * current + p.heat_run * abs(shaft) / p.no_load - s[HEAT]) / p.heat_time
    )
    torque = (
        p.stall * current * (1.0 - p.heat_magnet * s[HEAT]) * (p.reverse_torque if current < 0.0 else 1.0)
    )
    if p.ripple > 0.0:
        torque += (
            p.ripple
            * np.exp(-(((abs(shaft) - p.ripple_rate) / p.ripple_width) ** 2))
            * np.sin(p.ripple_teeth * angle)
        )
    torque -= friction_torque(dt, shaft, s, p)
    if not play:
        return torque
    twist = s[ROTOR_ANGLE] - angle
    mesh = 0.0
    if abs(twist) > 0.5 * p.gap:
        mesh = p.mesh * (twist - np.sign(twist) * 0.5 * p.gap) + p.mesh_damping * (shaft - rate)
        if mesh * twist < 0.0:
            mesh = 0.0
    s[ROTOR_RATE] += dt * (torque - mesh) / p.rotor
    s[ROTOR_ANGLE] += dt * s[ROTOR_RATE]
    return mesh


@njit(cache=True)
def drive_step(
    dt: float, parts: int, duty, angle, rate, volts, ml, mr, left: Motor, right: Motor, supply: Supply, out
) -> None:
    """Write the mean torques on both wheels over `parts` steps of `dt`, the rates held: for engines with longer steps."""
    out[0] = 0.0
    out[1] = 0.0
    for k in range(parts):
        supply_step(dt, ml[CURRENT] + mr[CURRENT], volts, supply)
        row = min(k, len(duty) - 1)
        for side in range(2):
            memory = ml if side == 0 else mr
            motor = left if side == 0 else right
            at = angle[side] + rate[side] * k * dt
            out[side] += (
                wheel_torque(dt, duty[row, side], at, rate[side], volts[VOLTS], memory, motor) / parts
            )
