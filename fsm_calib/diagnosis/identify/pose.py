"""Maximum likelihood of measured poses, given what moved the robot: the part that wheels and commands share.

The innovations of `identify_filter` are made most likely over the parameters of the motion (`Motion`), the
tracked point (px, py) on the base, its heading psi where a heading is measured, the start heading where none
is, and the noise levels. So the standard deviations know the noise of the motion itself (slip, play, bumps),
which makes errors along a path depend on each other.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

import numpy as np

from fsm_calib.diagnosis.identify.align import Alignment
from fsm_calib.diagnosis.identify.filter import DIFFUSE_ANGLE, innovations
from fsm_calib.diagnosis.identify.scoring import Likelihood, Problem, maximise
from fsm_calib.errors import DataError
from fsm_calib.recording.channels import PoseTrack
from fsm_calib.types import FloatArray, wrap_angle

FEWEST_POSES = 30
MOST_POSES = 3000  # longer recordings are thinned: more rows add time, hardly knowledge
NOISE_SPREAD = 3.0  # log units of the prior on noise levels: a factor 20 is one standard deviation
POINT_SPREAD = 0.5  # m, prior of the tracked point: it is on the robot
TRACKER_NOISE = {"r_xy": 0.01, "r_theta": 0.02, "r_time": 0.01, "s_b": 0.003}
"""First guess of the tracker's noise [m, rad, s, m]: tags seen by a camera at 1 m, stamps of a busy computer.
"""


@dataclass(frozen=True, slots=True)
class Parameter:
    """A free parameter: first guess, size (for steps and differences), standard deviation of its prior; other first
    guesses, of which the likeliest is taken.
    """

    first: float
    size: float
    spread: float = np.inf
    others: tuple[float, ...] = ()


class Motion(Protocol):
    """What moved the robot; `noise` maps q_f, q_t to their first guesses."""

    mode: int
    parameters: dict[str, Parameter]
    noise: dict[str, float]

    def times(self, pose_times: FloatArray, delay: float) -> FloatArray:
        """Return the increasing times of the filter's events, among them all pose times; commands act `delay` [s]
        after their stamps.
        """
        ...

    def steps(self, times: FloatArray, p: dict[str, float]) -> FloatArray:
        """Return the filter's steps, shape (m, 6), without the rows of the poses."""
        ...

    def constants(self, p: dict[str, float]) -> tuple[float, float]:
        """Return the two time constants [s]."""
        ...


@dataclass(frozen=True, eq=False)
class PoseFit:
    """Result: values by name, covariance over `free` names, how likely it is, which rows count, the first
    guess.
    """

    values: dict[str, float]
    free: tuple[str, ...]
    covariance: FloatArray
    log_likelihood: float
    outliers: int
    rows: int
    has_heading: bool
    alignment: Alignment

    def sd(self, name: str) -> float:
        """Return the standard deviation of a free parameter; infinite for one that was not free."""
        if name not in self.free:
            return float("inf")
        i = self.free.index(name)
        return float(np.sqrt(self.covariance[i, i]))

    def sd_of_log_ratio(self, a: str, b: str) -> float:
        """Return the standard deviation of log(a / b)."""
        gradient = np.zeros(len(self.free))
        gradient[self.free.index(a)] = 1.0 / self.values[a]
        gradient[self.free.index(b)] = -1.0 / self.values[b]
        return float(np.sqrt(gradient @ self.covariance @ gradient))


def thinned(pose: PoseTrack | None) -> PoseTrack:
    """Return at most MOST_POSES rows; raise DataError for too few or a point that never moved."""
    if pose is None or len(pose) < FEWEST_POSES:
        count = 0 if pose is None else len(pose)
        raise DataError(f"only {count} poses, expected {FEWEST_POSES}", cure="Record longer.")
    if float(np.ptp(pose.x) + np.ptp(pose.y)) <= 0.0:
        raise DataError("the recorded pose never changes", cure="Was the robot seen while it drove?")
    stride = -(-len(pose) // MOST_POSES)
    return pose.rows(slice(None, None, stride))


def fit_pose(pose: PoseTrack, motion: Motion, start: Alignment) -> PoseFit:
    """Fit the motion's parameters to one track of poses, from the first guess `start`."""
    heading = pose.has_heading
    parameters = _parameters(motion, start, heading)
    free = tuple(parameters)
    problem = _problem(pose, motion, parameters, start, heading)
    found = [
        maximise(problem, first, len(pose), spare=free.index("s_b"))
        for first in _firsts(problem, parameters, len(pose))
    ]
    result = max(found, key=lambda likelihood: likelihood.log_likelihood)
    values = _natural(dict(zip(free, map(float, result.parameters), strict=True)), motion)
    return PoseFit(
        values, free, result.covariance, result.log_likelihood, _outliers(result), len(pose), heading, start
    )


def _parameters(motion: Motion, start: Alignment, heading: bool) -> dict[str, Parameter]:
    parameters = dict(motion.parameters)
    parameters["px"] = parameters["py"] = Parameter(0.0, 0.02, POINT_SPREAD)
    if heading:
        parameters["psi"] = Parameter(start.psi, 0.1)
    else:
        parameters["start"] = Parameter(start.heading, 0.1)
    for name in (*TRACKER_NOISE, *motion.noise):
        if heading or name != "r_theta":
            parameters[name] = Parameter(0.0, 1.0, NOISE_SPREAD)
    return parameters


def _firsts(problem: Problem, parameters: dict[str, Parameter], rows: int) -> list[FloatArray]:
    """Return where to begin, each (p,): the declared guess and, where another is likelier, that one, too.

    The likelier guess may lie on the lesser hill: where a robot's commands answer its poses, early ones look likely.
    """
    declared = np.array([parameter.first for parameter in parameters.values()])
    first, all_rows = declared, np.ones(rows, dtype=bool)
    for i, parameter in enumerate(parameters.values()):
        tried = np.tile(first, (1 + len(parameter.others), 1))
        tried[1:, i] = parameter.others
        if parameter.others:
            first = max(tried, key=lambda guess: problem.objective(guess, all_rows))
    return [declared] if (first == declared).all() else [declared, first]


def _problem(
    pose: PoseTrack, motion: Motion, parameters: dict[str, Parameter], start: Alignment, heading: bool
) -> Problem:
    """Return the likelihood as a function of the free parameters."""
    free = list(parameters)
    known = np.isfinite(pose.theta)
    z = np.stack([pose.x, pose.y, np.where(known, pose.theta, 0.0)], axis=1)
    first_heading = float(pose.theta[known][0]) if heading else 0.0

    @lru_cache(maxsize=1)  # most steps of a search leave the delay as it was
    def events(delay: float) -> tuple[FloatArray, FloatArray]:
        times = motion.times(pose.time, delay)
        rows = np.full(len(times), -1.0)
        rows[np.searchsorted(times, pose.time)] = np.arange(len(pose))
        return times, rows

    def run(vector: FloatArray, used: np.ndarray) -> tuple[FloatArray, FloatArray]:
        p = _natural(dict(zip(free, map(float, vector), strict=True)), motion)
        theta0 = (first_heading - p["psi"], DIFFUSE_ANGLE) if heading else (p["start"], 1e-8)
        times, rows = events(p.get("delay", 0.0))
        steps = motion.steps(times, p)
        steps[:, 4] = rows
        observed = np.array([p["px"], p["py"], p["psi"], p["r_xy"] ** 2, p["r_theta"] ** 2, p["r_time"] ** 2])
        dynamics = np.array([*motion.constants(p), p["q_f"] ** 2, p["q_t"] ** 2, p["s_b"]])
        state = np.array([z[0, 0], z[0, 1], *theta0])
        errors, covariances = innovations(motion.mode, steps, z, known, used, state, observed, dynamics)
        return errors, covariances

    return Problem(
        run,
        np.array([parameters[name].size for name in free]),
        np.array([parameters[name].first for name in free]),
        np.array([parameters[name].spread for name in free]),
        np.array([name in TRACKER_NOISE or name in motion.noise for name in free]),
        np.zeros(len(free)),
    )


def _natural(p: dict[str, float], motion: Motion) -> dict[str, float]:
    """Return all values in natural units: noise levels are fitted as logarithms of their ratio to the first
    guess.
    """
    natural = {"psi": 0.0, "start": 0.0} | p
    for name, level in (TRACKER_NOISE | motion.noise).items():
        natural[name] = float(level * np.exp(np.clip(p.get(name, 0.0), -12.0, 12.0)))
    natural["psi"], natural["start"] = wrap_angle(natural["psi"]), wrap_angle(natural["start"])
    return natural


def _outliers(result: Likelihood) -> int:
    return int((~result.used).sum())
