"""The situation of every interval of a recording: what a mismatch could depend on, from exogenous quantities alone.

Speeds are simulated, place and heading come from the smoothed path; never a difference of noisy poses, whose noise
would correlate with the residual (measured: clean robots then look ill).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fsm_calib.diagnosis.replay.simulator import GRID_STEP, Simulator
from fsm_calib.types import FloatArray
from fsm_calib.world2d.parameters import parameter_table
from fsm_calib.world2d.rollout import simulate


@dataclass(frozen=True, eq=False)
class Situation:
    """What is known of every interval of one recording, shape (n,) each (left, right: commands [1]).

    v [m/s], omega [rad/s]: simulated; acceleration [m/s2], spin [rad/s2]; x, y [m], heading [rad] of the path;
    time, age [s] since the last command change; jump_v, jump_w: that change as speeds [m/s, rad/s]; travel [m] since
    the last reversal; roll (n, 2) wheel angles [rad]; dt [s]; half axle [m]; radii (2,) of left and right wheel [m].
    """

    time: FloatArray
    dt: FloatArray
    left: FloatArray
    right: FloatArray
    v: FloatArray
    omega: FloatArray
    acceleration: FloatArray
    spin: FloatArray
    x: FloatArray
    y: FloatArray
    heading: FloatArray
    age: FloatArray
    jump_v: FloatArray
    jump_w: FloatArray
    travel: FloatArray
    roll: FloatArray
    half: float
    radii: FloatArray


def situation(simulator: Simulator, values: FloatArray) -> Situation:
    """Return the situation of every interval, speeds simulated with `values` (p,)."""
    p, table = simulator.prepared, parameter_table()
    states = simulate(values, simulator.drive, simulator.grid, p.reference[0], simulator.track, 0.005)
    middle = p.time - 0.5 * p.dt

    def at(column: FloatArray) -> FloatArray:
        return np.interp(middle, simulator.grid, column)

    time, drive = simulator.grid, simulator.drive
    row = np.clip(np.searchsorted(drive.time, middle, side="right") - 1, 0, None)
    before = np.clip(row - 1, 0, None)
    jump_l, jump_r = drive.left[row] - drive.left[before], drive.right[row] - drive.right[before]
    half = float(p.geometry[0])
    age = np.where(middle >= drive.time[0], middle - drive.time[row], 1e3)
    return Situation(
        time=middle, dt=p.dt, left=np.where(age < 1e3, drive.left[row], 0.0),
        right=np.where(age < 1e3, drive.right[row], 0.0), v=at(states[:, 3]), omega=at(states[:, 5]),
        acceleration=at(np.gradient(states[:, 3], GRID_STEP)), spin=at(np.gradient(states[:, 5], GRID_STEP)),
        x=p.reference[:, 0], y=p.reference[:, 1], heading=p.reference[:, 2], age=age,
        jump_v=0.5 * (jump_l + jump_r) * simulator.full_speed,
        jump_w=(jump_r - jump_l) * simulator.full_speed / (2 * half),
        travel=np.interp(middle, time, _travel(states[:, 3])),
        roll=np.column_stack([at(states[:, 6]), at(states[:, 7])]),
        half=half, radii=values[[table.place(f"wheel_radius_{side}") for side in ("left", "right")]],
    )  # fmt: skip


def situations_of(simulators: Sequence[Simulator], values: FloatArray) -> list[Situation]:
    """Return the situations of all recordings, each simulated with its own row of `values` (runs, p)."""
    return [situation(s, v) for s, v in zip(simulators, values, strict=True)]


def last_sign(x: FloatArray, least: float) -> FloatArray:
    """Return the sign that `x` (n,) last had while its size was above `least`; 0 before."""
    sign = np.sign(np.where(np.abs(x) > least, x, 0.0))
    return sign[np.maximum.accumulate(np.where(sign != 0, np.arange(len(x)), 0))]


def _travel(v: FloatArray) -> FloatArray:
    """Return the distance since the direction of motion last changed."""
    held = last_sign(v, 0.02)
    path = np.cumsum(np.abs(v)) * GRID_STEP
    turned = np.flatnonzero(np.diff(held, prepend=held[0]) != 0)
    start = np.zeros(len(v))
    start[turned] = path[turned]
    return path - np.maximum.accumulate(start)
