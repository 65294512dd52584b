"""A mismatch without a name must show in the poses."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_robots import recording, with_encoders

from fsm_calib.diagnosis.candidates.hypotheses import catalogue, shown_by
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.fitting.fit import Engine
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.diagnosis.proof.gates import DEFAULT_GATES
from fsm_calib.diagnosis.proof.in_poses import InPoses, without_encoders
from fsm_calib.diagnosis.replay.prepared import prepare
from fsm_calib.diagnosis.replay.simulator import make_simulator
from fsm_calib.diagnosis.verdict.decide import decide
from fsm_calib.world2d.effects import registry


def simulators(*recordings):
    return tuple(make_simulator(prepare(r)) for r in recordings)


@pytest.fixture(scope="module")
def late_encoder():
    return simulators(*(with_encoders(seed, late=0.03) for seed in (0, 1)))


def test_an_encoder_that_is_late_is_not_shown_in_the_poses(late_encoder):
    assert not InPoses(late_encoder, DEFAULT_GATES).show()


def test_a_limit_of_the_command_is_shown_in_the_poses():
    limited = simulators(*(with_encoders(seed, command_saturation__limit=0.3) for seed in (0, 1)))
    assert InPoses(limited, DEFAULT_GATES).show()


def test_recordings_of_poses_alone_have_been_judged_already():
    assert InPoses(simulators(recording(0)), DEFAULT_GATES).show()


def test_headings_without_positions_cannot_be_asked_alone(late_encoder):
    unplaced = [
        replace(s, prepared=replace(s.prepared, poses=replace(s.prepared.poses, placed=False)))
        for s in late_encoder
    ]
    assert InPoses(unplaced, DEFAULT_GATES).show()


def test_headings_alone_show_no_place_and_nothing_that_only_drives_forward(late_encoder):
    unplaced = [
        replace(s, prepared=replace(s.prepared, poses=replace(s.prepared.poses, placed=False)))
        for s in late_encoder
    ]
    every, shown = ({e.name for e in shown_by(catalogue(), s)} for s in (late_encoder, unplaced))
    assert {"tyre_scrub", "wheel_eccentricity", "observation_delay"} <= shown
    assert {"carpet_nap", "lateral_slip", "rough_floor_patch", "misplaced_marker"} <= every - shown


def test_a_replay_without_encoders_keeps_its_poses(late_encoder):
    (before, after) = (late_encoder[0].prepared, without_encoders(late_encoder[0]).prepared)
    assert before.has_encoders
    assert not after.has_encoders
    np.testing.assert_array_equal(before.seen[:, :3], after.seen[:, :3])


@pytest.mark.parametrize(
    "asked",
    [
        ("motor_deadband", "tyre_scrub"),  # none of them explains it
        ("motor_deadband", "gear_backlash", "motor_asymmetric_lag"),  # one of them stands in
    ],
)
def test_what_the_encoders_alone_see_is_a_match_whatever_explains_it(late_encoder, asked):
    decision = decide(late_encoder[:1], without=registry().keys() - asked)
    assert decision.outcome == "match"
    assert "the encoders alone differ" in decision.reason
    assert decision.model.effects == ()


def played(replays, gap):
    """A fit of an effect of this size to these replays, as far as the poses are asked of it."""
    engine = Engine(replays)
    base = fit_base(engine)
    return replace(base, values=with_values(base.values, {"gear_backlash.gap": gap}))


@pytest.mark.parametrize(
    ("gap", "denied"), [(0.3, True), (0.001, False)], ids=["seen", "too small to be seen"]
)
def test_poses_of_a_robot_without_play_deny_one_that_they_would_see(late_encoder, gap, denied):
    assert InPoses(late_encoder, DEFAULT_GATES).deny(played(late_encoder, gap), "gear_backlash") is denied


def test_poses_of_a_robot_with_play_do_not_deny_it():
    replays = simulators(*(with_encoders(seed, gear_backlash__gap=0.3) for seed in (0, 1)))
    assert not InPoses(replays, DEFAULT_GATES).deny(played(replays, 0.3), "gear_backlash")


def test_poses_of_a_robot_with_play_speak_for_it():
    replays = simulators(*(with_encoders(seed, gear_backlash__gap=0.3) for seed in (0, 1)))
    assert InPoses(replays, DEFAULT_GATES).affirm(played(replays, 0.3), "gear_backlash")


@pytest.mark.parametrize("gap", [0.3, 0.001], ids=["they would see it", "too small to be seen"])
def test_poses_of_a_robot_without_play_speak_for_none(late_encoder, gap):
    assert not InPoses(late_encoder, DEFAULT_GATES).affirm(played(late_encoder, gap), "gear_backlash")


def test_poses_that_cannot_be_asked_alone_deny_nothing_and_speak_for_nothing():
    replays = simulators(recording(0))
    poses = InPoses(replays, DEFAULT_GATES)
    assert not poses.deny(played(replays, 0.3), "gear_backlash")
    assert not poses.affirm(played(replays, 0.3), "gear_backlash")


def test_a_slippery_spot_is_not_denied_where_a_low_grip_had_stood_in_for_it_everywhere():
    spot = {"loss": 0.8, "x": 0.3, "y": 0.0, "radius": 0.25}
    slips = {f"low_friction_patch__{k}": v for k, v in spot.items()}
    replays = simulators(*(with_encoders(seed, **slips) for seed in (0, 1)))
    base = fit_base(Engine(replays))
    named = replace(
        base, values=with_values(base.values, {f"low_friction_patch.{k}": v for k, v in spot.items()})
    )
    poses = InPoses(replays, DEFAULT_GATES)
    sliding = with_values(base.values, {"friction": 0.15})
    poses.__dict__["_base"] = replace(poses._base, values=sliding)  # where the fit of poses alone may end
    assert not poses.deny(named, "low_friction_patch")
