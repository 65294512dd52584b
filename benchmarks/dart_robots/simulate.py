"""One drive: commands through firmware, motors and the DART engine to a true trajectory.

Dry friction of gears and rolling resistance act at the wheel's joint as the engine's own Coulomb friction (it
sticks); a ball caster slides with Coulomb friction that is smoothed at 2 cm/s, independent of direction.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol

import numpy as np

from benchmarks.dart_robots.motors import Battery, Channel, Link
from benchmarks.dart_robots.truth import Moments, Patch, Trajectory, Truth, loads
from benchmarks.dart_robots.world import Built, build

SAMPLE = 0.004  # s between rows of a trajectory; steps of 0.5, 1, 2 and 4 ms divide it
SETTLE = 0.4  # s that the robot stands on the floor before time 0
SLIDING = 0.02  # m/s: speed at which a sliding caster's friction is at 71 %
CREEP_FLOOR = 0.01  # m/s: rolling speed below which a tyre's creep no longer stiffens


class Source(Protocol):
    """Where commands come from, one at every tick."""

    tick: float

    def command(self, time: float, x: float, y: float, theta: float) -> tuple[float, float]:
        """Return left and right command, given the true pose."""


class Replay:
    """The commands of an earlier drive again."""

    def __init__(self, drive: Trajectory, tick: float):
        self.left, self.right, self.tick = drive.command_left, drive.command_right, tick

    def command(self, time: float, x: float, y: float, theta: float) -> tuple[float, float]:
        """Return the command of this tick."""
        row = min(round(time / self.tick), len(self.left) - 1)
        return float(self.left[row]), float(self.right[row])


class Outside:
    """Everything that acts on the bodies but motors: casters, floors, patches, pushes."""

    def __init__(self, truth: Truth, built: Built, moments: Moments, dt: float):
        self.truth, self.built, self.moments, self.dt = truth, built, moments, dt
        body, place = truth.body, truth.place
        self.loads = loads(body)
        self.rolling = [body.rolling * self.loads[side] * body.radius[side] for side in (0, 1)]
        self.caster_at = [body.caster_arm, 0.0, -float(np.mean(body.radius))]
        self.caster_grip = body.caster_grip
        self.axle_at = [0.0, 0.0, -float(np.mean(body.radius))]
        self.extra = [0.0, 0.0]
        self.fast: list[Callable[[float, list[float]], None]] = []
        if body.caster == "ball":
            self.fast.append(self._caster)
        if any(body.oval):
            self.fast.append(self._oval)
        if body.cornering:
            self.fast.append(self._creep)
        if place.nap_drag:
            self.fast.append(self._nap_drag)
        if place.nap_carry:
            self.fast.append(self._nap_carry)
        if place.push:
            self.fast.append(self._push)
        if place.tether:
            self.fast.append(self._tether)
        if place.fan:
            self.fast.append(self._fan)

    def _force(self, x: float, y: float, at: list[float]) -> None:
        self.built.base.addExtForce([x, y, 0.0], at, False, True)

    def _caster(self, time: float, rates: list[float]) -> None:
        vx, vy, _ = self.built.base.getLinearVelocity(self.caster_at)
        scale = -self.caster_grip * self.loads[2] / math.sqrt(vx * vx + vy * vy + SLIDING**2)
        self._force(scale * vx, scale * vy, self.caster_at)

    def _oval(self, time: float, rates: list[float]) -> None:
        body = self.truth.body
        for side, wheel in enumerate(self.built.wheels):
            bend = body.oval[side]
            if bend:
                angle = 2.0 * wheel.angle() + body.phase[side]
                wheel.shape.setRadius(body.radius[side] * (1.0 + bend * math.cos(angle)))
                # the load climbs as the radius grows: virtual work gives the torque
                lift = 2.0 * self.loads[side] * body.radius[side] * bend * math.sin(angle)
                wheel.body.addExtTorque([0.0, lift, 0.0], True)

    def _creep(self, time: float, rates: list[float]) -> None:
        body = self.truth.body
        for side, wheel in enumerate(self.built.wheels):
            radius = body.radius[side]
            speed = max(abs(rates[side]) * radius, CREEP_FLOOR)
            stiffness = body.cornering * self.loads[side] * radius**2 / speed
            wheel.roller.setPosition(0, 0.0)
            wheel.roller.setDampingCoefficient(0, stiffness)

    def _nap_drag(self, time: float, rates: list[float]) -> None:
        place = self.truth.place
        vx, vy, _ = self.built.base.getLinearVelocity()
        speed = math.sqrt(vx * vx + vy * vy + SLIDING**2)
        along = (vx * math.cos(place.nap_heading) + vy * math.sin(place.nap_heading)) / speed
        drag = -place.nap_drag * sum(self.loads) * (1.0 - along) / 2.0 / speed
        self._force(drag * vx, drag * vy, self.axle_at)

    def _nap_carry(self, time: float, rates: list[float]) -> None:
        place, body = self.truth.place, self.truth.body
        rolled = (abs(rates[0]) * body.radius[0] + abs(rates[1]) * body.radius[1]) / 2.0
        speed = place.nap_carry * rolled
        floor = self.built.floor
        floor.setPositions([0.0, 0.0])
        floor.setCommands([speed * math.cos(place.nap_heading), speed * math.sin(place.nap_heading)])

    def _push(self, time: float, rates: list[float]) -> None:
        place, since = self.truth.place, time - self.moments.push_start
        if 0.0 <= since < place.push_time:
            force = place.push * math.sin(math.pi * since / place.push_time)
            at = [*place.push_at, 0.02]
            self._force(force * math.cos(place.push_heading), force * math.sin(place.push_heading), at)

    def _tether(self, time: float, rates: list[float]) -> None:
        place = self.truth.place
        x, y, _ = self.built.base.getWorldTransform().translation()
        dx, dy = place.tether_at[0] - x, place.tether_at[1] - y
        far = math.hypot(dx, dy)
        pull = place.tether * min(1.0, max(0.0, far - 0.3))
        self._force(pull * dx / far, pull * dy / far, [self.truth.body.caster_arm, 0.0, 0.05])

    def _fan(self, time: float, rates: list[float]) -> None:
        place = self.truth.place
        force = place.fan * max(0.0, math.sin(2 * math.pi * time / place.fan_period)) ** 2
        force_x, force_y = force * math.cos(place.fan_heading), force * math.sin(place.fan_heading)
        self._force(force_x, force_y, [0.0, 0.0, 0.06])

    def patches(self, x: float, y: float, theta: float) -> None:
        """Set grip and rolling resistance by where each wheel and the caster stand."""
        place, body = self.truth.place, self.truth.body
        half = body.axle / 2
        spots = [(x - half * math.sin(theta), y + half * math.cos(theta))]
        spots.append((x + half * math.sin(theta), y - half * math.cos(theta)))
        arm = body.caster_arm
        if place.rough is not None:
            for side, spot in enumerate(spots):
                inside = within(place.rough, *spot)
                self.extra[side] = place.rough.rolling * self.loads[side] * body.radius[side] * inside
            inside = within(place.rough, x + arm * math.cos(theta), y + arm * math.sin(theta))
            self.caster_grip = body.caster_grip + place.rough.rolling * inside
        if place.slippery is not None:
            for side, spot in enumerate(spots):
                grip = place.slippery.grip if within(place.slippery, *spot) else body.tyre_grip
                for aspect in self.built.wheels[side].grips:
                    aspect.setFrictionCoeff(grip)


def within(patch: Patch, x: float, y: float) -> bool:
    """Return whether a point lies on a patch."""
    return (x - patch.x) ** 2 + (y - patch.y) ** 2 < patch.radius**2


def simulate(
    truth: Truth,
    source: Source,
    seconds: float,
    dt: float,
    moments: Moments,
    start: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> Trajectory:
    """Drive for `seconds` from `start` (x, y, theta) and return what happened."""
    built = build(truth, dt)
    drive = truth.drive
    _, _, _, _, _, height = built.root.getPositions()
    built.root.setPositions([0.0, 0.0, start[2], start[0], start[1], height])
    outside = Outside(truth, built, moments, dt)
    channels = [Channel(drive, truth.place, moments, side) for side in (0, 1)]
    battery, link = Battery(drive, seconds), Link(drive, moments)
    world, wheels = built.world, built.wheels
    patchy = truth.place.rough is not None or truth.place.slippery is not None
    every, tick = round(SAMPLE / dt), round(source.tick / dt)
    settle = round(SETTLE / dt)
    rows: list[tuple[float, ...]] = []
    commands: list[tuple[float, float, float]] = []
    volts, dries = drive.volts, [-1.0, -1.0]
    zero = [0.0, 0.0]
    for step in range(-settle, round(seconds / dt) + 1):
        time = step * dt
        if step == 0:
            zero = [wheel.angle() for wheel in wheels]
        if step % every == 0 or (step >= 0 and step % tick == 0):
            m = built.base.getWorldTransform().matrix()
            x, y, theta = m[0, 3], m[1, 3], math.atan2(m[1, 0], m[0, 0])
            if patchy:
                outside.patches(x, y, theta)
            if step >= 0 and step % every == 0:
                left, right = wheels[0].angle() - zero[0], wheels[1].angle() - zero[1]
                rows.append((time, x, y, theta, left, right, m[2, 3]))
            if step >= 0 and step % tick == 0:
                wanted = source.command(time, x, y, theta)
                commands.append((time, *wanted))
                link.send(time, *wanted)
        now = link.read(time) if step >= 0 else (0.0, 0.0)
        rates = [0.0, 0.0]
        current = 0.0
        for side in (0, 1):
            wheel, channel = wheels[side], channels[side]
            rate = wheel.motor.getVelocity(0)
            angle = wheel.motor.getPosition(0) if drive.mode == "rate" else 0.0
            torque = channel.torque(time, now[side], rate, angle, volts, channels[1 - side].current, dt)
            wheel.motor.setForce(0, torque)
            dry = channel.dry(time, rate)
            rolling = outside.rolling[side] + outside.extra[side]
            if wheel.hub is None:
                dry += rolling
            else:
                rate = wheel.rate()
                wheel.hub.setForce(0, 0.0)
                wheel.body.addExtTorque([0.0, -rolling * math.tanh(rate / 0.2), 0.0], True)
            if dry != dries[side]:
                wheel.motor.setCoulombFriction(0, dry)
                dries[side] = dry
            rates[side] = rate
            current += channel.drawn
        volts = battery.volts(current, dt) if step >= 0 else drive.volts
        for act in outside.fast:
            act(time, rates)
        world.step()
    return _collect(rows, commands)


def _collect(rows: list[tuple[float, ...]], commands: list[tuple[float, float, float]]) -> Trajectory:
    time, x, y, theta, left, right, height = np.array(rows).T
    at, first, second = np.array(commands).T
    return Trajectory(time, x, y, np.unwrap(theta), left, right, height, at, first, second)
