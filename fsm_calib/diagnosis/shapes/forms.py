"""Un-named corrections: what a speed error could depend on, in one physical quantity at a time, few numbers each.

A named effect is a curve with one or two numbers. Whether it has the right shape is asked by letting shapes without a
name compete with it (`form_test`). What changes a wheel's speed is carried on by the roll-out (`wheel_response`); what
acts on the body passes the base robot's lag, tau dv/dt = f - v, forward and turning each with its own time constant
tau [s]; what the sensor adds (timing, mount) does not, and the wheels do not show it. Everything is a function of
exogenous quantities (`situation.py`). The scales only keep the columns within a few orders of magnitude of each other.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from fsm_calib.diagnosis.replay.situation import last_sign
from fsm_calib.diagnosis.shapes.features import apart_columns, body_columns, hats
from fsm_calib.diagnosis.shapes.form_frame import DRY_SPEED, Frame, lagged, powers, sign
from fsm_calib.types import FloatArray

AT_REST = 0.01  # command below which a wheel coasts
AGES = np.array([0.0, 0.06, 0.12, 0.25, 0.5, 1.0])  # s since a command changed
TRAVELS = np.array([0.0, 0.01, 0.03, 0.06, 0.12, 0.25])  # m since a reversal
LOADED = 0.1  # m/s2 of a rim: from there on a motor surely pushes, or brakes
SLACK, SETTLING = 0.005, 0.1  # m, s
SPEED_KNOTS = 7
MINUTE = 60.0


@dataclass(frozen=True, eq=False)
class Form:
    """Corrections that depend on one quantity: columns (n, 5, m) of increments for each recording."""

    quantity: str
    columns: tuple[FloatArray, ...]


def _bent(u: FloatArray) -> FloatArray:
    """Return what bends a motor's line: dead zone, quadratic, cubic, and the same uneven in both directions."""
    return np.column_stack([np.sign(u), u * np.abs(u), u**3, np.abs(u), u * u])


def _command(f: Frame) -> FloatArray:
    return f.drive(f.full * _bent(f.s.left), f.full * _bent(f.s.right))


def _load(f: Frame) -> FloatArray:
    load = f.full * (np.abs(f.s.left) + np.abs(f.s.right))
    return f.drive((load * f.s.left)[:, None], (load * f.s.right)[:, None])


def _other_wheel(f: Frame) -> FloatArray:
    def from_other(own: FloatArray, other: FloatArray) -> FloatArray:
        on = np.abs(own) > AT_REST
        return f.full * np.column_stack([other, np.sign(other) * on, np.abs(other)])

    return f.drive(from_other(f.s.left, f.s.right), from_other(f.s.right, f.s.left))


def _pivot(f: Frame) -> FloatArray:
    """Return what happens while one wheel drives and the other stands: of the driven wheel, the body, the turning."""
    left, right = (np.abs(u) > AT_REST for u in (f.s.left, f.s.right))
    alone = (left != right)[:, None]

    def driven_alone(own: FloatArray) -> FloatArray:
        return np.asarray(f.full * alone * np.column_stack([own, np.sign(own) * (np.abs(own) > AT_REST)]))

    body = f.forward(alone * sign(f.s.v)[:, None])
    turn = f.turn(alone * sign(f.s.half * f.s.omega)[:, None] / f.s.half)
    return np.concatenate([f.drive(driven_alone(f.s.left), driven_alone(f.s.right)), body, turn], axis=2)


def _time(f: Frame) -> FloatArray:
    time = powers(f.s.time / MINUTE, 3)
    left, right = f.full * f.s.left[:, None] * time, f.full * f.s.right[:, None] * time
    return np.concatenate([f.drive(left[:, :2], right[:, :2]), f.each(left, right)], axis=2)


def _work(f: Frame) -> FloatArray:
    own = [np.cumsum(np.abs(u) * f.s.dt) / MINUTE for u in (f.s.left, f.s.right)]
    both = powers(own[0] + own[1], 2)
    left, right = f.full * f.s.left[:, None], f.full * f.s.right[:, None]
    alone = f.each(own[0][:, None] * left, own[1][:, None] * right)
    return np.concatenate([f.drive(both * left, both * right), alone], axis=2)


def _braking(f: Frame) -> FloatArray:
    def brakes(command: FloatArray, rim: FloatArray) -> FloatArray:
        short = f.full * command[:, None] - rim
        coasting = np.abs(command)[:, None] < AT_REST
        return np.hstack([np.where(short * rim < 0.0, short, 0.0), np.where(coasting, short, 0.0)])

    return f.drive(brakes(f.s.left, f.rims[0]), brakes(f.s.right, f.rims[1]))


def _dry(f: Frame) -> FloatArray:
    left, right = (sign(rim) for rim in f.rims)
    body = f.forward(sign(f.s.v)[:, None])
    turn = f.turn(sign(f.s.half * f.s.omega)[:, None] / f.s.half)
    return np.concatenate([f.drive(left, right), f.each(left, right), body, turn], axis=2)


def _speed(f: Frame) -> FloatArray:
    def shape(x: FloatArray, limit: float) -> FloatArray:
        return np.delete(hats(x, np.linspace(-limit, limit, SPEED_KNOTS)), SPEED_KNOTS // 2, axis=1)

    left, right = (shape(rim[:, 0], f.speed) for rim in f.rims)
    forward, turn = shape(f.s.v, f.speed), shape(f.s.omega, f.spin) / f.s.half
    return np.concatenate([f.drive(left, right), f.forward(forward), f.turn(turn)], axis=2)


def _curves(f: Frame) -> FloatArray:
    """Return products of speed and turning, and a dry drag of one size that both have to share."""
    s, rim = f.s, f.s.half * f.s.omega
    forward = np.column_stack([s.v * np.abs(rim), sign(s.v) * np.abs(rim), rim * s.omega, rim])
    turn = np.column_stack([rim * np.abs(s.v), sign(rim) * np.abs(s.v), s.v * rim, s.v]) / s.half
    whole = np.sqrt(s.v**2 + rim**2 + DRY_SPEED**2)
    shared = f.forward((s.v / whole)[:, None]), f.turn((rim / whole)[:, None] / s.half)
    return np.concatenate([f.forward(forward), f.turn(turn), *shared], axis=2)


def _heading(f: Frame) -> FloatArray:
    moving = np.clip((np.abs(f.s.v) + f.s.half * np.abs(f.s.omega)) / DRY_SPEED, 0.0, 1.0)[:, None]
    angle = f.s.heading[:, None] * [1.0, 2.0]
    waves = np.hstack([np.cos(angle), np.sin(angle)])
    return np.concatenate([f.forward(waves * moving), f.forward(waves * sign(f.s.v)[:, None])], axis=2)


def _place(f: Frame) -> FloatArray:
    """Return the forward part of a field that grows linearly with the place: a bowl, a slope that bends, a spring."""
    moving = np.clip((np.abs(f.s.v) + f.s.half * np.abs(f.s.omega)) / DRY_SPEED, 0.0, 1.0)
    along, across = np.cos(f.s.heading) * moving, np.sin(f.s.heading) * moving
    return f.forward(np.column_stack([a * b for a in (along, across) for b in (f.s.x, f.s.y)]))


def _wound(f: Frame) -> FloatArray:
    """Return what a cable or a spring does that is wound up by turning."""
    turned = f.s.heading - f.s.heading[0]
    return f.turn(np.column_stack([np.ones(len(turned)), powers(turned, 2)]) / f.s.half)


def _lateness(f: Frame) -> FloatArray:
    """Return what arrives late: forward and turning apart, together, and by the sensor's clock alone."""
    late = np.hstack([np.ones((len(f.s.dt), 1)), powers(f.s.time / MINUTE, 2)])
    forward, turn = f.s.acceleration[:, None] * late, f.s.spin[:, None] * late
    return f.every_way(forward, turn)


def _after_command(f: Frame) -> FloatArray:
    since = hats(f.s.age, AGES)
    forward, turn = since * f.s.jump_v[:, None], since * f.s.jump_w[:, None]
    return apart_columns(f.s, forward, turn)


def _after_reversal(f: Frame) -> FloatArray:
    since = hats(f.s.travel, TRAVELS)
    along, about = since * sign(f.s.v)[:, None], since * sign(f.s.half * f.s.omega)[:, None]
    turns = [body_columns(f.s, turn=g / f.s.half) for g in (along, about)]
    return np.concatenate([body_columns(f.s, forward=along), *turns], axis=2)


def _slack(f: Frame) -> FloatArray:
    """Return what wheels lose on the way when their motors begin to push the other way: at once, over a while."""

    def lost(pull: FloatArray) -> FloatArray:
        steps = np.diff(last_sign(pull, LOADED), prepend=0.0)[:, None]
        way = SLACK * np.hstack([steps, lagged(steps, f.s.dt, SETTLING)])
        return np.divide(way, f.s.dt[:, None], out=np.zeros_like(way), where=f.s.dt[:, None] > 0.0)

    spin = f.s.half * f.s.spin
    left, right = lost(f.s.acceleration - spin), lost(f.s.acceleration + spin)
    forward, turn = 0.5 * (left + right), 0.5 * (right - left) / f.s.half
    return f.every_way(forward, turn)


def _mount(f: Frame) -> FloatArray:
    s, rim = f.s, f.s.half * f.s.omega
    sideways = np.column_stack([s.v, rim, s.v * s.omega, s.half * s.spin])
    along = np.column_stack([rim, rim * s.omega, s.half * s.spin])
    return np.concatenate([f.sensed(lateral=sideways), f.sensed(forward=along)], axis=2)


RECIPES: dict[str, Callable[[Frame], FloatArray]] = {
    "the command's size": _command,
    "the load of both motors": _load,
    "the other wheel's command": _other_wheel,
    "whether one wheel stands": _pivot,
    "the time": _time,
    "the work done": _work,
    "braking": _braking,
    "the direction of motion": _dry,
    "the speed": _speed,
    "speed and turning together": _curves,
    "the heading": _heading,
    "the place": _place,
    "the turns made": _wound,
    "how late it arrives": _lateness,
    "the time since a command": _after_command,
    "the way since a reversal": _after_reversal,
    "which way the motors push": _slack,
    "where the sensor sits": _mount,
}
"""Quantity to columns; single functions may occur twice, what depends on another is projected out."""


def forms(frames: Sequence[Frame]) -> Iterator[Form]:
    """Yield every un-named correction for the recordings of one robot, one at a time: together they are large."""
    return (Form(name, tuple(recipe(f) for f in frames)) for name, recipe in RECIPES.items())
