"""Laws of wheels, caster, tyres and load.

Sources: Borenstein & Feng, UMBmark (1996) (wheels, eccentricity); Pacejka, Tyre and Vehicle Dynamics (slip angle,
turn slip); Wong, Theory of Ground Vehicles (skid moments, M = mu N w / 3); Campion et al. (1996) and Kelly, Mobile
Robotics ch. 4 (casters). Several have a natural cause in a 3-D engine: `setup.pieces` tells it which.
"""

from __future__ import annotations

import numpy as np

from foreign.catalogue import ALL, BODIES, FLAT, PUSHED, Sizes, law, which_wheels
from foreign.planar import FX, FY, MZ
from foreign.setup import Array, Setup, add_mass


def eccentric(setup: Setup, which: str, kind: int, share: float, rng: np.random.Generator) -> float:
    """Make wheels uneven: kind 0 offset hub, 2 oval, 3 bump; `share` of the radius. Returns metres."""
    size = share * setup.body["radius_left"]
    for side in {"left": ["left"], "right": ["right"], "both": ["left", "right"]}[which]:
        values = [0.0, float(rng.uniform(-np.pi, np.pi)), 0.0, 0.0]
        values[kind] = size
        setup.body[f"ecc_{side}"] = tuple(values)
        setup.pieces[f"offset_{side}"] = size
    return size


@law("wheel_eccentricity", "offset_hub", most=6)
def offset_hub(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """The hub sits beside the centre of the wheel."""
    which = which_wheels(rng, 0.3)
    return {"wheels": which, "offset_m": eccentric(setup, which, 0, 0.03 * s, rng)}


@law("wheel_eccentricity", "oval_tyre", BODIES, most=5)
def oval_tyre(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """The tyre is oval: two lobes in a turn."""
    which = which_wheels(rng, 0.3)
    return {"wheels": which, "oval_m": eccentric(setup, which, 2, 0.04 * s, rng)}


@law("wheel_eccentricity", "tape", BODIES, most=4)
def tape(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A strip of tape across the tread."""
    which = which_wheels(rng, 0.3)
    return {"wheels": which, "bump_m": eccentric(setup, which, 3, 0.10 * s, rng)}


@law("caster_drag", "trailing", ("planar", "mujoco", "drake"), most=8)
def trailing(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A trailing wheel with rolling resistance and dry swivel friction; it kicks when the direction changes."""
    arm = abs(setup.body["caster_x"])
    swivel = 0.06 * s * arm
    setup.body.update(caster_rolling=0.05 * s, caster_swivel=swivel)
    setup.pieces.update(swivel_caster=1.0, caster_rub=0.05 * s)
    return {"rolling_share": 0.05 * s, "swivel_m": swivel, "trail_m": 0.22 * arm}


@law("caster_drag", "ball", ALL, most=6)
def ball(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A ball caster slides: Coulomb friction against its velocity."""
    setup.body.update(caster_ball=0.10 * s)
    setup.pieces["caster_friction"] = 0.10 * s
    return {"rolling_share": 0.10 * s}


@law("caster_drag", "gritty", PUSHED, most=6)
def gritty(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A gritty, greasy ball: drag grows with speed."""
    drag = 0.03 * s * setup.weight / setup.speed
    arm = setup.body["caster_x"]

    def act(_: float, state: Array, hook: Array) -> None:
        _x, _y, theta, vx, vy, omega = state
        ux, uy = vx - omega * arm * np.sin(theta), vy + omega * arm * np.cos(theta)
        hook[FX] -= drag * ux
        hook[FY] -= drag * uy
        hook[MZ] -= drag * arm * (-ux * np.sin(theta) + uy * np.cos(theta))

    setup.hooks.append(act)
    return {"viscous_N_s_per_m": drag}


@law("caster_drag", "stuck_swivel", PUSHED, most=8)
def stuck_swivel(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """The fork sticks where it was until the robot has run some way: its wheel is dragged sideways until it has come
    about, and rolls along it meanwhile.
    """
    arm = setup.body["caster_x"]
    force, way = 0.04 * s * setup.weight, 0.5 * abs(arm)
    fork = [0.0, -1.0]  # direction of the fork in the body, last time

    def act(t: float, state: Array, hook: Array) -> None:
        _x, _y, theta, vx, vy, omega = state
        if t < fork[1]:
            fork[0] = 0.0
        fork[1] = t
        along = vx * np.cos(theta) + vy * np.sin(theta)
        side = -vx * np.sin(theta) + vy * np.cos(theta) + omega * arm
        speed = float(np.hypot(along, side))
        wrong = np.angle(np.exp(1j * (np.arctan2(side, along) - fork[0]))) if speed > 1e-3 else 0.0
        fork[0] += wrong * min(1.0, speed * 0.01 / way)
        push = -force * np.sin(wrong) * np.tanh(speed / 0.02)
        roll = -0.3 * force * np.cos(wrong) * np.tanh(speed / 0.02)
        bx = roll * np.cos(fork[0]) - push * np.sin(fork[0])
        by = roll * np.sin(fork[0]) + push * np.cos(fork[0])
        hook[FX] += bx * np.cos(theta) - by * np.sin(theta)
        hook[FY] += bx * np.sin(theta) + by * np.cos(theta)
        hook[MZ] += arm * by

    setup.hooks.append(act)
    return {"swivel_N": force, "settle_m": way, "rolling_share": 0.3 * force / setup.weight}


@law("tyre_scrub", "wide_patch", BODIES, most=8)
def wide_patch(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Wide tyres: each strip across the width has its own slip, so turning scrubs."""
    width = min(0.12 * s * setup.size, 0.9 * setup.size)
    setup.body["patch_width"] = width
    return {"width_m": width}


@law("tyre_scrub", "dry_moment", ALL, most=6)
def dry_moment(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Turn slip of a flat contact: a dry moment of friction times load times a third of the width."""
    arm = 0.02 * s * setup.size
    setup.body["pivot"] = arm
    setup.pieces["torsion_arm"] = arm
    return {"moment_share_m": arm}


@law("tyre_scrub", "viscous_moment", FLAT, most=6)
def viscous_moment(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Rubber treads that creep: a moment that grows with the turn rate."""
    rate = 2 * setup.speed / setup.size
    moment = 0.04 * s * setup.weight * setup.size / rate
    setup.body["swirl"] = moment
    return {"moment_N_m_s": moment}


@law("tyre_scrub", "idle_wheels", PUSHED, most=6)
def idle_wheels(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A second, idle pair of wheels ahead slides sideways in turns (a skid-steered chassis)."""
    arm, share = 0.5 * setup.size, 0.05 * s
    force = share * setup.weight

    def act(_: float, state: Array, hook: Array) -> None:
        side = state[5] * arm
        push = -force * np.tanh(side / 0.02)
        hook[FX] += -push * np.sin(state[2])
        hook[FY] += push * np.cos(state[2])
        hook[MZ] += arm * push

    setup.hooks.append(act)
    return {"arm_m": arm, "friction_share": share}


@law("lateral_slip", "soft_tyre", FLAT, most=15)
def soft_tyre(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Low cornering stiffness: the robot runs at a slip angle in bends."""
    k = 1.0 / (1.0 + s)
    setup.body["lateral"] = k
    return {"lateral_stiffness": k * setup.body["stiffness"]}


@law("lateral_slip", "rollers", FLAT, most=15)
def rollers(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Rims of rollers or a glossy floor: little sideways grip, Coulomb-like."""
    k = 1.0 / (1.0 + 2.0 * s)
    setup.body.update(lateral_grip=k)
    return {"lateral_grip": k * setup.body["friction"]}


@law("lateral_slip", "creep", ALL, most=9)
def creep(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A suspended axle steers by roll: the robot crabs outward, in proportion to lateral acceleration and speed.

    The crab adds to where the robot is seen: d(side)/dt = c v omega.
    """
    c = 0.012 * s

    def sense(track) -> None:
        st = track.states
        along = st[:, 3] * np.cos(st[:, 2]) + st[:, 4] * np.sin(st[:, 2])
        rate = -c * along * st[:, 5]
        dt = np.gradient(track.grid)
        st[:, 0] += np.cumsum(-np.sin(st[:, 2]) * rate * dt)
        st[:, 1] += np.cumsum(np.cos(st[:, 2]) * rate * dt)

    setup.sensing.insert(0, sense)
    return {"creep_s": c}


def load(setup: Setup, s: float, x: float, y: float) -> Sizes:
    """Add a load of 25 % of the robot's mass at (x, y) times s (sizes first, then mass)."""
    mass = 0.25 * setup.body["mass"] * max(1.0, s / 2)
    x, y = x * min(s, 2.0), y * min(s, 2.0)
    add_mass(setup, mass, x, y)
    return {
        "mass_kg": mass,
        "x_m": x,
        "y_m": y,
        "com_x_m": setup.body["com_x"],
        "com_y_m": setup.body["com_y"],
    }


@law("payload_offset", "behind", most=5)
def behind(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A box on the tail."""
    return load(setup, s, -0.45 * setup.size, 0.0)


@law("payload_offset", "ahead", most=5)
def ahead(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A gripper at the nose; the caster loses its load."""
    return load(setup, s, 0.35 * setup.size, 0.0)


@law("payload_offset", "aside", most=5)
def aside(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A battery on one side, a little behind."""
    return load(setup, s, -0.3 * setup.size, float(rng.choice([-1, 1])) * 0.3 * setup.size)
