"""Small simulated drives for the tests of the diagnosis: poses with white noise of a robot with known physics."""

from dataclasses import replace

import numpy as np

from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.design.foresight import drive_of
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.fitting.fit import Engine
from fsm_calib.diagnosis.proof.gates import DEFAULT_GATES
from fsm_calib.diagnosis.replay.prepared import prepare
from fsm_calib.diagnosis.replay.simulator import make_simulator
from fsm_calib.diagnosis.verdict.decide import Judge
from fsm_calib.diagnosis.verdict.selection import Selector
from fsm_calib.recording.channels import CommandTrack, PoseTrack, WheelPair
from fsm_calib.recording.recording import Recording, RobotFacts
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.observation import predict
from fsm_calib.world2d.parameters import parameter_table, parameters
from fsm_calib.world2d.rollout import Drive, simulate

GAIN_LEFT, GAIN_RIGHT = 0.66, 0.61  # m/s
POSITION_NOISE, HEADING_NOISE = 0.002, 0.006  # m, rad
RATE = 15.0  # Hz
START = (0.1, -0.1, 0.4)  # m, m, rad
FACTS = RobotFacts(name="simulated", wheel_radius=0.0318, axle_length=0.1, max_wheel_rate=20.0)
ENCODER_RATE, TICK = 60.0, 2.0 * np.pi / 1600.0  # Hz, rad


def drive(rng, duration=30.0):
    """Return held commands of many levels, both directions, spins and rests."""
    time, left, right, at = [], [], [], 0.5
    while at < duration:
        u, hold = rng.uniform(0.12, 0.5), rng.uniform(0.5, 1.6)
        pair = [(u, u), (-u, -u), (u, -u), (-u, u), (u, 0.5 * u), (0.5 * u, u)][rng.integers(6)]
        for (a, b), t in ((pair, hold), ((0.0, 0.0), 0.4)):
            time.append(at)
            left.append(a)
            right.append(b)
            at += t
    return Drive(time, left, right)


def robot(**changes):
    """Return the parameters of a robot, changed by full name with `__` for the dot."""
    base = {"gain_left": GAIN_LEFT, "gain_right": GAIN_RIGHT}
    return parameters({**base, **{name.replace("__", "."): value for name, value in changes.items()}})


def fitted_number(fit, name):
    """Return a number of a fit by its full name, with a dot or `__` for it."""
    return float(fit.values[0, parameter_table().place(name.replace("__", "."))])


def speeds(times, levels, grid, **changes):
    """Return the speed [m/s] of a `robot` with `changes` at the times of `grid` on straights at some commands."""
    straights = Drive(np.array(times), levels, levels)
    return simulate(robot(**changes), straights, grid, (0.0, 0.0, 0.0))[:, 3]


def twist_in_an_arc(command, **changes):
    """Return speed ahead, speed to the left [m/s] and yaw rate [rad/s] at the end of a steady arc to the left."""
    stamps = np.arange(0.0, 6.0, 0.02)
    commands = Drive(np.array([0.0]), np.array([0.7 * command]), np.array([command]))
    x, y, theta = predict(robot(**changes), commands, stamps, START).poses[-2:].T
    middle, step = theta.mean(), stamps[1]
    ahead, left = np.diff(x)[0] / step, np.diff(y)[0] / step
    c, s = np.cos(middle), np.sin(middle)
    return c * ahead + s * left, c * left - s * ahead, np.diff(theta)[0] / step


def driven(holds, rng, noise, **changes):
    """Return a recording of a `robot` with `changes` that drives `holds`, its poses with `noise` (3,) [m, m, rad]."""
    planned, end = drive_of(holds)
    stamps = np.arange(0.0, end, 1.0 / RATE)
    poses = predict(robot(**changes), planned, stamps, START).poses
    poses = poses + rng.normal(size=poses.shape) * noise
    command = CommandTrack(planned.time, planned.left, planned.right)
    return Recording(robot=FACTS, command=command, pose=PoseTrack(stamps, *poses.T), source="driven")


def laps(seed=0, duration=40.0, **changes):
    """Return a recording of a `robot` with `changes` in lane following: the sum of its commands is constant."""
    rng = np.random.default_rng(seed)
    steering = 0.12 * rng.normal(size=int(2.0 * duration)).clip(-2.0, 2.0)
    holds = [(0.5, 0.3 + s, 0.3 - s) for s in steering]
    return driven(holds, rng, [POSITION_NOISE, POSITION_NOISE, HEADING_NOISE], **changes)


def recording(seed=0, duration=30.0, noise=1.0, rate=RATE, jitter=0.0, asked=1.0, most=np.inf, **changes):
    """Return a recording of a `robot` with `changes`: poses at `rate` [Hz], commands early or late by `jitter` [s].

    asked : times as large commands; most : share of full command from which on larger ones drive it no faster.
    """
    rng = np.random.default_rng(seed)
    usual = drive(rng, duration)
    commands = Drive(usual.time, asked * usual.left, asked * usual.right)
    stamps = np.arange(0.0, duration, 1.0 / rate)
    late = np.sort(commands.time + jitter * np.random.default_rng((seed, 1)).normal(size=len(commands.time)))
    driven = Drive(late, np.clip(commands.left, -most, most), np.clip(commands.right, -most, most))
    poses = predict(robot(**changes), driven, stamps, START).poses
    poses = poses + noise * rng.normal(size=poses.shape) * [POSITION_NOISE, POSITION_NOISE, HEADING_NOISE]
    return Recording(
        robot=FACTS,
        command=CommandTrack(commands.time, commands.left, commands.right),
        pose=PoseTrack(stamps, *poses.T),
        source=f"drive-{seed}",
    )


def with_encoders(seed, late=0.0, **changes):
    """Return a recording with encoders, the right one `late` [s] behind its wheel."""
    seen = recording(seed, **changes)
    command = seen.command
    times = np.arange(0.2, float(seen.pose.time[-1]) - 0.9, 1.0 / ENCODER_RATE)
    commands = Drive(command.time, command.left, command.right)

    def angles(at):
        found = predict(robot(**changes), commands, seen.pose.time, START, wheel_times=at).wheel_angles
        return TICK * np.round(found / TICK)

    pair = WheelPair(times, angles(times)[:, 0], angles(times - late)[:, 1], resolution=TICK)
    return replace(seen, wheel_angle=pair)


def engine_of(*recordings):
    """Return the engine that fits some recordings."""
    return Engine(tuple(make_simulator(prepare(r)) for r in recordings))


def bank_of(*recordings):
    """Return the bank on the fitted base robot of some recordings."""
    engine = engine_of(*recordings)
    return Bank.on(engine, fit_base(engine))


def selector_on(base, engine, *names):
    """Return what selects among some effects on a base robot."""
    effects = [registry()[name] for name in names]
    return Selector(engine, base, effects, 14.0, 0.02, 4, np.random.default_rng(0))


def judged(names, gates=DEFAULT_GATES, **changes):
    """Return what is decided of two drives of a `robot` with `changes` by a catalogue of `names`."""
    return decided([recording(seed, **changes) for seed in (0, 1)], names, gates)


def decided(recordings, names, gates=DEFAULT_GATES):
    """Return what is decided of some recordings by a catalogue of `names`."""
    effects = [registry()[name] for name in names]
    return Judge(engine_of(*recordings), effects, gates, lambda part: None, np.random.default_rng(0)).decide()
