"""The base robot: what every hypothesis re-fits, because a re-fit is exactly what conceals an effect."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.fitting.slot import Slot
from fsm_calib.diagnosis.likelihood.noise import Noise
from fsm_calib.diagnosis.replay.simulator import Simulator, nominal_values, scale_of
from fsm_calib.recording.recording import RobotFacts
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import Parameter, registry
from fsm_calib.world2d.parameters import NUISANCE, parameter_table
from fsm_calib.world2d.scale import SMALL, Scale

SLIP_SPREAD = (
    0.006  # m/s: tyres of small robots differ by half of the default slip speed (benchmarks/rollout.py)
)
GRIP_SPREAD, LEAST_GRIP, MOST_GRIP = (
    0.15,
    0.1,
    1.5,
)  # 1: rubber on a wet or dusty floor to rubber on rubber; on dry hard ones 0.5 to 0.9
AXLE_SPREAD = 0.05  # of the stated axle: a tape measures the track, tyres touch the floor a width beside it
SHEET_SPREAD = 0.03  # of radius and axle where wheels are measured: sheets err by 2.5 %, beyond it is skid
FARTHEST = 4.0  # spreads: an axle or a wheel farther from the stated one is another physics, not a re-fit
TYPICAL_LAG, LAG_SPREAD = (
    0.15,
    0.25,
)  # s: time constants of small robots are 0.05 to 0.3 s; weak, data overrule it
TURNING_SHARES = (
    0.3,
    3.0,
)  # tau_turn over tau_forward: a body all at the axle's middle, one as long as three axles
TYPICAL_TRAIL, TRAIL_SPREAD, LONGEST_TRAIL = (
    0.0066,
    0.002,
    0.01,
)  # s: turning trails measured wheels by the shortest lag and what the tyres add for a yaw inertia that nobody knows
ROUNDS = 4  # fit and noise in turn; two suffice on clean data
ENOUGH = 0.5  # log-likelihood units between rounds
PHASES = 16  # around a turn: nearer than the width of a periodic effect's likelihood

SPEED_NOISE = (2, 3, 4)
POSE_NOISE = (0, 1, 2, 3, 4, 5, 8)
ENCODER_NOISE = (6, 7)


def base_slots(simulators: Sequence[Simulator], values: FloatArray) -> tuple[Slot, ...]:
    """Return what a fit of the base robot moves.

    Gains, axle, two time constants and the tyres' slip speed under a prior, and with encoders the wheel radii; measured
    wheel speeds have no motor between them and the floor, turning alone trails them.
    """
    robot, measured = simulators[0].prepared.recording.robot, simulators[0].measured_input
    names = list(NUISANCE[:3]) if measured else list(NUISANCE)
    if have_encoders(simulators):
        names += ["wheel_radius_left", "wheel_radius_right"]
    scale = scale_of(simulators[0])
    slots = [slot_of(name, scale=scale) for name in names]
    if robot.axle_length:
        slots[2] = near(slots[2], robot.axle_length, SHEET_SPREAD if measured else AXLE_SPREAD)
    if robot.wheel_radius and measured:
        slots[:2] = [near(slot, float(values[slot.place]), SHEET_SPREAD) for slot in slots[:2]]
    if measured:
        trail = replace(slot_of("tau_turn"), high=LONGEST_TRAIL, centre=TYPICAL_TRAIL, spread=TRAIL_SPREAD)
        return (*slots, trail)
    lags = (TYPICAL_LAG, TYPICAL_LAG * turning_share(robot, values))
    slots[3:5] = [replace(s, centre=lag, spread=LAG_SPREAD) for s, lag in zip(slots[3:5], lags, strict=True)]
    slip = slot_of("slip_speed", scale=scale)
    centre, spread = scale.speed * float(values[slip.place]), scale.speed * SLIP_SPREAD
    slots.append(Slot(slip.place, 5e-4, slip.high, 2e-4, centre=centre, spread=spread))
    return tuple(slots)


def grip_slot(values: FloatArray) -> Slot:
    """Return the tyres' grip on the floor [1] about its nominal value: a number that no manifest states."""
    slot = slot_of("friction")
    centre = float(values[slot.place])
    return replace(slot, low=LEAST_GRIP, high=MOST_GRIP, centre=centre, spread=GRIP_SPREAD)


def turning_share(robot: RobotFacts, values: FloatArray) -> float:
    """Return tau_turn over tau_forward [1] as the stated mass and inertia make it; 1 where they are not stated.

    (I + m_w b^2 / 2) / (b^2 / 4 (m + 2 m_w)) after `world2d.dynamics`, the wheels' m_w in the base's share of the mass.
    """
    if robot.mass is None or robot.inertia is None:
        return 1.0
    table = parameter_table()
    axle, radius, mass, inertia = (
        float(values[table.place(name)])
        for name in ("axle_length", "wheel_radius_left", "mass", "wheel_inertia")
    )
    rotating = inertia / radius**2 / mass
    share = (4.0 * robot.inertia / (robot.mass * axle**2) + 2.0 * rotating) / (1.0 + 2.0 * rotating)
    return float(np.clip(share, *TURNING_SHARES))


def near(slot: Slot, stated: float, spread: float) -> Slot:
    """Return the slot with a prior around a stated value, `spread` relative to it, and bounds not far beyond."""
    slack = spread * stated
    low, high = stated - FARTHEST * slack, stated + FARTHEST * slack
    return replace(slot, low=low, high=high, centre=stated, spread=slack)


def slot_of(name: str, run: int = -1, scale: Scale = SMALL) -> Slot:
    """Return the slot of a parameter with the physical bounds of a robot of some `scale`."""
    table = parameter_table()
    place = table.place(name)
    entry = table.entries[place]
    return Slot(place, *scale.bounds(entry), entry.difference_step, run, *_prior_of(entry))


def _prior_of(entry: Parameter) -> tuple[float, float]:
    """Return centre and spread of a parameter's declared prior; a spread of 0 is none."""
    return (entry.null, entry.prior) if entry.prior > 0.0 else (0.0, 0.0)


def have_encoders(simulators: Sequence[Simulator]) -> bool:
    """Return whether any recording has its wheels measured beside its poses."""
    return any(s.prepared.has_encoders for s in simulators)


def noise_names(simulators: Sequence[Simulator]) -> tuple[int, ...]:
    """Return the places of the noise levels that these recordings can tell."""
    return POSE_NOISE + (ENCODER_NOISE if have_encoders(simulators) else ())


def fit_base(engine: Engine, more: Sequence[str] = ()) -> Fit:
    """Fit the base robot and the noise in turn, from the robot as its manifest states it.

    more : full names of further parameters that are free. Effects of the simulators' world stay as they are; what
    they leave to each recording (the phase of an eccentric wheel) is found for each.
    """
    values = np.tile(nominal_values(engine.simulators), (len(engine.simulators), 1))
    slots = base_slots(engine.simulators, values[0]) + tuple(map(slot_of, more))
    free = noise_names(engine.simulators)
    own = slots_of_recordings(values)
    if own:
        start = engine.refit_noise(engine.fit(values, slots, Noise()), free, 8)
        values, slots = with_phases(engine, start, own), slots + own
    return _in_turn(engine, values, slots, free, Noise())


def slots_of_recordings(values: FloatArray) -> tuple[Slot, ...]:
    """Return the slots that active effects leave to each recording, `values` (R, p); strengths are not among them."""
    table = parameter_table()
    active = table.active_effects(values[0])
    names = [
        f"{name}.{p.name}"
        for name in active
        for p in registry()[name].parameters
        if p.per_recording and not p.strength
    ]
    return tuple(slot_of(name, run) for name in names for run in range(len(values)))


def with_phases(engine: Engine, fit: Fit, own: Sequence[Slot]) -> FloatArray:
    """Return the parameters of `fit` (R, p) with each recording's own numbers chosen around a turn, one by one."""
    whiteners, values = engine.whiteners(fit.noise), fit.values.copy()
    for slot in own:
        simulator = engine.simulators[slot.run]
        tried = np.tile(values[slot.run], (PHASES, 1))
        tried[:, slot.place] = np.linspace(0.0, 2.0 * np.pi, PHASES, endpoint=False)
        alone = Engine((simulator,))
        scores = [
            alone.log_likelihood(whiteners[slot.run : slot.run + 1], [s]) for s in simulator.increments(tried)
        ]
        values[slot.run] = tried[int(np.argmax(scores))]
    return values


def settled(engine: Engine, fit: Fit) -> Fit:
    """Return a fit whose numbers and noise were fitted in turn until that wins nothing.

    The noise begins anew, as it holds what the numbers now explain; only that commands act at odd moments is kept.
    """
    began = Noise(jitter=fit.noise.jitter)
    return _in_turn(engine, fit.values, fit.slots, noise_names(engine.simulators), began)


def _in_turn(
    engine: Engine, values: FloatArray, slots: tuple[Slot, ...], free: Sequence[int], noise: Noise
) -> Fit:
    """Fit parameters and noise in turn, from a noise on, until that wins nothing."""
    before = -np.inf
    for _ in range(ROUNDS):
        fit = engine.refit_noise(engine.fit(values, slots, noise), free, 8)
        values, noise = fit.values, fit.noise
        if fit.score - before < ENOUGH:
            break
        before = fit.score
    return engine.fit(values, slots, noise, refresh=True)
