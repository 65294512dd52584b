"""What drives can tell: the manoeuvres that they lack, and the effects that look alike without them."""

import dataclasses

import numpy as np
import pytest
from diagnosis_robots import engine_of, recording, robot

from fsm_calib.commands.verdict_lines import summary_lines
from fsm_calib.diagnosis.candidates.hypotheses import catalogue, shown_by
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.proof.gates import DEFAULT_GATES
from fsm_calib.diagnosis.verdict.coverage import Changes, alike, coverage_of
from fsm_calib.recording.channels import CommandTrack, PoseTrack
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.observation import predict
from fsm_calib.world2d.rollout import Drive

TURNS = ("straights in reverse", "spins to the left", "spins to the right", "rests")


def only_ahead(seed, duration=30.0):
    """Return a drive of straights and arcs ahead: no rest, no reverse, no spin."""
    rng, time, left, right, at = np.random.default_rng(seed), [], [], [], 0.2
    while at < duration:
        u = rng.uniform(0.2, 0.4)
        a, b = [(u, u), (u, 0.7 * u), (0.7 * u, u)][rng.integers(3)]
        time, left, right, at = [*time, at], [*left, a], [*right, b], at + rng.uniform(0.8, 1.6)
    usual, stamps = recording(seed, duration), np.arange(0.4, duration, 1.0 / 15.0)
    poses = predict(robot(), Drive(time, left, right), stamps, (0.0, 0.0, 0.0)).poses
    poses = poses + rng.normal(size=poses.shape) * [0.002, 0.002, 0.006]
    return dataclasses.replace(
        usual,
        command=CommandTrack(time, left, right),
        pose=PoseTrack(stamps, *poses.T),
        source=f"ahead-{seed}",
    )


def told(drives):
    engine = engine_of(*drives)
    bank = Bank.on(engine, fit_base(engine))
    effects = shown_by(catalogue(), engine.simulators)
    return coverage_of([s.prepared for s in engine.simulators], bank.prober, effects, DEFAULT_GATES.detect)


@pytest.fixture(scope="module")
def ahead():
    return told([only_ahead(seed) for seed in (0, 1)])


@pytest.fixture(scope="module")
def full():
    return told([recording(seed, 30.0) for seed in (0, 1)])


def test_manoeuvres_that_were_not_driven_are_missing(ahead, full):
    assert set(TURNS) <= set(ahead.lack)
    assert not set(TURNS) & set(full.lack)
    assert "straights forwards" not in ahead.lack


def test_without_rests_and_spins_friction_and_a_dead_zone_look_alike(ahead, full):
    pair = {"coulomb_friction", "motor_deadband"}
    assert any(pair <= set(group) for group in ahead.alike)
    assert not any(pair <= set(group) for group in full.alike)


def test_what_never_happens_is_faint(ahead, full):
    assert "motor_reverse_asymmetry" in ahead.faint
    assert "motor_reverse_asymmetry" not in full.faint


def test_two_delays_look_alike_in_any_drive_without_encoders(ahead, full):
    for drives in (ahead, full):
        assert any({"command_delay", "observation_delay"} <= set(group) for group in drives.alike)


def test_alike_is_what_the_other_can_follow():
    x, y = np.eye(50)[:, :1] * 30.0, np.eye(50)[:, 1:2] * 30.0
    assert alike({"a": Changes(x, x), "b": Changes(2.0 * x, x), "c": Changes(y, y)}) == (("a", "b"),)
    mixed = x + 0.5 * y
    assert alike({"a": Changes(x, x), "b": Changes(mixed, mixed)}) == ()
    assert alike({"a": Changes(x, x), "b": Changes(np.hstack([x, mixed]), x)}) == (("a", "b"),)


def test_the_verdict_tells_it_before_any_name():
    without = [name for name in registry() if name not in ("command_delay", "observation_delay")]
    plain = diagnose([only_ahead(0)], without=without).verdict.as_json()
    assert plain["drives"]["alike"] == [["command_delay", "observation_delay"]]
    line = summary_lines(plain)[1]
    assert "the drives lack straights in reverse" in line
