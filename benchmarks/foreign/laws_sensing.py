"""Laws of the tracker: when it looked, where the tag sits, which map it uses.

Sources: Olson, AprilTag (2011) and motion-capture makers' notes (latency, exposure); Borenstein & Feng (offsets);
Mills, Computer Network Time Synchronization (clock frequency, wander, slewing); fiducial SLAM practice (a marker that was
surveyed wrongly shifts or turns every pose that is seen by it).
"""

from __future__ import annotations

import numpy as np

from foreign.catalogue import Sizes, law
from foreign.setup import Array, Setup, Track


@law("observation_delay", "constant", most=6)
def constant(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Each pose shows an earlier instant."""
    d = 0.05 * s

    def act(track: Track) -> None:
        track.shown -= d

    setup.sensing.append(act)
    return {"delay_s": d}


@law("observation_delay", "jittered", most=6)
def jittered(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Stamped on arrival: a fixed part and a gamma part."""
    d, seed = 0.04 * s, int(rng.integers(2**31)) + setup.salt

    def act(track: Track) -> None:
        track.shown -= d + np.random.default_rng(seed).gamma(2.0, 0.2 * d, len(track.shown))

    setup.sensing.append(act)
    return {"delay_s": 1.4 * d}


@law("observation_delay", "filtered", most=6)
def filtered(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """The tracker smooths: a first-order filter over what it saw (delay by its time constant)."""
    d = 0.05 * s

    def act(track: Track) -> None:
        dt = float(track.grid[1] - track.grid[0])
        k = 1.0 - np.exp(-dt / d)
        st, low = track.states, track.states[0, :3].copy()
        for i in range(len(st)):
            low += k * (st[i, :3] - low)
            st[i, :3] = low

    setup.sensing.append(act)
    return {"delay_s": d}


@law("sensor_offset", "rigid", most=8)
def offset(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """The tag sits off the axle centre."""
    way, far = float(rng.uniform(-np.pi, np.pi)), 0.10 * s * setup.size
    shift = np.array([far * np.cos(way), far * np.sin(way), 0.0])

    def act(track: Track) -> None:
        track.mount = track.mount + shift

    setup.sensing.append(act)
    return {"x_m": float(shift[0]), "y_m": float(shift[1])}


@law("sensor_offset", "mast", most=8)
def mast(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """The tag sits on a mast that leans as the robot accelerates (a tenth of the offset at 1 m/s2)."""
    way, far = float(rng.uniform(-np.pi, np.pi)), 0.10 * s * setup.size
    shift = np.array([far * np.cos(way), far * np.sin(way), 0.0])

    def act(track: Track) -> None:
        track.mount = track.mount + shift
        st, dt = track.states, float(track.grid[1] - track.grid[0])
        along = st[:, 3] * np.cos(st[:, 2]) + st[:, 4] * np.sin(st[:, 2])
        smooth = np.convolve(along, np.ones(8) / 8, "same")
        lean = -0.1 * far * np.clip(np.gradient(smooth, dt), -2, 2)
        st[:, 0] += lean * np.cos(st[:, 2])
        st[:, 1] += lean * np.sin(st[:, 2])

    setup.sensing.append(act)
    return {"x_m": float(shift[0]), "y_m": float(shift[1])}


@law("sensor_yaw", "glued_askew", most=8)
def yaw(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """The tag is glued askew."""
    angle = float(rng.choice([-1, 1])) * 0.035 * s

    def act(track: Track) -> None:
        track.mount = track.mount + np.array([0.0, 0.0, angle])

    setup.sensing.append(act)
    return {"yaw_rad": angle}


@law("sensor_yaw", "askew_and_tilted", most=8)
def yaw_tilted(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Askew and not level: the seen heading also swings by a sixth of that with the heading."""
    angle, phase = float(rng.choice([-1, 1])) * 0.035 * s, float(rng.uniform(-np.pi, np.pi))

    def act(track: Track) -> None:
        track.mount = track.mount + np.array([0.0, 0.0, angle])

        def swing(_: Array, poses: Array) -> Array:
            poses = poses.copy()
            poses[:, 2] += angle / 6 * np.sin(2 * (poses[:, 2] - phase))
            return poses

        track.after.append(swing)

    setup.sensing.append(act)
    return {"yaw_rad": angle}


@law("clock_drift", "rate", most=10)
def rate(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """The tracker's clock runs at another rate."""
    k = float(rng.choice([-1, 1])) * 0.003 * s

    def act(track: Track) -> None:
        track.shown = track.shown * (1.0 + k)

    setup.sensing.append(act)
    return {"rate": k, "lost_in_60_s": 60 * k}


@law("clock_drift", "wander", most=10)
def wander(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Its crystal warms up: the rate changes while it runs (quadratic error)."""
    k = float(rng.choice([-1, 1])) * 0.003 * s

    def act(track: Track) -> None:
        track.shown = track.shown + k * track.shown * (0.5 + 0.5 * track.shown / 60.0)

    setup.sensing.append(act)
    return {"rate": k, "lost_in_60_s": 60 * k}


@law("clock_drift", "slewed", most=10)
def slewed(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Time service: it drifts, and is set partly back every 20 s."""
    k = float(rng.choice([-1, 1])) * 0.004 * s

    def act(track: Track) -> None:
        t = track.shown
        track.shown = t + k * t - 0.25 * k * 20.0 * np.floor(t / 20.0)

    setup.sensing.append(act)
    return {"rate": 0.75 * k, "lost_in_60_s": 45 * k}


def relocate(setup: Setup, angle: float, dx: float, dy: float) -> None:
    """Poses seen inside the place are turned about the place's centre by `angle` and shifted."""
    place = setup.place
    if place is None:
        return

    def move(_: Array, poses: Array) -> Array:
        out = poses.copy()
        for k, (x, y, theta) in enumerate(poses):
            w = place.inside(x, y)
            a, rx, ry = angle * w, x - place.x, y - place.y
            out[k] = (
                place.x + np.cos(a) * rx - np.sin(a) * ry + dx * w,
                place.y + np.sin(a) * rx + np.cos(a) * ry + dy * w,
                theta + a,
            )
        return out

    setup.sensing.append(lambda track: track.after.append(move))


@law("misplaced_marker", "turned", most=8)
def turned(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A marker was surveyed with a wrong heading: poses by it are turned about it."""
    angle = float(rng.choice([-1, 1])) * 0.05 * s
    relocate(setup, angle, 0.0, 0.0)
    return {"turn_rad": angle}


@law("misplaced_marker", "shifted", most=8)
def shifted(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """A marker was surveyed at a wrong place: poses by it are shifted."""
    way, far = float(rng.uniform(-np.pi, np.pi)), 0.010 * s
    relocate(setup, 0.0, far * np.cos(way), far * np.sin(way))
    return {"dx_m": far * np.cos(way), "dy_m": far * np.sin(way)}


@law("misplaced_marker", "knocked", most=8)
def knocked(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Somebody knocked it: turned and shifted as a rigid body."""
    way, far, angle = float(rng.uniform(-np.pi, np.pi)), 0.008 * s, float(rng.choice([-1, 1])) * 0.035 * s
    relocate(setup, angle, far * np.cos(way), far * np.sin(way))
    return {"turn_rad": angle, "dx_m": far * np.cos(way), "dy_m": far * np.sin(way)}


@law("misplaced_marker", "heading_only", most=8)
def heading_only(setup: Setup, s: float, rng: np.random.Generator) -> Sizes:
    """Position by other markers, heading by the wrong one."""
    angle, place = float(rng.choice([-1, 1])) * 0.05 * s, setup.place

    def move(_: Array, poses: Array) -> Array:
        out = poses.copy()
        out[:, 2] += [angle * place.inside(x, y) if place else 0.0 for x, y, _t in poses]
        return out

    setup.sensing.append(lambda track: track.after.append(move))
    return {"turn_rad": angle}
