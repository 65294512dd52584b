"""Cameras, clocks, filters and tags."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from benchmarks.ode_robots.laws import law
from benchmarks.ode_robots.setup import Clock, Marker, Setup, Smooth, Tag
from benchmarks.robot_sets.driving import Array, Poses
from benchmarks.robot_sets.laws import Draw


@law(
    "clock_drift",
    "share",
    0.0008,
    0.15,
    "a crystal that warms after switching on: its rate creeps to its end",
)
def warming_crystal(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """The poses' clock runs at a rate that begins at 0.4 of its end and nears it within 15 to 40 s."""
    rate, warms = size * draw.sign(0), draw.between(1, 15.0, 40.0)

    def make(run: int) -> Clock:
        return lambda t: t + rate * (t - 0.6 * warms * (1.0 - np.exp(-t / warms)))

    setup.clocks.append(make)
    return {"rate": rate, "warms_s": warms}


@law(
    "clock_drift", "share", 0.001, 0.3, "a clock that is set right from time to time and runs off in between"
)
def set_right_again(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """The clock runs off at a rate and is slewed back at three times it, in turns of 18 to 30 s."""
    rate, period = size * draw.sign(0), draw.between(1, 18.0, 30.0)

    def make(run: int) -> Clock:
        def clock(t: Array) -> Array:
            at = (t + 5.0 * run) % period
            return np.asarray(t + rate * np.where(at < 0.75 * period, at, 3.0 * (period - at)))

        return clock

    setup.clocks.append(make)
    return {"rate": rate, "period_s": period}


@law(
    "clock_drift",
    "share",
    0.001,
    0.15,
    "stamps counted from frames at the nominal rate while frames are lost",
)
def counted_frames(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Stamps fall behind by a frame for every frame lost; losses come in bursts of busy seconds."""

    def make(run: int) -> Clock:
        rng = np.random.default_rng([draw.seed, run])
        grid = np.arange(0.0, 121.0)
        busy = rng.gamma(0.8, 1.25, len(grid))
        lost = np.concatenate([[0.0], np.cumsum(size * busy)])[: len(grid)]
        return lambda t: t + np.interp(t, grid, lost)

    setup.clocks.append(make)
    return {"mean_rate": size}


@law(
    "observation_delay",
    "s",
    0.01,
    1.2,
    "image pipelines: exposure, transfer, detection, each frame a little otherwise",
)
def uneven_pipeline(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Poses are late by size, a quarter of it varying from frame to frame."""

    def make(run: int) -> Clock:
        noise = np.random.default_rng([draw.seed, run]).uniform(-0.25, 0.25, 8192)

        def clock(t: Array) -> Array:
            frame = (np.asarray(t) * setup.sensing.rate).astype(int)
            return np.asarray(t - size * (1.0 + noise[frame % len(noise)]))

        return clock

    setup.clocks.append(make)
    return {"mean_s": size, "spread_s": 0.25 * size}


@law("observation_delay", "s", 0.01, 1.2, "a host that is busy in waves stamps poses when it gets to them")
def busy_in_waves(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Poses are late by a time that swells and ebbs within 6 to 14 s."""
    period, phase = draw.between(0, 6.0, 14.0), draw.between(1, 0.0, 6.28)

    def make(run: int) -> Clock:
        return lambda t: t - size * (1.0 + 0.35 * np.sin(2.0 * math.pi * t / period + phase + run))

    setup.clocks.append(make)
    return {"mean_s": size, "wave": 0.35, "period_s": period}


@law("observation_delay", "s", 0.01, 1.0, "smoothing filters for poses, position slower than heading")
def smoothing_filter(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Positions pass two lags of half the size in a row, the heading one of 0.6."""

    def lagged(values: Array, step: float, lag: float) -> Array:
        keep = math.exp(-step / lag)
        out, state = np.empty_like(values), float(values[0])
        for k, value in enumerate(values.tolist()):
            state = keep * state + (1.0 - keep) * value
            out[k] = state
        return out

    def make(run: int) -> Smooth:
        def smooth(time: Array, poses: Poses) -> Poses:
            step = float(time[1] - time[0])
            x, y = (lagged(lagged(p, step, 0.5 * size), step, 0.5 * size) for p in poses[:2])
            return x, y, lagged(poses[2], step, 0.6 * size)

        return smooth

    setup.filters.append(make)
    return {"position_s": size, "heading_s": 0.6 * size}


@law(
    "misplaced_marker", "m", 0.002, 0.5, "a wall marker surveyed wrongly: poses near it follow it", local=True
)
def surveyed_wrongly(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Near two places poses are turned and shifted, with a weight that falls with distance."""
    way, reach = draw.between(0, -math.pi, math.pi), 0.3 * draw.area
    turn = 1.2 * size / draw.area * draw.sign(1)

    def make(run: int) -> Marker:
        def marker(poses: Poses) -> tuple[Poses, NDArray[np.bool_]]:
            x, y, yaw = poses
            d2 = np.minimum.reduce([(x - a) ** 2 + (y - b) ** 2 for a, b in draw.spots])
            w = np.exp(-((d2 / reach**2) ** 1.5))
            near = np.asarray(w > 0.3)
            return (x + w * size * math.cos(way), y + w * size * math.sin(way), yaw + w * turn), near

        return marker

    setup.markers.append(make)
    return {"shift_m": size, "turn_rad": turn, "reach_m": reach}


@law(
    "misplaced_marker",
    "m",
    0.002,
    0.5,
    "a board hung askew that counts only when the robot looks its way",
    local=True,
)
def seen_from_one_side(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """Within a place, and only while the robot heads for the half where the board hangs, poses jump off."""
    way, face, reach = (
        draw.between(0, -math.pi, math.pi),
        draw.between(1, -math.pi, math.pi),
        0.45 * draw.area,
    )

    def make(run: int) -> Marker:
        def marker(poses: Poses) -> tuple[Poses, NDArray[np.bool_]]:
            x, y, yaw = poses
            d = np.minimum.reduce([np.hypot(x - a, y - b) for a, b in draw.spots])
            near = np.asarray((d < reach) & (np.cos(yaw - face) > -0.2))
            w = near.astype(float)
            turn = 0.6 * size / draw.area
            return (x + w * size * math.cos(way), y + w * size * math.sin(way), yaw + w * turn), near

        return marker

    setup.markers.append(make)
    return {"shift_m": size, "face_rad": face, "reach_m": reach}


@law(
    "sensor_offset",
    "m",
    0.001,
    0.4,
    "a tag on a mast: off its place, and the mast leans as the robot speeds up",
)
def leaning_mast(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """A constant offset, and a tenth of it for each 0.5 m/s2 against the acceleration."""
    way = draw.between(0, -math.pi, math.pi)

    def sway(run: int) -> Smooth:
        def smooth(time: Array, poses: Poses) -> Poses:
            x, y, yaw = poses
            step = float(time[1] - time[0])
            window = np.hanning(23) / np.hanning(23).sum()
            ax, ay = (
                np.convolve(np.gradient(np.gradient(p, step), step), window, mode="same") for p in (x, y)
            )
            most = 0.3 * size
            lean_x, lean_y = (most * np.tanh(0.2 * size * a / most) for a in (ax, ay))
            return x - lean_x, y - lean_y, yaw

        return smooth

    def make(run: int) -> Tag:
        return lambda t: (size * math.cos(way), size * math.sin(way), 0.0)

    setup.filters.append(sway)
    setup.tags.append(make)
    return {"x": size * math.cos(way), "y": size * math.sin(way), "lean_s2": 0.2 * size}


@law("sensor_offset", "m", 0.001, 0.4, "a tag on foam tape, stuck off its place, creeps on as the tape gives")
def creeping_tape(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """The offset grows from 0.65 to its end within a run, bending its way a little."""
    way, lasts = draw.between(0, -math.pi, math.pi), draw.between(1, 15.0, 40.0)

    def make(run: int) -> Tag:
        def tag(t: Array) -> tuple[Array, Array, float]:
            gone = 1.0 - 0.35 * np.exp(-t / lasts)
            return size * gone * np.cos(way + 0.3 * gone), size * gone * np.sin(way + 0.3 * gone), 0.0

        return tag

    setup.tags.append(make)
    return {"end_m": size, "way_rad": way, "lasts_s": lasts}


@law("sensor_yaw", "rad", 0.004, 0.8, "a tag on one bolt: askew, and it twists within its play in turns")
def one_bolt(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """The tag is askew, and a fifth more or less while the robot turns one way or the other."""
    askew = size * draw.sign(0)

    def make(run: int) -> Smooth:
        def smooth(time: Array, poses: Poses) -> Poses:
            x, y, yaw = poses
            rate = np.convolve(np.gradient(yaw, time), np.ones(15) / 15.0, mode="same")
            return x, y, yaw + askew * (1.0 - 0.2 * np.tanh(rate / 0.4))

        return smooth

    setup.filters.append(make)
    return {"yaw_rad": askew, "twists": 0.2}


@law("sensor_yaw", "rad", 0.004, 0.8, "planar pose from one view: a heading bias that turns with the view")
def bias_with_view(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    """The tag is askew, and the camera sees it a quarter more so from one side than from the other."""
    askew, view = size * draw.sign(0), draw.between(1, -math.pi, math.pi)

    def make(run: int) -> Smooth:
        def smooth(time: Array, poses: Poses) -> Poses:
            x, y, yaw = poses
            return x, y, yaw + askew * (1.0 + 0.25 * np.cos(yaw - view))

        return smooth

    setup.filters.append(make)
    return {"yaw_rad": askew, "view_rad": view}
