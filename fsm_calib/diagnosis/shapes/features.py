"""What a mismatch could depend on: groups of generic speed errors, from exogenous quantities alone.

A feature is a speed error over time: forward and sideways [m/s], turning [rad/s], as a function of command, simulated
speed, place, heading, time or history; never of the noisy pose's differences, whose noise would correlate with the
residual (measured: clean robots then look ill). Place and heading come from the smoothed path. A group's features
together answer one question: does the residual depend on this?
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from fsm_calib.diagnosis.replay.robot_size import robot_size
from fsm_calib.diagnosis.replay.situation import Situation
from fsm_calib.types import FloatArray

PLACE_PITCH = 0.18  # m between the centres of place features: about a robot's length
TIME_PITCH = 7.5  # s, slow drifts
FAST_PITCH = 1.5  # s, gusts
PERIODS = tuple(
    float(60.0 / n) for n in np.arange(5.0, 25.0, 0.75)
)  # s: a minute resolves steps of half a turn
AGES = (0.06, 0.12, 0.25, 0.5, 1.0)  # s since a command changed: up to three time constants and beyond
TRAVELS = (0.01, 0.03, 0.06, 0.12, 0.25)  # m since a reversal: up to three caster trails and beyond


@dataclass(frozen=True, eq=False)
class Group:
    """Features of one kind in one channel, made when they are asked for: together they take a hundred megabytes.

    regime : what they depend on; makers : columns (n, 5, m) of increments, one maker a recording; own : each recording
    has features of its own, which are nothing in the others.
    """

    channel: str
    regime: str
    makers: tuple[Callable[[], FloatArray], ...]
    own: bool = False

    @property
    def name(self) -> str:
        """Channel and regime in one word."""
        return f"{self.channel}:{self.regime}"

    def named_alone(self) -> Group:
        """Return the group without its makers, for results that outlive the test."""
        return replace(self, makers=())


def hats(variable: FloatArray, knots: FloatArray) -> FloatArray:
    """Return triangular basis functions of `variable` (n,) at `knots` (m,), shape (n, m), constant beyond the ends."""
    return np.column_stack([np.interp(variable, knots, unit) for unit in np.eye(len(knots))])


def _forward(f: FloatArray, s: Situation) -> FloatArray:
    return body_columns(s, forward=f)


def _turn(f: FloatArray, s: Situation) -> FloatArray:
    return body_columns(s, turn=f / s.half)


def _lateral(f: FloatArray, s: Situation) -> FloatArray:
    return body_columns(s, lateral=f)


def _left(f: FloatArray, s: Situation) -> FloatArray:
    return body_columns(s, forward=0.5 * f, turn=-0.5 * f / s.half)


def _right(f: FloatArray, s: Situation) -> FloatArray:
    return body_columns(s, forward=0.5 * f, turn=0.5 * f / s.half)


def body_columns(s: Situation, **speeds: FloatArray) -> FloatArray:
    """Return increments (n, 5, m) of speed errors (n, m) by channel; the wheels turn with the body."""
    m = next(iter(speeds.values())).shape[1]
    out = np.zeros((len(s.dt), 5, m))
    for k, name in enumerate(("forward", "lateral", "turn")):
        if name in speeds:
            out[:, k] = speeds[name] * s.dt[:, None]
    out[:, 3] = (out[:, 0] - s.half * out[:, 2]) / s.radii[0]
    out[:, 4] = (out[:, 0] + s.half * out[:, 2]) / s.radii[1]
    return out


def apart_columns(s: Situation, forward: FloatArray, turn: FloatArray) -> FloatArray:
    """Return increments (n, 5, 2 m) of forward [m/s] and of turning [rad/s] speed errors (n, m), each by itself."""
    return np.concatenate([body_columns(s, forward=forward), body_columns(s, turn=turn)], axis=2)


Maker = Callable[[Situation], FloatArray]
Channelled = Callable[[FloatArray, Situation], FloatArray]


def _moving(s: Situation) -> FloatArray:
    return np.clip((np.abs(s.v) + s.half * np.abs(s.omega)) / 0.02, 0.0, 1.0)


def _world(s: Situation, basis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return forward and left components of world-fixed speeds along x and y with amplitude `basis` (n, m)."""
    c, d = np.cos(s.heading)[:, None], np.sin(s.heading)[:, None]
    return np.hstack([c * basis, d * basis]), np.hstack([-d * basis, c * basis])


def feature_groups(situations: list[Situation]) -> Iterator[Group]:
    """Yield all groups for the recordings of one robot."""
    limit = (
        max(float(np.max(np.abs(np.concatenate([s.left, s.right])))) for s in situations for s in [s]) or 1.0
    )
    commands = np.linspace(-limit, limit, 9)
    speed = max(float(np.quantile(np.abs(s.v), 0.98)) for s in situations) or 0.1
    spin = max(float(np.quantile(np.abs(s.omega), 0.98)) for s in situations) or 0.1
    centres = place_centres(situations, place_pitch(situations))
    end = max(float(s.time[-1]) for s in situations)
    slow = np.linspace(0.0, end, max(3, int(end / TIME_PITCH)))
    moving = _moving
    recipes: list[tuple[str, str, Channelled, Maker]] = [
        ("forward", "command level", _forward, lambda s: hats(0.5 * (s.left + s.right), commands)),
        ("turn", "command level", _turn, lambda s: hats(0.5 * (s.right - s.left), commands)),
        ("left wheel", "command level", _left, lambda s: hats(s.left, commands)),
        ("right wheel", "command level", _right, lambda s: hats(s.right, commands)),
        ("forward", "other wheel", _forward, lambda s: hats(s.left, commands) * np.sign(s.right)[:, None]),
        ("forward", "direction of motion", _forward, _direction),
        ("turn", "direction of motion", _turn, _direction),
        ("forward", "wear and warmth", _forward, lambda s: _trend(s) * s.v[:, None] / speed),
        ("turn", "wear and warmth", _turn, lambda s: _trend(s) * s.omega[:, None] / spin),
        ("lateral", "fast turns", _lateral, lambda s: np.column_stack([s.v, s.v * s.omega, s.omega, s.spin * 0.1])),
        ("turn", "speed and turning", _turn, lambda s: _turning(s, speed, spin)),
        ("forward", "speed and turning", _forward, lambda s: _driving(s, speed, spin)),
        ("forward", "place", _forward, lambda s: _bumps(s, centres) * (np.tanh(s.v / 0.02))[:, None]),
        ("turn", "place", _turn, lambda s: _bumps(s, centres) * (np.tanh(s.omega * s.half / 0.01))[:, None]),
        ("lateral", "place", _lateral, lambda s: _bumps(s, centres) * moving(s)[:, None]),
        ("forward", "place and heading", _forward, lambda s: _world(s, hats_xy(s, centres) * moving(s)[:, None])[0]),
        ("forward", "heading", _forward, lambda s: _harmonics(s.heading) * moving(s)[:, None]),
        ("lateral", "heading", _lateral, lambda s: _harmonics(s.heading) * moving(s)[:, None]),
        ("forward", "heading and speed", _forward, lambda s: _harmonics(s.heading) * s.v[:, None] / speed),
        ("turn", "heading", _turn, lambda s: _harmonics(s.heading) * (s.omega * s.half)[:, None] * 5),
        ("forward", "time", _forward, lambda s: hats(s.time, slow) * (s.v / speed)[:, None]),
        ("turn", "time", _turn, lambda s: hats(s.time, slow) * (s.omega / spin)[:, None]),
        ("left wheel", "time", _left, lambda s: hats(s.time, slow) * np.sign(s.left)[:, None]),
        ("right wheel", "time", _right, lambda s: hats(s.time, slow) * np.sign(s.right)[:, None]),
        ("forward", "after a command", _forward, lambda s: _after(s, s.jump_v / speed)),
        ("turn", "after a command", _turn, lambda s: _after(s, s.jump_w / spin)),
        ("forward", "after a reversal", _forward, lambda s: _since(s) * np.sign(s.v)[:, None] * moving(s)[:, None]),
        ("turn", "after a reversal", _turn, lambda s: _since(s) * np.sign(s.v)[:, None] * moving(s)[:, None]),
        ("turn", "heading turned", _turn, _wound),
        ("forward", "wheel phase", _forward, lambda s: _phase(s, slow)),
        ("turn", "wheel phase", _turn, lambda s: _phase(s, slow)),
        ("forward", "moment", _forward, lambda s: _gusts(s, end)),
    ]  # fmt: skip
    recipes += [("forward", "repeats in time", _forward, _periodic(period)) for period in PERIODS]
    return (_group(situations, *recipe) for recipe in recipes)


RUN_BOUND = {"time", "moment", "repeats in time", "wheel phase", "heading turned"}
"""Regimes whose features belong to one recording, not to the robot."""


def _group(situations: list[Situation], channel: str, regime: str, put: Channelled, make: Maker) -> Group:
    makers = tuple(partial(_made, put, make, s) for s in situations)
    return Group(channel, regime, makers, own=regime in RUN_BOUND)


def _made(put: Channelled, make: Maker, situation: Situation) -> FloatArray:
    return put(make(situation), situation)


def place_pitch(situations: list[Situation]) -> float:
    """Return the distance [m] between the centres of place features, for this robot."""
    return PLACE_PITCH * robot_size(situations[0].half)


def place_centres(situations: list[Situation], pitch: float, beside: bool = False) -> FloatArray:
    """Return centres (m, 2) [m] of a grid over the floor that was visited while moving, and beside it if asked for."""
    visited = np.concatenate([np.column_stack([s.x, s.y])[_moving(s) > 0.5] for s in situations])
    if not len(visited):
        return np.zeros((1, 2))
    centres = cells_about(visited, pitch)
    if not beside:
        return centres
    steps = pitch * np.array([(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)])
    return cells_about((centres[:, None] + steps).reshape(-1, 2), pitch)


def cells_about(points: FloatArray, pitch: float) -> FloatArray:
    """Return the middles (m, 2) of the cells of a grid in which some points (n, 2) lie, all in [m]."""
    return (np.unique(np.floor(points / pitch).astype(int), axis=0) + 0.5) * pitch


def _bumps(s: Situation, centres: FloatArray) -> FloatArray:
    """Return Gaussian place functions, width 0.6 pitch."""
    square = (s.x[:, None] - centres[:, 0]) ** 2 + (s.y[:, None] - centres[:, 1]) ** 2
    return np.exp(-0.5 * square / (0.6 * PLACE_PITCH * robot_size(s.half)) ** 2)


def hats_xy(s: Situation, centres: FloatArray) -> FloatArray:
    """Return a constant and linear functions of place, scaled to the visited field, shape (n, 3)."""
    middle, reach = centres.mean(axis=0), max(float(np.ptp(centres, axis=0).max()) / 2, PLACE_PITCH)
    return np.column_stack([np.ones(len(s.x)), (s.x - middle[0]) / reach, (s.y - middle[1]) / reach])


def _turning(s: Situation, speed: float, spin: float) -> FloatArray:
    """Return functions of the yaw rate and of its product with the speed."""
    product = hats(s.omega * np.abs(s.v), np.linspace(-spin * speed, spin * speed, 5))
    return np.hstack([hats(s.omega, np.linspace(-spin, spin, 7)), product])


def _driving(s: Situation, speed: float, spin: float) -> FloatArray:
    """Return functions of the speed and of the yaw rate's size, which changes sign with the direction."""
    turning = hats(np.abs(s.omega), np.linspace(0, spin, 5)) * np.sign(s.v)[:, None]
    return np.hstack([hats(s.v, np.linspace(-speed, speed, 9)), turning])


def _gusts(s: Situation, end: float) -> FloatArray:
    """Return the forward part of world-fixed speeds, each for a moment."""
    return _world(s, hats(s.time, np.arange(0.0, end, FAST_PITCH)) * _moving(s)[:, None])[0]


def _direction(s: Situation) -> FloatArray:
    """Return which way the body and each wheel move: few numbers, so that faint dry friction stands out."""
    left, right = s.v - s.half * s.omega, s.v + s.half * s.omega
    return np.column_stack([np.tanh(u / 0.02) for u in (s.v, s.half * s.omega, left, right)])


def _trend(s: Situation) -> FloatArray:
    """Return time and its square, in minutes: few numbers for what grows through a recording."""
    minutes = s.time / 60.0
    return np.column_stack([minutes, minutes**2])


def _wound(s: Situation) -> FloatArray:
    """Return a constant, the angle turned since the start, and its square: a cable or a spring winds up."""
    turned = s.heading - s.heading[0]
    reach = max(float(np.abs(turned).max()), 1.0)
    return (
        np.column_stack([np.ones(len(turned)), turned / reach, (turned / reach) ** 2]) * _moving(s)[:, None]
    )


def _periodic(period: float) -> Maker:
    """Return the maker of world-fixed speeds that come and go with a period [s]."""

    def make(s: Situation) -> FloatArray:
        angle = 2.0 * np.pi * s.time / period
        waves = np.column_stack([np.cos(angle), np.sin(angle)])
        return _world(s, waves * _moving(s)[:, None])[0]

    return make


def _harmonics(heading: FloatArray) -> FloatArray:
    return np.column_stack([np.cos(heading), np.sin(heading), np.cos(2 * heading), np.sin(2 * heading)])


def _after(s: Situation, jump: FloatArray) -> FloatArray:
    return hats(s.age, np.array([0.0, *AGES])) * jump[:, None]


def _since(s: Situation) -> FloatArray:
    return hats(s.travel, np.array([0.0, *TRAVELS]))


def _phase(s: Situation, knots: FloatArray) -> FloatArray:
    window = hats(s.time, knots)
    wheels = [
        (f(s.roll[:, i]) * (s.v - (1 - 2 * i) * s.half * s.omega))[:, None] * window
        for i in range(2)
        for f in (np.cos, np.sin)
    ]
    return np.hstack(wheels)
