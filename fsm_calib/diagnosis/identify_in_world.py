"""`identify --world`: the base robot and the sensor's place fitted under physics that a world file switches on.

The model is the roll-out that `diagnose` fits (`base.fit_base`), the likelihood is its own; the effects of the world
keep the world's numbers. Gains, axle length, time constants and the tracked point are free, the tyres' slip under its
prior, and the wheels' radii where encoders measured them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from fsm_calib.diagnosis.candidates.beyond_full import beyond_told, likelier_driven
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.fitting.bounds import at_bounds
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.fitting.slot import ALL_RUNS
from fsm_calib.diagnosis.identify.result import Estimate, Identification, unknown
from fsm_calib.diagnosis.intake import take_in
from fsm_calib.diagnosis.proof.heldout import compare
from fsm_calib.diagnosis.replay.prepared import NOMINAL_RADIUS, prepare
from fsm_calib.diagnosis.replay.simulator import Simulator, make_simulator
from fsm_calib.recording.recording import Recording
from fsm_calib.world2d.parameters import parameter_table

SENSOR_SLOTS = {
    "sensor.x": "sensor_offset.x",
    "sensor.y": "sensor_offset.y",
    "sensor.theta": "sensor_yaw.yaw",
}
"""The tracked point on the robot, in the words of the effects that hold it."""
AS_THEY_ARE = (
    "axle_length",
    "tau_forward",
    "tau_turn",
    "slip_speed",
    "wheel_radius_left",
    "wheel_radius_right",
)


def identify_in_world(recordings: Sequence[Recording], world: Mapping[str, float]) -> Identification:
    """Fit the base robot to recordings of one robot in a world with effects.

    Parameters
    ----------
    world : values of the physics beyond the base robot, by full name (``motor_deadband.offset``).

    Raises
    ------
    DataError
        A recording has no poses with headings, too few of them, or no input.
    """
    taken = take_in(recordings)
    simulators, _ = likelier_driven([make_simulator(prepare(r), world) for r in taken.train], ())
    engine = Engine(simulators)
    fit = fit_base(engine, tuple(SENSOR_SLOTS.values()))
    errors = compare(simulators, fit, fit, new=False).after
    residual = {
        "noise_xy_m": fit.noise.position,
        "noise_theta_rad": fit.noise.heading,
        "error_2s_xy_m": errors.xy_m,
        "error_2s_theta_rad": errors.theta_rad,
        "rows": float(engine.count),
    }
    notes = [
        *taken.notes,
        *at_bounds(fit),
        *beyond_told(simulators),
        f"effects of the world, as it states them: {_stated(fit, world)}",
    ]
    findings = tuple(finding for r in recordings for finding in r.checks)
    return Identification(
        recordings[0].robot.name, "the world's own physics", dict(_estimates(simulators, fit)), residual, tuple(notes),
        findings,
    )  # fmt: skip


def _stated(fit: Fit, world: Mapping[str, float]) -> str:
    """Return the effects' numbers that the fit did not move."""
    table, moved = parameter_table(), {slot.place for slot in fit.slots}
    kept = {name: table.place(name) for name in world}
    said = [f"{name} = {world[name]:g}" for name, i in kept.items() if table.owner[i] and i not in moved]
    return ", ".join(said) or "none"


def _estimates(simulators: Sequence[Simulator], fit: Fit) -> Iterator[tuple[str, Estimate]]:
    """Yield the fitted numbers by the names that `identify` gives them."""
    found = _slots(fit)
    yield from _wheels(simulators[0], found)
    for name in AS_THEY_ARE:
        if name in found:
            yield name, found[name]
    for name, slot in SENSOR_SLOTS.items():
        yield name, found[slot]


def _slots(fit: Fit) -> dict[str, Estimate]:
    """Return every shared number of the fit with its deviation, by full name."""
    table = parameter_table()
    found = {}
    for slot, value, variance in fit.numbers():
        if slot.run == ALL_RUNS:
            deviation = math.sqrt(variance) if variance > 0 else None
            found[table.names[slot.place]] = Estimate(value, deviation, table.entries[slot.place].unit)
    return found


def _wheels(simulator: Simulator, found: Mapping[str, Estimate]) -> Iterator[tuple[str, Estimate]]:
    """Yield what both wheels do with their input: gains of commands, or the scale of measured wheel speeds."""
    recording = simulator.prepared.recording
    left, right = found["gain_left"], found["gain_right"]
    radius = recording.robot.wheel_radius or NOMINAL_RADIUS
    measured_rates = simulator.measured_input and recording.wheel_rate is not None
    scale, name, unit = (radius, "wheel_radius", "m") if measured_rates else (1.0, "wheel_gain", "1")
    for side, gain in (("left", left), ("right", right)):
        yield f"{name}_{side}", _times(gain, scale / simulator.full_speed, unit)
        if not simulator.measured_input:
            yield f"speed_at_full_{side}", gain
            if f"wheel_radius_{side}" not in found:
                reason = "only the product of wheel radius and gain can be told: no wheel was measured"
                yield f"wheel_radius_{side}", unknown("m", reason)
    shares = [e.sd / e.value for e in (left, right) if e.sd and e.value]
    ratio = float(left.value or math.nan) / float(right.value or math.nan)
    yield "wheel_ratio", Estimate(ratio, abs(ratio) * math.hypot(*shares) if len(shares) == 2 else None, "1")


def _times(estimate: Estimate, factor: float, unit: str) -> Estimate:
    value, sd = float(estimate.value or 0.0), estimate.sd
    return Estimate(factor * value, None if sd is None else factor * sd, unit)
