"""The fast roll-out: drive the robot of a parameter vector with recorded commands and say what would be
measured.

The same compiled step as the pymunk body's (`body`), without contacts. Everything here is a function of
arrays; nothing is kept between calls but the compiled program (`kernel`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fsm_calib.errors import InputError
from fsm_calib.types import FloatArray, read_only
from fsm_calib.world2d.effects import per_catalogue, registry
from fsm_calib.world2d.effects.vocabulary import STEPPED
from fsm_calib.world2d.kernel import flag_places, kernel, memory_places
from fsm_calib.world2d.loop import OUTPUTS
from fsm_calib.world2d.parameters import parameter_table
from fsm_calib.world2d.path import Path
from fsm_calib.world2d.slots import BENCH_SIZE, MEMORY

Flags = NDArray[np.bool_]
"""Which effects a vector of parameters, or each row of a matrix, switches on (`active_flags`)."""
COLUMNS = (
    *("x", "y", "theta", "v", "v_lateral", "omega", "wheel_angle_left", "wheel_angle_right"),
    *("rim_speed_left", "rim_speed_right", "time", "is_moving"),
)
"""Columns of a result [m, m, rad, m/s, m/s, rad/s, rad, rad, m/s, m/s, s, 0 or 1]; theta is not wrapped."""
FIT_STEP = 0.005
"""Longest step of a roll-out [s]: `benchmarks/rollout.py` prints its error, a hundredth of a tag pose's
noise."""
WORLD_STEP = 0.002
"""Longest step of a simulated world [s]."""


@dataclass(frozen=True, eq=False)
class Drive:
    """Held commands: `left[j]`, `right[j]` [1, full command] act from `time[j]` [s] until the next; zero
    before the first.

    Arrays of shape (n,), times strictly increasing, at least one row. Rates in rad/s are divided by the
    maximum first.
    """

    time: FloatArray
    left: FloatArray
    right: FloatArray

    def __post_init__(self) -> None:
        """Copy, freeze and check."""
        for name in ("time", "left", "right"):
            object.__setattr__(self, name, read_only(getattr(self, name)).ravel())
        if not self.time.size or not self.time.size == self.left.size == self.right.size:
            raise InputError(
                f"{self.time.size} times, {self.left.size} left and {self.right.size} right commands",
                cure="Give one left and one right command for each time, at least one.",
            )
        if np.any(np.diff(self.time) <= 0.0):
            row = int(np.argmax(np.diff(self.time) <= 0.0)) + 1
            raise InputError(
                f"the command times do not increase at row {row}", cure="Sort them and drop repeats."
            )
        for name in ("time", "left", "right"):
            if not np.all(np.isfinite(getattr(self, name))):
                raise InputError(f"a drive's {name} is not finite", cure="Drop those rows.")

    def padded(self, begin: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the arrays with a row of zeros in front, so that they start before `begin` [s]."""
        early = min(begin, self.time[0]) - 10.0
        rows = np.empty((3, len(self.time) + 1))
        rows[:, 0] = early, 0.0, 0.0
        rows[0, 1:], rows[1, 1:], rows[2, 1:] = self.time, self.left, self.right
        return rows[0], rows[1], rows[2]


@per_catalogue
def _strengths() -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return places and null values of all parameters that switch an effect on, and whose each is, (s, effects)."""
    table = parameter_table()
    flag = flag_places()
    rows = [
        (i, e.null, flag[o])
        for i, (e, o) in enumerate(zip(table.entries, table.owner, strict=True))
        if o and e.strength
    ]
    places, nulls, flags = zip(*rows, strict=True)
    whose = np.zeros((len(flags), len(flag)))
    whose[np.arange(len(flags)), flags] = 1.0
    return np.array(places), np.array(nulls), whose


@per_catalogue
def _readers() -> tuple[Flags, Flags]:
    """Return two flags an effect: whether its steps read place, heading or roll, and whether it reads the roll."""
    step = [effect.reads if set(STEPPED) & set(effect.hooks) else () for effect in registry().values()]
    return np.array([bool(reads) for reads in step]), np.array(["wheel_angle" in reads for reads in step])


def active_flags(parameters: FloatArray) -> Flags:
    """Return which effects a vector (or each row of a matrix) switches on, shape (..., effects), bool."""
    places, nulls, whose = _strengths()
    differs = np.asarray(parameters)[..., places] != nulls
    on: Flags = differs.astype(float) @ whose > 0.0
    return on


def _start(x0: Sequence[float] | FloatArray) -> FloatArray:
    """Return pose and twist, shape (6,), from a pose (3) or a pose with a twist (6)."""
    start = np.zeros(6)
    x0 = np.asarray(x0, dtype=float).ravel()
    if x0.size not in (3, 6) or not np.all(np.isfinite(x0)):
        raise InputError(
            f"the start has {x0.size} numbers, expected a finite x, y, theta and perhaps v, v_lateral, omega"
        )
    start[: x0.size] = x0
    return start


def working_arrays(levels: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the arrays that a roll-out works in: state, workbench, and room for the levels of a drive of that many."""
    return np.zeros(MEMORY + memory_places()[1]), np.zeros(BENCH_SIZE), np.zeros((4, levels))


def simulate(
    parameters: FloatArray,
    drive: Drive,
    t_grid: FloatArray,
    x0: Sequence[float] | FloatArray,
    pose_track: FloatArray | Path | None = None,
    dt: float = FIT_STEP,
) -> FloatArray:
    """Return the robot's states at the sample times `t_grid` [s], shape (n, 12), columns `COLUMNS`.

    Parameters
    ----------
    parameters : array, shape (p,)
        See `parameters`; not checked against bounds (a fit may step over one for a moment).
    drive : Drive
        Commands on the robot's clock.
    t_grid : array, shape (n,)
        Strictly increasing.
    x0 : sequence
        Pose at `t_grid[0]`, at rest; or pose and twist (v, v_lateral, omega).
    pose_track : array or Path, optional
        A `Path`, or its track: stands in for the simulated pose where an effect asks for place, heading or wheel
        phase.
    dt : float
        Longest step [s]; the effective one divides each interval.
    """
    return simulate_many(np.asarray(parameters, dtype=float)[None], drive, t_grid, x0, pose_track, dt)[0]


def simulate_many(
    parameters: FloatArray,
    drive: Drive,
    t_grid: FloatArray,
    x0: Sequence[float] | FloatArray,
    pose_track: FloatArray | Path | None = None,
    dt: float = FIT_STEP,
    on: Flags | None = None,
) -> FloatArray:
    """Return the states of every row of `parameters`, shape (k, p), as `simulate` does; result of shape (k,
    n, 12). A `Path` has the same sample times; `on` are the rows' `active_flags`, where they are known.
    """
    matrix = np.ascontiguousarray(parameters, dtype=float)
    samples = np.ascontiguousarray(t_grid, dtype=float)
    if samples.size == 0 or not np.all(np.diff(samples) > 0.0) or not np.all(np.isfinite(samples)):
        raise InputError("the sample times do not increase", cure="Sort them and drop repeats.")
    if not dt > 0.0:
        raise InputError(f"the step is {dt} s, expected a positive number")
    on = active_flags(matrix) if on is None else on
    looking, rolling = _readers()
    needs = (on & looking).any(axis=1)
    track = np.zeros((0, 5))
    if pose_track is not None and needs.any():  # most drives never look at it
        path = pose_track if isinstance(pose_track, Path) else Path.of(pose_track, samples)
        track = path.at(matrix[0], bool((on & rolling).any()))
    looks = np.where(needs, 2 if len(track) else 1, 0)
    starts = np.tile(_start(x0), (len(matrix), 1))
    out = np.empty((len(matrix), samples.size, OUTPUTS))
    times, left, right = drive.padded(samples[0])
    kernel(bare=not on.any()).run_many(
        matrix, on, *working_arrays(times.size), looks, times, left, right, samples, starts, track, dt, out
    )
    return out
