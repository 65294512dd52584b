"""Sentences about what the fit found to differ from what the manifest states."""

from __future__ import annotations

from fsm_calib.diagnosis.identify.align import Alignment
from fsm_calib.diagnosis.identify.pose import PoseFit
from fsm_calib.diagnosis.replay.wheels import Wheels
from fsm_calib.recording.recording import Recording

DEVIATIONS = 4.0  # standard deviations by which a stated fact must be off to be called wrong
LONG_DELAY = 0.02  # s: less may be a motor of a higher order
SHARE = 0.02  # and by at least this share of it: nobody states an axle better


def wheel_notes(fit: PoseFit, wheels: Wheels, recording: Recording) -> list[str]:
    """Return what differs: signs and sides of the wheels, axle, scale, clocks, outliers."""
    notes = sign_notes(fit.alignment, fit.has_heading, "wheel channels")
    notes += axle_notes(fit, recording)
    for side in ("left", "right"):
        notes += _fact_note(
            f"{wheels.name} ({side})", wheels.nominal, fit.values[side], fit.sd(side), wheels.scale_unit
        )
    offset, sd = fit.values["clock"], fit.sd("clock")
    if abs(offset) > max(DEVIATIONS * sd, 0.02):
        notes.append(f"the clocks of wheels and poses differ by {offset:+.3f} +- {sd:.3f} s")
    return notes + outlier_notes(fit)


def command_notes(fit: PoseFit, recording: Recording) -> list[str]:
    """Return what differs: signs and sides of the commands, axle, a long delay, outliers."""
    notes = sign_notes(fit.alignment, fit.has_heading, "commands") + delay_notes(fit)
    if "axle" in fit.free:
        notes += axle_notes(fit, recording)
    return notes + outlier_notes(fit)


def sign_notes(start: Alignment, has_heading: bool, what: str) -> list[str]:
    """Return a sentence where signs or sides are not as stated."""
    if start.as_stated:
        return []
    if start.exchanged:
        return [
            f"left and right of the {what} are exchanged: only so does the robot turn as measured "
            "(poses of a map that is mirrored look the same)"
        ]
    if (start.left_sign, start.right_sign) == (-1, -1):
        also = (
            ""
            if has_heading
            else " (or left and right are exchanged: positions alone cannot tell these apart)"
        )
        return [f"the signs of both {what} are reversed: only so does the robot turn as measured{also}"]
    side = "left" if start.left_sign < 0 else "right"
    return [f"the sign of the {side} one of the {what} is reversed: only so does the robot move as measured"]


def axle_notes(fit: PoseFit, recording: Recording) -> list[str]:
    """Return a sentence where the stated axle length is clearly wrong."""
    return _fact_note("axle_length", recording.robot.axle_length, fit.values["axle"], fit.sd("axle"), "m")


def delay_notes(fit: PoseFit) -> list[str]:
    """Return a sentence where the poses move clearly later than commands without delay would have it, or before."""
    delay, sd = fit.values["delay"], fit.sd("delay")
    if abs(delay) < max(DEVIATIONS * sd, LONG_DELAY):
        return []
    cause = (
        "a delay, late poses or two clocks"
        if delay > 0.0
        else "nothing moves before it is told to: two clocks"
    )
    return [f"the poses follow the commands {delay:+.3f} +- {sd:.3f} s beside the time constants: {cause}"]


def outlier_notes(fit: PoseFit) -> list[str]:
    """Return how many poses were set aside."""
    if not fit.outliers:
        return []
    return [f"{fit.outliers} of {fit.rows} poses are outliers and were set aside"]


def _fact_note(name: str, stated: float | None, value: float, sd: float, unit: str) -> list[str]:
    if stated is None or abs(value - stated) < max(DEVIATIONS * sd, SHARE * abs(stated)):
        return []
    unit = "" if unit == "1" else f" {unit}"
    return [
        f"the stated {name} of {stated:.6g}{unit} is wrong by a factor {value / stated:.3f}: "
        f"the data tells {value:.6g} +- {sd:.2g}{unit}"
    ]
