"""Laws of what is seen: clocks, delays of poses, markers of the map, and where the tag sits."""

from __future__ import annotations

import math

import numpy as np

from benchmarks.box2d_robots.laws import law
from benchmarks.box2d_robots.parts import Clock, Marker, Setup, Smooth, Tag
from benchmarks.robot_sets.driving import Array, Poses
from benchmarks.robot_sets.laws import Draw


@law(
    "clock_drift",
    "wrong_crystal",
    (0.0005, 0.3),
    "1",
    "the camera's clock runs at a wrong rate (RC oscillators)",
)
def wrong_crystal(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    rate = draw.sign(0) * size

    def make(run: int) -> Clock:
        return lambda time: time / (1.0 + rate)

    setup.clocks.append(make)
    return {"rate": rate}


@law(
    "clock_drift",
    "warming_oscillator",
    (0.001, 0.4),
    "1",
    "an oscillator that warms after switching on: its rate settles with a lag (ceramic resonators)",
)
def warming_oscillator(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    rate, lag = draw.sign(0) * size, draw.between(1, 12.0, 35.0)

    def make(run: int) -> Clock:
        return lambda time: time - rate * (time - 0.8 * lag * (1.0 - np.exp(-time / lag)))

    setup.clocks.append(make)
    return {"final_rate": rate, "lag_s": lag}


@law(
    "clock_drift",
    "slewed_clock",
    (0.0005, 0.3),
    "1",
    "a time service pulls a clock that is off in slews: fast for a while, then a little less (adjtime)",
)
def slewed_clock(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    rate, period = draw.sign(0) * size, draw.between(1, 9.0, 18.0)

    def make(run: int) -> Clock:
        def clock(time: Array) -> Array:
            wave = 0.5 * period / (2.0 * math.pi) * (1.0 - np.cos(2.0 * math.pi * time / period))
            return np.asarray(time - rate * (time + wave))

        return clock

    setup.clocks.append(make)
    return {"mean_rate": rate, "period_s": period}


@law(
    "observation_delay",
    "stamped_at_the_desk",
    (0.003, 0.8),
    "s",
    "frames are stamped when they arrive, not when they were taken; or corrected by too much, which is early",
)
def stamped_at_the_desk(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    delay = size if draw.numbers[0] < 0.75 else -size

    def make(run: int) -> Clock:
        return lambda time: time - delay

    setup.clocks.append(make)
    return {"delay_s": delay}


@law(
    "observation_delay",
    "filling_pipeline",
    (0.003, 0.8),
    "s",
    "the decoder's queue is longer when the processor is busy: late by one frame more for spells of seconds",
)
def filling_pipeline(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    def make(run: int) -> Clock:
        rng = np.random.default_rng([draw.seed, run])
        edges = np.cumsum(rng.uniform(2.0, 6.0, 60))
        busy = rng.uniform(0.0, 0.5, 61)

        def clock(time: Array) -> Array:
            more = np.interp(time, edges, busy[:-1])
            return np.asarray(time - size * (0.75 + more))

        return clock

    setup.clocks.append(make)
    return {"mean_delay_s": size}


@law(
    "misplaced_marker",
    "turned_marker",
    (0.003, 0.8),
    "rad",
    "a floor marker was glued back askew: near it poses are turned about it and a little shifted",
    local=True,
)
def turned_marker(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    turn, at = draw.sign(1) * size, draw.between(2, -math.pi, math.pi)
    (x0, y0), reach = draw.spots[0], draw.between(0, 0.3, 0.45) * draw.area
    away = 0.1 * size
    c, s = math.cos(turn), math.sin(turn)

    def make(run: int) -> Marker:
        def marker(poses: Poses) -> tuple[Poses, Array]:
            x, y = poses[0] - x0, poses[1] - y0
            near = np.hypot(x, y) < reach
            turned = (x0 + c * x - s * y + away * math.cos(at), y0 + s * x + c * y + away * math.sin(at))
            moved = (turned[0], turned[1], poses[2] + turn)
            x, y, yaw = (np.where(near, a, b) for a, b in zip(moved, poses))
            return (x, y, yaw), near

        return marker

    setup.markers.append(make)
    return {"turn_rad": turn, "x_m": draw.spots[0][0], "y_m": draw.spots[0][1], "shift_m": away}


@law(
    "misplaced_marker",
    "typo_in_the_map",
    (0.002, 0.6),
    "m",
    "one marker's coordinates are wrong in the map: where it is the nearest one, poses are shifted",
    local=True,
)
def typo_in_the_map(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    at = draw.between(2, -math.pi, math.pi)
    (x0, y0), reach = draw.spots[0], draw.between(0, 0.3, 0.45) * draw.area

    def make(run: int) -> Marker:
        def marker(poses: Poses) -> tuple[Poses, Array]:
            ahead = np.maximum(abs(poses[0] - x0), abs(poses[1] - y0)) < reach  # its cell of a square grid
            x = poses[0] + np.where(ahead, size * math.cos(at), 0.0)
            y = poses[1] + np.where(ahead, size * math.sin(at), 0.0)
            return (x, y, poses[2]), ahead

        return marker

    setup.markers.append(make)
    return {"shift_m": size, "direction_rad": at, "x_m": draw.spots[0][0], "y_m": draw.spots[0][1]}


@law("sensor_offset", "tag_on_the_deck", (0.001, 0.6), "m", "the tag is glued away from the axle's middle")
def tag_on_the_deck(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    at = draw.between(0, -math.pi, math.pi)
    dx, dy = size * math.cos(at), size * math.sin(at)

    def make(run: int) -> Tag:
        return lambda time: (dx, dy, 0.0)

    setup.tags.append(make)
    return {"x_m": dx, "y_m": dy}


@law(
    "sensor_offset",
    "leaning_mast",
    (0.001, 0.6),
    "m",
    "the tag sits on a mast that leans, and bends against speeding up and turning (cantilever below "
    "resonance)",
)
def leaning_mast(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    at, bend = draw.between(0, -math.pi, math.pi), draw.between(1, 0.02, 0.06)  # m per m/s2, at size 1
    dx, dy = size * math.cos(at), size * math.sin(at)

    def make(run: int) -> Smooth:
        def smooth(time: Array, poses: Poses) -> Poses:
            x, y, yaw = poses
            step, wide = time[1] - time[0], np.hanning(31) / np.hanning(31).sum()
            ax, ay = (np.gradient(np.gradient(p, step), step) for p in (x, y))
            ax, ay = np.convolve(ax, wide, "same"), np.convolve(ay, wide, "same")
            c, s = np.cos(yaw), np.sin(yaw)
            px, py = dx - bend * size * (c * ax + s * ay), dy - bend * size * (c * ay - s * ax)
            return x + c * px - s * py, y + s * px + c * py, yaw

        return smooth

    setup.filters.append(make)
    return {"x_m": dx, "y_m": dy, "bend_s2": bend * size}


@law("sensor_yaw", "tag_askew", (0.002, 0.8), "rad", "the tag is glued askew")
def tag_askew(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    turn = draw.sign(0) * size

    def make(run: int) -> Tag:
        return lambda time: (0.0, 0.0, turn)

    setup.tags.append(make)
    return {"yaw_rad": turn}


@law(
    "sensor_yaw",
    "creeping_sticker",
    (0.002, 0.8),
    "rad",
    "the tag hangs askew on soft foam tape and creeps on by a tenth in each run (creep of adhesives)",
)
def creeping_sticker(setup: Setup, size: float, draw: Draw) -> dict[str, float]:
    turn = draw.sign(0) * size

    def make(run: int) -> Tag:
        return lambda time: (0.0, 0.0, turn * (0.95 + 0.1 * (1.0 - np.exp(-np.asarray(time) / 25.0))))

    setup.tags.append(make)
    return {"yaw_rad": turn}
