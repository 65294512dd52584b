"""Find the lane and follow it until the marked section begins (paper, section 5.2)."""

from __future__ import annotations

import math

from fsm_calib.actions.bench import Bench
from fsm_calib.actions.lane_lag import NO_LAG, predict
from fsm_calib.actions.lane_standing import Stretch, why_standing
from fsm_calib.actions.leaving import speed_of
from fsm_calib.actions.looking import FRAME_MISSING, look
from fsm_calib.actions.markers import camera_of, tags_in
from fsm_calib.actions.moving import CLOCKWISE
from fsm_calib.actions.settings import LaneSettings
from fsm_calib.actions.turning import turn_step
from fsm_calib.outcome import Outcome
from fsm_calib.perception.lane import observe_lane
from fsm_calib.types import STOP, Frame, LanePose, TagObservation, WheelCommand

REMEMBERED = 20
"""Commands in the lane that are remembered: more than any lag holds."""


def seek_lane(bench: Bench) -> Outcome:
    """Turn one step clockwise, into right-hand traffic, and look for the lane."""
    step = turn_step(bench, CLOCKWISE, bench.settings.lane.seek_step)
    if isinstance(step, Outcome):
        return step
    turned = {"turned": round(step.turned, 5)}
    pose = _lane_in(bench, step.frame)
    if pose is None or abs(pose.phi) > bench.settings.lane.largest_phi:
        return _missed(turned)
    bench.notebook.lane_integral, bench.notebook.lane_side = 0.0, pose.d
    bench.steered = []
    evidence = {**turned, "d": pose.d, "phi": pose.phi}
    return Outcome(
        "lane_seen", evidence, f"The lane is in sight, {math.degrees(pose.phi):.0f} deg to the robot."
    )


def follow_lane(bench: Bench) -> Outcome:
    """Follow the lane for one stretch; stop when the lane is lost, the reserved marker is near or the robot stands.

    The wheels keep their last command between two stretches. Where no frame comes the robot stops and looks again;
    a stretch without any frame is a loss.
    """
    settings, pose, stretch = bench.settings.lane, None, Stretch(bench.settings)
    for _ in range(settings.looks):
        frame = look(bench)
        if isinstance(frame, Outcome):
            _steer(bench, STOP)
            if frame is not FRAME_MISSING:
                return frame
            stretch = Stretch(bench.settings)
            continue
        first = _first_marker(bench, tags_in(bench, frame))
        if first is not None:
            return _arrive(bench, first)
        pose = _lane_in(bench, frame)
        if pose is None:
            bench.robot.command(STOP)
            bench.robot.wait(bench.settings.drive.settle)
            return _missed({"turned": 0.0})
        stretch.see(frame, bench.notebook.panorama)
        lag = bench.robot.now() - frame.time
        _steer(bench, lane_command(bench, _now_at(bench, pose, frame.time), lag))
        stretch.steer(bench.robot.now())
        bench.robot.wait(settings.period)
    if stretch.stands():
        return why_standing(bench)
    if pose is None:
        return FRAME_MISSING
    return Outcome("lane_followed", {"d": pose.d, "phi": pose.phi}, "One more stretch in the lane.")


def _steer(bench: Bench, command: WheelCommand) -> None:
    """Command the wheels, and remember it for the poses of frames that are on their way."""
    bench.steered = [*bench.steered[-REMEMBERED:], (bench.robot.now(), command)]
    bench.robot.command(command)


def _now_at(bench: Bench, pose: LanePose, seen: float) -> LanePose:
    """Return the pose at which a command given now will act, for a frame that was taken at `seen` [s]."""
    unit = speed_of(bench) / (bench.notebook.drive_command or bench.settings.drive.command)
    return predict(
        pose,
        seen,
        bench.robot.now(),
        bench.steered,
        speed=unit,
        ratio=bench.notebook.wheel_ratio,
        axle=bench.settings.ratio.axle_length,
        answer=bench.settings.lane.motor_answer,
    )


def lane_command(bench: Bench, pose: LanePose, lag: float = 0.0) -> WheelCommand:
    """Return the wheel commands of the lane controller (Duckietown's, proportional-integral in d,
    proportional in phi), for a frame that is `lag` [s] old.

    omega = g (k_d d + k_phi phi + k_integral int d) [rad/s]; the wheels get c (1 -+ omega L / (2 v)), the right
    one times k. The integral begins anew when d changes its sign. g is 1, and less with a lag: see `eased`.
    """
    settings, notebook = bench.settings.lane, bench.notebook
    if pose.d * notebook.lane_side < 0.0:
        notebook.lane_integral = 0.0
    bound = settings.largest_integral
    notebook.lane_integral = min(max(notebook.lane_integral + pose.d * settings.period, -bound), bound)
    notebook.lane_side = pose.d
    omega = settings.k_d * pose.d + settings.k_phi * pose.phi + settings.k_integral * notebook.lane_integral
    omega *= eased(settings, lag)
    omega = min(max(omega, -settings.largest_omega), settings.largest_omega)
    speed = speed_of(bench) * settings.command / (notebook.drive_command or bench.settings.drive.command)
    share = 0.5 * omega * bench.settings.ratio.axle_length / speed
    return WheelCommand(
        settings.command * (1.0 - share), settings.command * (1.0 + share) * notebook.wheel_ratio
    )


def eased(settings: LaneSettings, lag: float) -> float:
    """Return the factor g on the gains for frames that come late by `lag` [s].

    A command holds for T = period + lag; a gain k turns the robot by k T phi meanwhile, and from k T = 2 on each
    command leaves a larger heading than it found, however well the pose is predicted. So g k T <= `lagging_share`.
    """
    if lag <= NO_LAG:
        return 1.0
    return min(1.0, settings.lagging_share / (abs(settings.k_phi) * (settings.period + lag)))


def _lane_in(bench: Bench, frame: Frame) -> LanePose | None:
    return observe_lane(frame.image, camera_of(bench), bench.notebook.mount)


def _first_marker(bench: Bench, tags: tuple[TagObservation, ...]) -> TagObservation | None:
    settings = bench.settings
    for tag in tags:
        if tag.tag_id == settings.marker.lane_first and tag.x <= settings.lane.take_within:
            return tag
    return None


def _arrive(bench: Bench, tag: TagObservation) -> Outcome:
    bench.robot.command(STOP)
    bench.robot.wait(bench.settings.drive.settle)
    bench.notebook.lane_before = bench.notebook.wheel_ratio
    bench.notebook.lane_readings, bench.notebook.lane_runs = [], []
    bench.notebook.marker_map = {}
    evidence = {"marker": tag.tag_id, "distance": round(tag.distance, 3)}
    return Outcome("first_marker_seen", evidence, "The first marker of the marked section is near.")


def _missed(turned: dict[str, float]) -> Outcome:
    cure = "Check the lines of the lane, and that the exit leads into it."
    return Outcome("lane_missed", turned, "The lane is not in sight.", cure)
