"""Physics outside of all labels: what a diagnosis should leave without a name."""

from __future__ import annotations

import math
from dataclasses import replace

from benchmarks.rapier_robots.engine import GRAVITY, STEP
from benchmarks.rapier_robots.laws import OUTSIDE, Draw, law
from benchmarks.rapier_robots.plant import Trailer
from benchmarks.rapier_robots.setup import CommandHook, FloorHook, Setup, State


@law(
    OUTSIDE,
    "1",
    0.03,
    1.0,
    "a cart on a ball hitch, as bodies in the engine (vehicle dynamics of trailers)",
    needs="duty",
)
def trailer(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """A two-wheeled cart of `size` of the robot's mass is towed."""
    hitch = -s.plant.casters[0].x * 1.2
    cart = Trailer(size * s.plant.total, d.between(0, 1.2, 2.2) * hitch, hitch, 0.03)
    s.plant = replace(s.plant, trailer=cart)
    return {"mass_kg": cart.mass, "bar_m": cart.bar}


@law(
    OUTSIDE, "1", 0.002, 1.0, "bungee to a post: taut beyond its length, then a spring (Hooke)", needs="duty"
)
def bungee(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """A cord pulls by `size` of the weight for each area radius that it is stretched."""
    px, py = d.between(0, -0.5, 0.5) * d.area, d.between(1, -0.5, 0.5) * d.area
    slack, stiff = 0.25 * d.area, size * s.plant.total * GRAVITY / d.area

    def hook(st: State) -> None:
        x, y = px - st.x, py - st.y
        away = math.hypot(x, y)
        if away > slack:
            pull = stiff * (away - slack) / away
            st.fx += pull * x
            st.fy += pull * y

    s.floors.append(lambda run: hook)
    return {"stiffness": size, "x_m": px, "y_m": py, "slack_m": slack}


@law(
    OUTSIDE,
    "1",
    0.002,
    0.5,
    "jet of a swinging fan, Gaussian across (Rajaratnam, Turbulent Jets)",
    needs="duty",
)
def fan(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """A fan at the rim swings its jet over the floor; in its middle it pushes by `size` of the weight."""
    at, period, weight = d.angle(0), d.between(1, 5.0, 11.0), s.plant.total * GRAVITY
    fx, fy = 1.6 * d.area * math.cos(at), 1.6 * d.area * math.sin(at)

    def hook(st: State) -> None:
        aim = at + math.pi + 0.6 * math.sin(2.0 * math.pi * st.t / period)
        x, y = st.x - fx, st.y - fy
        off = math.remainder(math.atan2(y, x) - aim, 2.0 * math.pi)
        push = size * weight * math.exp(-((off / 0.35) ** 2))
        st.fx += push * math.cos(aim)
        st.fy += push * math.sin(aim)
        st.tz += 0.1 * s.plant.axle * push * math.sin(st.yaw - aim)

    s.floors.append(lambda run: hook)
    return {"push": size, "period_s": period}


@law(
    OUTSIDE,
    "1",
    0.002,
    0.5,
    "a magnet below the table turns and pulls an iron chassis (dipole field)",
    needs="duty",
)
def magnet(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Near a spot the robot's nose is pulled by `size` of the weight at most."""
    (px, py), reach = d.spots[0], 0.25 * d.area
    nose, top = 0.5 * s.plant.axle, size * s.plant.total * GRAVITY

    def hook(st: State) -> None:
        x, y = px - (st.x + nose * st.c), py - (st.y + nose * st.s)
        q = (x * x + y * y) / reach**2
        pull = top / reach / (1.0 + q) ** 2.5
        st.fx += pull * x
        st.fy += pull * y
        st.tz += nose * pull * (st.c * y - st.s * x)

    s.floors.append(lambda run: hook)
    return {"pull": size, "x_m": px, "y_m": py, "reach_m": reach}


@law(
    OUTSIDE, "1", 0.01, 0.9, "first sloshing mode of a tank as a mass on a spring (NASA SP-106)", needs="duty"
)
def sloshing_water(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Water of `size` of the robot's mass swings ahead and aside at about a hertz."""
    omega, mass, damp = 2.0 * math.pi * d.between(0, 0.7, 1.3), size * s.plant.total, 0.04

    def make(run: int) -> FloorHook:
        p, v = (
            [0.0, 0.0],
            [0.0, 0.0],
        )  # of the water in the world, from the tank's middle [m], and its own [m/s]

        def hook(st: State) -> None:
            tank = (st.speed * st.c, st.speed * st.s)
            for n in (0, 1):
                pull = -omega * omega * p[n] - 2.0 * damp * omega * (v[n] - tank[n])
                v[n] += pull * STEP
                p[n] += (v[n] - tank[n]) * STEP
            st.fx += mass * (omega * omega * p[0] + 2.0 * damp * omega * (v[0] - tank[0]))
            st.fy += mass * (omega * omega * p[1] + 2.0 * damp * omega * (v[1] - tank[1]))

        return hook

    s.floors.append(make)
    return {"share": size, "omega": omega}


@law(
    OUTSIDE,
    "1",
    0.003,
    0.6,
    "a heading-hold with a compass left on: steers north when it drives (autopilot manuals)",
)
def compass_hold(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """While both wheels drive ahead, firmware steers towards north by up to `size` of the command."""
    north = d.angle(0)

    def hook(st: State, left: float, right: float) -> tuple[float, float]:
        if left > 0.05 and right > 0.05:
            steer = size * math.sin(north - st.yaw)
            return left * (1.0 - steer), right * (1.0 + steer)
        return left, right

    s.commands.append(lambda run: hook)
    return {"gain": size, "north_rad": north}


@law(OUTSIDE, "1", 0.01, 0.95, "bursts of lost packets, the last command holds (Gilbert-Elliott channel)")
def lost_packets(s: Setup, size: float, d: Draw) -> dict[str, float]:
    """Commands are lost in bursts of 0.15 to 0.5 s on average, a share `size` of the time."""
    burst = d.between(0, 0.15, 0.5)

    def make(run: int) -> CommandHook:
        rng, now = d.rng(run), [0.0, 0.0, 0.0, 0.0]

        def hook(st: State, left: float, right: float) -> tuple[float, float]:
            if st.t >= now[3]:
                now[2] = 0.0 if now[2] else 1.0
                mean = burst if now[2] else burst * (1.0 - size) / size
                now[3] = st.t + float(rng.exponential(mean))
            if not now[2]:
                now[0], now[1] = left, right
            return now[0], now[1]

        return hook

    s.commands.append(make)
    return {"share": size, "burst_s": burst}
