"""Laws of how poses are seen: clocks, delays, the tag's place and the reference markers."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from benchmarks.rapier_robots.laws import Draw, law
from benchmarks.rapier_robots.setup import Array, Poses, Setup


@law(
    "observation_delay",
    "s",
    0.005,
    0.6,
    "stamped on arrival: exposure, transfer and detection go before (camera drivers)",
)
def constant(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Every pose is stamped `size` [s] late."""
    s.clocks.append(lambda run: lambda t: t - size)
    return {"delay_s": size}


@law(
    "observation_delay",
    "s",
    0.005,
    0.6,
    "a fusion filter with weak camera gain: position lags, heading less (complementary filters)",
)
def fused_lag(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Positions pass a low-pass of `size` [s], headings one of 0.4 of it."""

    def make(run: int) -> Callable[[Array, Poses], Poses]:
        def smooth(time: Array, poses: Poses) -> Poses:
            x, y, yaw = (low_pass(time, p, tau) for p, tau in zip(poses, (size, size, 0.4 * size)))
            return x, y, yaw

        return smooth

    s.filters.append(make)
    return {"lag_s": size}


def low_pass(time: Array, values: Array, tau: float) -> Array:
    """Return values through a first-order low-pass (time constant `tau` [s])."""
    share = 1.0 - math.exp(-float(time[1] - time[0]) / tau)
    out = np.empty_like(values)
    now = float(values[0])
    for n, value in enumerate(values.tolist()):
        now += share * (value - now)
        out[n] = now
    return out


@law(
    "observation_delay",
    "s",
    0.01,
    1.2,
    "frames pile up in a queue and are dropped together (image pipelines without stamps)",
)
def piling_frames(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """The delay grows from 0.2 to 1 of `size` [s] over some seconds, then the queue is emptied."""
    period, phase = d.between(0, 2.5, 5.0), d[1]
    s.clocks.append(lambda run: lambda t: t - size * (0.2 + 0.8 * ((t / period + phase) % 1.0)))
    return {"longest_s": size, "period_s": period}


@law(
    "clock_drift",
    "1",
    0.001,
    0.3,
    "RC oscillator of a cheap controller, per cents off (ATmega328P data sheet)",
)
def rate(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """The poses' clock runs at 1 + rate of the commands' clock."""
    size = size * d.sign(0)
    s.clocks.append(lambda run: lambda t: t / (1.0 + size))
    return {"rate": size}


@law("clock_drift", "1", 0.001, 0.4, "a daemon slews a wrong clock back again and again (NTP slewing)")
def slewed_back(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """The clock gains `size` for two thirds of each period and is slewed back twice as fast in the last third."""
    period = d.between(0, 9.0, 18.0)
    rate = size * d.sign(1)

    def true_time(t: Array) -> Array:
        part = (t / period) % 1.0
        error = np.where(part < 2.0 / 3.0, part, 2.0 * (1.0 - part)) * rate * period
        return np.asarray(t - error)

    s.clocks.append(lambda run: true_time)
    return {"slew": rate, "period_s": period}


@law("sensor_offset", "m", 0.002, 0.3, "a bracket screwed to the wrong holes (rigid-body geometry)")
def bracket(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """The tag sits `size` [m] off its place."""
    dx, dy = size * math.cos(d.angle(0)), size * math.sin(d.angle(0))
    s.tags.append(lambda run: lambda t: (np.full_like(t, dx), np.full_like(t, dy), np.zeros_like(t)))
    return {"x_m": dx, "y_m": dy}


@law("sensor_offset", "m", 0.002, 0.3, "a clip that slides along its rail when shaken (friction of clamps)")
def sliding_clip(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """The tag sits 0.6 of `size` [m] off its place and slips to all of it in three jerks."""
    way = d.angle(0)
    jerks = np.array([d.between(n, 0.1, 0.9) for n in (1, 2, 3)]) * d.seconds

    def shift(t: Array) -> Poses:
        share = 0.6 + 0.4 / 3.0 * (np.asarray(t)[:, None] > jerks).sum(axis=1)
        return share * size * math.cos(way), share * size * math.sin(way), np.zeros_like(t)

    s.tags.append(lambda run: shift)
    return {"size_m": size, "way_rad": way}


@law("sensor_yaw", "rad", 0.005, 1.0, "a tag glued on by eye (rigid-body geometry)")
def glued_askew(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """The tag is turned by `size` [rad]."""
    turn = size * d.sign(0)
    s.tags.append(lambda run: lambda t: (np.zeros_like(t), np.zeros_like(t), np.full_like(t, turn)))
    return {"yaw_rad": turn}


@law(
    "sensor_yaw",
    "rad",
    0.005,
    1.0,
    "foam tape creeps under a plate that hangs over (viscoelastic creep, log of time)",
)
def creeping_tape(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """The tag is turned by half of `size` [rad] and creeps on with the logarithm of time."""
    turn = size * d.sign(0)

    def shift(t: Array) -> Poses:
        grown = 0.5 + 0.5 * np.log1p(np.maximum(t, 0.0) / 2.0) / math.log1p(d.seconds / 2.0)
        return np.zeros_like(t), np.zeros_like(t), turn * grown

    s.tags.append(lambda run: shift)
    return {"final_rad": turn}


@law(
    "misplaced_marker",
    "m",
    0.003,
    0.5,
    "a floor marker kicked from its place; poses near it come from it (fiducial maps)",
    local=True,
)
def kicked_marker(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Within a cell poses are off by `size` [m] and turned by a little."""
    (px, py), radius, way = d.spots[1], d.between(0, 0.3, 0.5) * d.area, d.angle(1)
    turn = d.sign(2) * 0.15 * size / radius
    dx, dy = size * math.cos(way), size * math.sin(way)

    def seen(poses: Poses) -> tuple[Poses, Array]:
        x, y, yaw = poses
        near = np.hypot(x - px, y - py) < radius
        c, n = math.cos(turn), math.sin(turn)
        moved_x = px + c * (x - px) - n * (y - py) + dx
        moved_y = py + n * (x - px) + c * (y - py) + dy
        return (np.where(near, moved_x, x), np.where(near, moved_y, y), np.where(near, yaw + turn, yaw)), near

    s.markers.append(lambda run: seen)
    return {"size_m": size, "x_m": px, "y_m": py, "radius_m": radius, "turn_rad": turn}


@law(
    "misplaced_marker",
    "rad",
    0.005,
    1.0,
    "a board laid askew, weighted by nearness (inverse distance of detections)",
    local=True,
)
def twisted_board(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Near a board poses are turned about it by `size` [rad], less with distance."""
    (px, py), reach, turn = d.spots[1], d.between(0, 0.25, 0.4) * d.area, size * d.sign(1)

    def seen(poses: Poses) -> tuple[Poses, Array]:
        x, y, yaw = poses
        q = ((x - px) ** 2 + (y - py) ** 2) / reach**2
        part = turn / (1.0 + q**2)
        c, n = np.cos(part), np.sin(part)
        moved = (px + c * (x - px) - n * (y - py), py + n * (x - px) + c * (y - py), yaw + part)
        return moved, q < 2.0

    s.markers.append(lambda run: seen)
    return {"turn_rad": turn, "x_m": px, "y_m": py, "reach_m": reach}
