"""`identify`: the base robot from recordings, whichever channels they hold.

What moved the robot is read from the wheels if they were measured, else from the commands; what it did is
read from displacements, else poses, else the yaw rate. What the channels at hand cannot tell stays unknown,
with the reason.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from fsm_calib.diagnosis.identify.align import open_loop_error
from fsm_calib.diagnosis.identify.command import fit_commands
from fsm_calib.diagnosis.identify.displacement import identify_from_displacement
from fsm_calib.diagnosis.identify.explained import refuse_slow, refuse_unexplained
from fsm_calib.diagnosis.identify.notes import command_notes, wheel_notes
from fsm_calib.diagnosis.identify.pose import PoseFit, thinned
from fsm_calib.diagnosis.identify.result import Estimate, Identification, combined, unknown
from fsm_calib.diagnosis.identify.wheel_motion import fit_wheels
from fsm_calib.diagnosis.identify.yaw import identify_from_yaw_rate
from fsm_calib.diagnosis.replay.wheels import Wheels
from fsm_calib.errors import DataError
from fsm_calib.recording.recording import Recording, RobotFacts

UNTOLD_POINT = 0.2  # m: a tracked point with a larger standard deviation is not told (it is on the robot)
UNTOLD_ANGLE = 0.5  # rad, likewise its heading
UNTOLD_SHARE = (
    0.3  # of its value: a length, gain or time constant with a larger standard deviation is not told
)
UNTOLD_DELAY = 0.1  # s: a delay with a larger standard deviation is not told
NO_SLIP = (
    3e-4  # of a gain: so much do tyres that drift in arcs, which the filter leaves out, take (TurtleBot3)
)
NO_TURNS = "the motion does not tell it: drive arcs to both sides as well as straight"
SELDOM = "the commands change too seldom to tell it"


def identify(recordings: Sequence[Recording]) -> Identification:
    """Fit the base robot to recordings of one robot.

    Raises
    ------
    DataError
        The recordings hold nothing that tells (no motion, too few rows, no matching channels); with the cure.
    """
    if not recordings:
        raise DataError("no recording was given")
    try:
        return _identified(list(recordings))
    except (np.linalg.LinAlgError, ArithmeticError) as error:
        cure = "Check units and columns of the recording, and the facts about its robot."
        raise DataError(f"the numbers of {recordings[0].source} have no fit ({error})", cure=cure) from error


def _identified(recordings: list[Recording]) -> Identification:
    """Fit by the method that the channels allow."""
    first = recordings[0]
    wheels = any(track is not None for track in (first.wheel_angle, first.wheel_rate, first.wheel_speed))
    commands = first.command is not None or first.twist is not None
    if wheels and first.displacement is not None:
        return identify_from_displacement(recordings)
    if first.pose is not None and (wheels or commands):
        return combined([_from_pose(recording, wheels, commands) for recording in recordings])
    if wheels and first.yaw_rate is not None:
        return identify_from_yaw_rate(recordings)
    raise DataError(
        f"{first.source or first.robot.name}: the channels {', '.join(first.channels) or 'none'} do not tell the robot",
        cure="Record commands or wheels, and poses, displacements or a yaw rate.",
    )


def _from_pose(recording: Recording, wheels: bool, commands: bool) -> Identification:
    """Identify one recording with poses: lengths from the wheels if measured, gains from the commands if
    logged.
    """
    estimates: dict[str, Estimate] = {}
    residual: dict[str, float] = {}
    notes: list[str] = []
    radius = recording.robot.wheel_radius
    if wheels:
        fit, read_as, reading_notes = fit_wheels(recording)
        estimates |= _wheel_estimates(fit, read_as) | _point_estimates(fit)
        residual |= _residual(fit) | {
            "xy_m": open_loop_error(fit.alignment.applied(read_as), thinned(recording.pose), fit.values)
        }
        notes += [*reading_notes, *wheel_notes(fit, read_as, recording)]
        if read_as.name == "wheel_radius":
            radius = abs(fit.values["left"] + fit.values["right"]) / 2.0
    if commands:
        refuse_unexplained(recording)
        fit = fit_commands(recording)
        refuse_slow(recording, math.exp(fit.values["tau_forward"]), math.exp(fit.values["tau_turn"]))
        found = _command_estimates(fit, recording, radius)
        estimates = found | _point_estimates(fit) | estimates
        residual = _residual(fit) | residual
        notes += command_notes(fit, recording)
    method = " and ".join(word for word, there in (("wheels", wheels), ("commands", commands)) if there)
    return Identification(
        recording.robot.name, f"{method} with poses", estimates, residual, tuple(notes), recording.checks
    )


def told(fit: PoseFit, name: str, unit: str, factor: float = 1.0, left_out: float = 0.0) -> Estimate:
    """Return a free parameter times `factor` as an estimate; unknown where its deviation is a large share of it.

    left_out : share of the value by which physics that the filter leaves out moves it; counts as deviation.
    """
    value, sd = factor * fit.values[name], abs(factor) * math.hypot(fit.sd(name), left_out * fit.values[name])
    if not (math.isfinite(sd) and sd < UNTOLD_SHARE * abs(value)):
        return unknown(unit, NO_TURNS)
    return Estimate(value, sd, unit)


def _wheel_estimates(fit: PoseFit, wheels: Wheels) -> dict[str, Estimate]:
    start = fit.alignment
    estimates = {
        f"{wheels.name}_left": told(fit, "left", wheels.scale_unit, start.left_sign),
        f"{wheels.name}_right": told(fit, "right", wheels.scale_unit, start.right_sign),
        "axle_length": told(fit, "axle", "m"),
        "clock_offset": Estimate(fit.values["clock"], fit.sd("clock"), "s"),
    }
    if wheels.name != "wheel_radius":
        kind = (
            "ticks per turn are not known" if wheels.unit == "tick" else "rim speeds were recorded, not rates"
        )
        reason = f"{kind}: only {wheels.name} can be told"
        estimates |= {f"wheel_radius_{side}": unknown("m", reason) for side in ("left", "right")}
    return estimates


def _point_estimates(fit: PoseFit) -> dict[str, Estimate]:
    """Return the tracked point as the sensor's pose on the robot."""
    estimates = {}
    for key in ("x", "y"):
        value, sd = fit.values[f"p{key}"], fit.sd(f"p{key}")
        estimates[f"sensor.{key}"] = Estimate(value, sd, "m") if sd < UNTOLD_POINT else unknown("m", NO_TURNS)
    if fit.has_heading and fit.sd("psi") < UNTOLD_ANGLE:
        estimates["sensor.theta"] = Estimate(fit.values["psi"], fit.sd("psi"), "rad")
    else:
        reason = NO_TURNS if fit.has_heading else "no heading was measured"
        estimates["sensor.theta"] = unknown("rad", reason)
    return estimates


def _command_estimates(fit: PoseFit, recording: Recording, radius: float | None) -> dict[str, Estimate]:
    """Return gains, axle and time constants; gains relative to the stated motors where these are known."""
    estimates: dict[str, Estimate] = {}
    for side in ("left", "right"):
        estimates[f"wheel_radius_{side}"] = unknown(
            "m", "only the product of wheel radius and gain can be told: no wheel was measured"
        )
    if recording.twist is not None:
        estimates["forward_gain"] = told(fit, "forward_gain", "1", left_out=NO_SLIP)
        estimates["turn_gain"] = told(fit, "turn_gain", "1", left_out=NO_SLIP)
        estimates["axle_length"] = unknown(
            "m", "the commands are speeds of the robot: the axle enters nowhere"
        )
    else:
        estimates |= _gains(fit, recording.robot, radius, recording.command.unit)  # type: ignore[union-attr]
        estimates["axle_length"] = told(fit, "axle", "m")
    for name in ("tau_forward", "tau_turn"):
        value, sd = math.exp(fit.values[name]), fit.sd(name)
        known = Estimate(value, value * sd, "s")
        estimates[name] = known if sd < 1.0 else unknown("s", SELDOM)
    delay, sd = fit.values["delay"], fit.sd("delay")
    estimates["command_delay"] = Estimate(delay, sd, "s") if sd < UNTOLD_DELAY else unknown("s", SELDOM)
    return estimates


def _gains(fit: PoseFit, facts: RobotFacts, radius: float | None, unit: str) -> dict[str, Estimate]:
    signs = {"left": fit.alignment.left_sign, "right": fit.alignment.right_sign}
    estimates = {}
    for side, sign in signs.items():
        if unit == "rad/s":
            estimates[f"wheel_gain_{side}"] = told(
                fit, side, "m" if radius is None else "1", sign / (radius or 1.0), NO_SLIP
            )
            continue
        full = (radius or 0.0) * (facts.max_wheel_rate or 0.0)
        estimates[f"wheel_gain_{side}"] = told(
            fit, side, "1" if full else "m/s", sign / (full or 1.0), NO_SLIP
        )
        estimates[f"speed_at_full_{side}"] = told(fit, side, "m/s", sign, NO_SLIP)
    ratio = fit.values["left"] / fit.values["right"]
    estimates["wheel_ratio"] = Estimate(ratio, ratio * fit.sd_of_log_ratio("left", "right"), "1")
    return estimates


def _residual(fit: PoseFit) -> dict[str, float]:
    """Return noise levels as fitted: white and slowly changing errors of the tracker."""
    residual = {
        "noise_xy_m": fit.values["r_xy"],
        "tracker_bias_m": fit.values["s_b"],
        "stamp_jitter_s": fit.values["r_time"],
    }
    if fit.has_heading:
        residual["noise_theta_rad"] = fit.values["r_theta"]
    return residual | {"rows": float(fit.rows), "outliers": float(fit.outliers)}
