"""Draws a robot: its kind, body, casters, motors, controller, sensors, and its data sheet. SI units."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from benchmarks.exudyn_robots import engine
from benchmarks.exudyn_robots.engine import Body, Caster
from benchmarks.exudyn_robots.params import blank
from benchmarks.exudyn_robots.physics import G
from benchmarks.exudyn_robots.sensing import Sensing


@dataclass(frozen=True)
class Kind:
    """Ranges (low, high) of a kind: mass kg, axle m, wheel radius m, top speed m/s, casters."""

    name: str
    mass: tuple[float, float]
    axle: tuple[float, float]
    radius: tuple[float, float]
    speed: tuple[float, float]
    casters: str
    tyre_width: float


KINDS = (
    Kind("duckie_like", (0.8, 1.5), (0.10, 0.13), (0.030, 0.035), (0.25, 0.55), "ball_behind", 0.25),
    Kind("turtle_like", (1.0, 4.0), (0.16, 0.29), (0.033, 0.036), (0.25, 0.65), "ball_any", 0.2),
    Kind("vacuum_like", (2.5, 4.2), (0.22, 0.27), (0.033, 0.040), (0.25, 0.45), "swivel_ahead", 0.2),
    Kind("kit_three_wheels", (0.8, 1.8), (0.12, 0.18), (0.020, 0.034), (0.25, 0.7), "swivel_behind", 0.3),
    Kind("cart", (7.0, 16.0), (0.32, 0.50), (0.06, 0.10), (0.4, 0.8), "swivel_behind", 0.15),
    Kind("warehouse", (14.0, 30.0), (0.38, 0.60), (0.06, 0.12), (0.4, 0.8), "swivel_both", 0.15),
    Kind("platform", (6.0, 20.0), (0.30, 0.50), (0.05, 0.10), (0.35, 0.7), "ball_corners", 0.15),
)


@dataclass
class Setup:
    """All that a simulated robot is; effects change a copy of it."""

    kind: str
    body: Body
    par: np.ndarray
    sensing: Sensing
    half_area: float
    top: float
    sheet: dict[str, float]
    time_constant: float
    command_delay: float = 0.0
    command_poll: float = 0.0

    def finish(self) -> Setup:
        """Derived parameters (contact stiffness, caster points) after all changes."""
        par, body = self.par, self.body
        par["normal_k"] = engine.contact_stiffness(body, par)
        par["mass"] = body.mass + body.payload
        live = [c for c in body.casters if c.gap == 0.0]
        par["casters"] = len(live)
        for k, c in enumerate(live):
            par["caster_x"][0, k], par["caster_y"][0, k] = c.x, c.y
        return self


def _between(rng: np.random.Generator, pair: tuple[float, float]) -> float:
    return float(math.exp(rng.uniform(math.log(pair[0]), math.log(pair[1]))))


def _caster(rng: np.random.Generator, kind: str, x: float, y: float, radius: float, load: float) -> Caster:
    """One caster with the friction a sound one has; load N."""
    if kind == "ball":
        return Caster("ball", x, y, 0.35 * radius, mu=float(rng.uniform(0.006, 0.02)))
    size = 0.5 * radius
    trail = float(rng.uniform(0.5, 0.9)) * size
    return Caster(
        "swivel",
        x,
        y,
        size,
        trail=trail,
        aside=float(rng.uniform(0.1, 0.2) * rng.choice([-1, 1])) * trail,
        pivot_friction=float(rng.uniform(0.003, 0.015)) * load * trail,
        axle_friction=float(rng.uniform(0.003, 0.01)) * load * size,
    )


def _casters(
    rng: np.random.Generator, kind: Kind, axle: float, radius: float, weight: float
) -> tuple[list[Caster], float]:
    """Casters and the direction (+1 ahead, -1 behind, 0 both) in which the mass must lie."""
    reach = float(rng.uniform(0.42, 0.6)) * max(axle, 0.14)
    load = 0.15 * weight
    if kind.casters == "ball_corners":
        side = 0.35 * axle
        return [
            _caster(rng, "ball", sx * reach, sy * side, radius, load) for sx in (1, -1) for sy in (1, -1)
        ], 0.0
    what, where = kind.casters.split("_")
    if where == "both" or (where == "any" and rng.random() < 0.35):
        return [_caster(rng, what, s * reach, 0.0, radius, load) for s in (1.0, -1.0)], 0.0
    sign = -1.0 if where == "behind" or (where == "any" and rng.random() < 0.6) else 1.0
    main = _caster(rng, what, sign * reach, 0.0, radius, load)
    skid = Caster("ball", -sign * reach, 0.0, 0.35 * radius, mu=0.015, gap=0.0006)
    return [main, skid], sign


def draw(
    rng: np.random.Generator,
    control: str | None = None,
    swivel: bool = False,
    encoders: bool = False,
    ball: bool = False,
) -> Setup:
    """A robot; `control` forces "duty" or "rate", `swivel`/`ball` a caster, `encoders` wheel encoders."""
    while True:
        kind = KINDS[int(rng.integers(len(KINDS)))]
        if not (swivel and kind.casters.startswith("ball")) and not (
            ball and kind.casters.startswith("swivel")
        ):
            break
    mass, axle, radius = (_between(rng, r) for r in (kind.mass, kind.axle, kind.radius))
    top = _between(rng, kind.speed)
    par = blank()
    radii = radius * (1.0 + rng.uniform(-0.004, 0.004, 2))
    par["axle"], par["radius"], par["sink"] = axle, radii, rng.uniform(0.0003, 0.0007)
    par["grip"] = rng.uniform(0.6, 0.95)
    par["zone"] = rng.uniform(0.002, 0.004)
    # m/s2 that both motors give at stall, short of spinning the wheels
    pull = min(rng.uniform(2.2, 5.0), 0.5 * float(par["grip"][0]) * G)
    stall = 0.5 * mass * pull * radius
    par["stall"] = stall * (1.0 + rng.uniform(-0.03, 0.03, 2))
    par["free"] = top / radius * (1.0 + rng.uniform(-0.03, 0.03, 2))
    par["viscous"] = rng.uniform(0.01, 0.04) * stall / (top / radius) * (1.0 + rng.uniform(-0.2, 0.2, 2))
    par["dry"] = rng.uniform(0.002, 0.010) * stall * (1.0 + rng.uniform(-0.2, 0.2, 2))
    par["rolling"] = rng.uniform(0.001, 0.004)
    par["scrub_width"] = rng.uniform(0.3, 1.0) * kind.tyre_width * radius * 2.0
    par["scrub_grip"] = 0.3 * par["grip"]
    wheel_mass = 0.03 * mass
    lump = 0.25 * mass * radius**2
    par["rotor_inertia"] = rng.uniform(0.1, 0.5) * lump
    par["inertia_stick"] = par["rotor_inertia"] + 0.5 * wheel_mass * radius**2 + lump
    par["play_k"] = lump * (0.15 / engine.STEP) ** 2
    par["play_c"] = 0.6 * np.sqrt(0.5 * par["play_k"] * par["rotor_inertia"][:, 0])
    tau = float((2.0 * lump + par["rotor_inertia"][0, 0]) * (top / radius) / stall)
    sheet_rate = top / radius
    control = control or ("rate" if rng.random() < 0.42 else "duty")
    if control == "rate":
        sheet_rate *= rng.uniform(0.7, 0.85)
        top *= 0.78
        par["rate_control"], par["rate_max"] = 1.0, sheet_rate
        par["control_steps"] = (2, 4, 8)[int(rng.integers(3))]
        hz = 1.0 / (par["control_steps"][0] * engine.STEP)  # a count is 1 to 2.5 % of the top rate
        par["counts"] = float(np.round(2.0 * math.pi * hz / (rng.uniform(0.01, 0.025) * sheet_rate)))
        feed = rng.random() < 0.5
        par["kff"] = rng.uniform(0.75, 0.95) if feed else 0.0
        par["kp"] = rng.uniform(0.3, 0.8) if feed else rng.uniform(0.6, 1.5)
        par["ki"] = rng.uniform(2.0, 6.0) if feed else rng.uniform(5.0, 14.0)
        tau = 0.08
    casters, sign = _casters(rng, kind, axle, radius, mass * G)
    ahead = _between(rng, (0.003, 0.025)) * min(1.0, axle / 0.15)
    ahead = float(ahead * (sign if sign else rng.choice([-1.0, 1.0])))
    length = 1.1 * axle
    height = float(rng.uniform(0.2, 0.5)) * axle
    centre = (ahead, float(rng.uniform(-0.004, 0.004)), float(rng.uniform(0.0, 0.06)) * axle)
    body = Body(mass, centre, (length, 0.9 * axle, height), wheel_mass, casters)
    sheet = {
        "wheel_radius": round(radius * (1.0 + _off(rng)), 5),
        "axle_length": round(axle * (1.0 + _off(rng)), 5),
        "max_wheel_rate": round(sheet_rate * (1.0 + _off(rng)), 4),
    }
    return Setup(
        kind.name,
        body,
        par,
        Sensing.draw(rng, encoders),
        float(rng.uniform(1.5, 2.5)),
        float(top),
        sheet,
        max(tau, 0.03),
    ).finish()


def _off(rng: np.random.Generator) -> float:
    """A data sheet's error: 1 to 5 %, either way."""
    return float(rng.uniform(0.01, 0.05) * rng.choice([-1.0, 1.0]))


def describe(setup: Setup) -> dict:
    """The robot of a key entry."""
    p = setup.par[0]
    return {
        "kind": setup.kind,
        "control": "rate" if p["rate_control"] > 0.5 else "duty",
        "mass": setup.body.mass,
        "axle_length": float(p["axle"]),
        "wheel_radius": p["radius"].tolist(),
        "centre_x": setup.body.centre[0],
        "centre_y": setup.body.centre[1],
        "centre_z": setup.body.centre[2],
        "free_rate": p["free"].tolist(),
        "stall_torque_nm": p["stall"].tolist(),
        "rotor_inertia": p["rotor_inertia"].tolist(),
        "rate_max": float(p["rate_max"]),
        "gains": [float(p[k]) for k in ("kff", "kp", "ki")],
        "control_hz": float(1.0 / (p["control_steps"] * engine.STEP)),
        "control_counts": float(p["counts"]),
        "grip": float(p["grip"]),
        "casters": [vars(c).copy() for c in setup.body.casters],
        "half_area": setup.half_area,
        "data_sheet": dict(setup.sheet),
    }


def nuisances(setup: Setup) -> dict:
    """Every unlabelled imperfection with its true value."""
    p = setup.par[0]
    unlike = p["stall"] / p["stall"].mean() - 1.0
    return {
        "centre_of_mass_m": list(setup.body.centre),
        "dry_friction_nm": p["dry"].tolist(),
        "rolling_coefficient": float(p["rolling"]),
        "viscous_nm_s": p["viscous"].tolist(),
        "scrub_width_m": float(p["scrub_width"]),
        "scrub_grip": float(p["scrub_grip"]),
        "stall_unlike": unlike.tolist(),
        "free_unlike": (p["free"] / p["free"].mean() - 1.0).tolist(),
        "radius_unlike": (p["radius"] / p["radius"].mean() - 1.0).tolist(),
        "casters": [
            {"kind": c.kind, "mu": c.mu, "pivot_nm": c.pivot_friction, "axle_nm": c.axle_friction}
            for c in setup.body.casters
            if c.gap == 0.0
        ],
        "creep_zone_m_per_s": float(p["zone"]),
        "tag_m": list(setup.sensing.tag),
        "tag_yaw_rad": setup.sensing.tag_yaw,
        "data_sheet_error": {
            "wheel_radius": setup.sheet["wheel_radius"] / float(p["radius"].mean()) - 1.0,
            "axle_length": setup.sheet["axle_length"] / float(p["axle"]) - 1.0,
        },
    }


def _no_mass_behind(s: Setup) -> None:
    """A tenth stays where one caster needs its load: without any the robot would rock."""
    keep = 0.1 if any(c.gap > 0.0 for c in s.body.casters) else 0.0
    s.body.centre = (keep * s.body.centre[0], 0.0, s.body.centre[2])


def _no_rolling(s: Setup) -> None:
    s.par["dry"] = 0.0
    s.par["rolling"] = 0.0


def _no_caster(s: Setup) -> None:
    for c in s.body.casters:
        c.mu, c.pivot_friction, c.axle_friction = 1e-4, 0.0, 0.0


def _no_viscous(s: Setup) -> None:
    s.par["viscous"] = 0.0


def _no_tag(s: Setup) -> None:
    s.sensing.tag, s.sensing.tag_yaw = (0.0, 0.0), 0.0


def _no_scrub(s: Setup) -> None:
    s.par["scrub_grip"] = 0.0


def _alike(s: Setup) -> None:
    s.par["stall"] = s.par["stall"].mean()


DEPARTURES = {
    "mass_behind": _no_mass_behind,
    "rolling": _no_rolling,
    "caster": _no_caster,
    "viscous": _no_viscous,
    "tag": _no_tag,
    "scrub": _no_scrub,
    "motors_unlike": _alike,
}
