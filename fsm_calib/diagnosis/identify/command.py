"""Gains, axle length, time constants and the tracked point from commands and poses.

The base robot of `identify_filter`: each wheel's rim speed settles at gain * command, the robot's forward
speed and turn rate with one time constant each.

    V = (g_r u_r + g_l u_l) / 2        W = (g_r u_r - g_l u_l) / b        (wheel commands)
    V = g_f v                          W = g_t omega                      (twist commands)

g_l, g_r [m/s at command 1, or m for commands in rad/s]; g_f, g_t [1]. The commands are those of one delay ago [s]:
radio and driver take time, stamps are late, clocks differ, and motors of a higher order look so. Without it the gains
take what it does.
"""

from __future__ import annotations

import numpy as np

from fsm_calib.diagnosis.identify.align import align
from fsm_calib.diagnosis.identify.filter import BY_COMMANDS, STEP_COLUMNS
from fsm_calib.diagnosis.identify.pose import Parameter, PoseFit, fit_pose, thinned
from fsm_calib.diagnosis.replay.wheels import Wheels
from fsm_calib.errors import DataError
from fsm_calib.recording.channels import PoseTrack
from fsm_calib.recording.recording import Recording, held_at, held_integral
from fsm_calib.recording.unknown_commands import unknown_spans
from fsm_calib.types import FloatArray

LONGEST_STEP = 0.1  # s: short beside the time constants, so that arcs and noise integrals hold
TYPICAL_SPEED = 0.6  # m/s at command 1 (Duckiebot DB18, duckietown-world pwm_dynamics)
TWIST_AXLE = 0.15  # m, of a robot that is told twists and states no axle
FIRST_TAU = 0.15  # s, first guess of both time constants (DB18: 0.20 and 0.25 s)
TAU_SPREAD = 1.5  # log units, prior of the time constants: 0.03 to 0.7 s is one standard deviation
DELAY_SPREAD = (
    0.3  # s, prior of the delay: dead time of radio and driver, exposure, what is left of two clocks
)
FURTHER_DELAYS = (
    -0.6,
    -0.4,
    -0.2,
    0.2,
    0.4,
    0.6,
    0.8,
)  # s, first guesses: from farther off a search may miss it
COMMAND_NOISE = {"q_f": 0.1, "q_t": 0.8}  # m/s/sqrt(s), rad/s/sqrt(s)


class CommandMotion:
    """Wheel commands moved the robot (see `identify_pose.Motion`); `left`, `right` hold from `time` on.

    unknown : (n, 2) [s] from when until when nobody knows them, beside the time before the first.
    """

    mode = BY_COMMANDS
    noise = COMMAND_NOISE

    def __init__(self, time: FloatArray, left: FloatArray, right: FloatArray, unknown: FloatArray) -> None:
        self.time, self.left, self.right, self.unknown = time, left, right, unknown
        self.parameters = {
            "tau_forward": Parameter(float(np.log(FIRST_TAU)), 0.3, TAU_SPREAD),
            "tau_turn": Parameter(float(np.log(FIRST_TAU)), 0.3, TAU_SPREAD),
            "delay": Parameter(0.0, 0.05, DELAY_SPREAD, FURTHER_DELAYS),
        }

    def with_gains(self, gain: float, axle: float) -> CommandMotion:
        """Start the gains and the axle length here; return itself."""
        self.parameters = {
            "left": Parameter(gain, abs(gain)),
            "right": Parameter(gain, abs(gain)),
            "axle": Parameter(axle, axle),
        } | self.parameters
        return self

    def times(self, pose_times: FloatArray, delay: float) -> FloatArray:
        """Return pose times, changes of command as the poses see them and enough times between."""
        change = np.flatnonzero((np.diff(self.left) != 0.0) | (np.diff(self.right) != 0.0)) + 1
        sent = [self.time[change], self.time[:1], self.unknown[np.isfinite(self.unknown)]]
        events = [pose_times, np.concatenate(sent) + delay]
        first, last = pose_times[0], pose_times[-1]
        times = np.unique(np.concatenate(events))
        times = times[(times >= first) & (times <= last)]
        pieces = np.maximum(np.ceil(np.diff(times) / LONGEST_STEP).astype(int), 1)
        parts = np.arange(int(pieces.sum())) - np.repeat(np.cumsum(pieces) - pieces, pieces)
        inner = np.repeat(times[:-1], pieces) + parts * np.repeat(np.diff(times) / pieces, pieces)
        return np.unique(np.concatenate([inner, pose_times]))

    def steps(self, times: FloatArray, p: dict[str, float]) -> FloatArray:
        """Return duration, asked speed and turn rate, and 1 where nobody knows the command."""
        held = 0.5 * (times[:-1] + times[1:]) - p["delay"]  # no command changes within a step
        left, right = held_at(held, self.time, self.left), held_at(held, self.time, self.right)
        forward, turn = self._asked(left, right, p)
        steps = np.zeros((len(times), STEP_COLUMNS))
        steps[1:, 0], steps[1:, 1], steps[1:, 2] = np.diff(times), forward, turn
        steps[1:, 3] = self._unknown(held)
        return steps

    def constants(self, p: dict[str, float]) -> tuple[float, float]:
        """Return the time constants [s]; the parameters are their logarithms."""
        return float(np.exp(np.clip(p["tau_forward"], -8, 4))), float(np.exp(np.clip(p["tau_turn"], -8, 4)))

    def _asked(
        self, left: FloatArray, right: FloatArray, p: dict[str, float]
    ) -> tuple[FloatArray, FloatArray]:
        s_left, s_right = p["left"] * left, p["right"] * right
        return (s_left + s_right) / 2.0, (s_right - s_left) / p["axle"]

    def _unknown(self, times: FloatArray) -> FloatArray:
        """Return 1 at the times (n,) [s] at which nobody knows the command, else 0."""
        span = np.searchsorted(self.unknown[:, 0], times + 1e-9, side="right") - 1
        ends = np.append(self.unknown[:, 1], -np.inf)[span]  # of none, the last
        return np.asarray((times < self.time[0]) | (times < ends), dtype=float)


class TwistMotion(CommandMotion):
    """Twist commands moved the robot: `left` holds v [m/s], `right` holds omega [rad/s]; gains g_f, g_t near
    1.
    """

    def with_gains(self, gain: float, axle: float) -> TwistMotion:
        """Start both gains here; return itself."""
        self.parameters = {
            "forward_gain": Parameter(gain, abs(gain)),
            "turn_gain": Parameter(gain, abs(gain)),
        } | self.parameters
        return self

    def _asked(
        self, left: FloatArray, right: FloatArray, p: dict[str, float]
    ) -> tuple[FloatArray, FloatArray]:
        return p["forward_gain"] * left, p["turn_gain"] * right


def fit_commands(recording: Recording) -> PoseFit:
    """Fit one recording of commands and poses; raise DataError where it cannot be."""
    pose = thinned(recording.pose)
    facts = recording.robot
    if recording.command is not None:
        track = recording.command
        start = align(asked_travel(recording, pose), pose, facts.axle_length)
        motion = CommandMotion(track.time, *start.sides(track.left, track.right), unknown_spans(track))
        return fit_pose(pose, motion.with_gains(start.scale, start.axle), start)
    if recording.twist is None:
        raise DataError("neither commands nor wheels were recorded")
    twist, axle = recording.twist, facts.axle_length or TWIST_AXLE
    start = align(asked_travel(recording, pose), pose, axle)
    asked = TwistMotion(twist.time, twist.v, twist.omega, unknown_spans(twist))
    return fit_pose(pose, asked.with_gains(1.0, axle), start)


def asked_travel(recording: Recording, pose: PoseTrack) -> Wheels:
    """Return how far the wheels would have gone had they obeyed at once; raise DataError without commands."""
    facts, track, twist = recording.robot, recording.command, recording.twist
    if track is not None:
        speed = (facts.wheel_radius or 0.0) * (facts.max_wheel_rate or 0.0) or TYPICAL_SPEED
        nominal = speed if track.unit == "normalized" else facts.wheel_radius or 0.03
        return _travel(track.time, track.left, track.right, pose, nominal)
    if twist is None:
        raise DataError("neither commands nor wheels were recorded")
    aside = twist.omega * (facts.axle_length or TWIST_AXLE) / 2.0
    return _travel(twist.time, twist.v - aside, twist.v + aside, pose, 1.0)


def _travel(time: FloatArray, left: FloatArray, right: FloatArray, pose: PoseTrack, nominal: float) -> Wheels:
    """Return the integral of held commands as if wheels had followed them at once, for the first guess."""
    end = max(float(pose.time[-1]), float(time[-1]) + 1e-6)
    times, left_travel = held_integral(time, left, end)
    _, right_travel = held_integral(time, right, end)
    return Wheels(times, left_travel, right_travel, "command", "wheel_gain", "m/s", nominal, nominal)
