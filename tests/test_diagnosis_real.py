"""Recordings of other forms than commands with poses, and the four real robots (skipped where they are not at hand)."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

import fsm_calib
from fsm_calib.cli import app
from fsm_calib.diagnosis.candidates.hypotheses import shown_by
from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.diagnosis.fitting.base import AXLE_SPREAD, FARTHEST, near, slot_of
from fsm_calib.diagnosis.intake import (
    base_steps,
    chain,
    duration,
    headings,
    outliers,
    stretches,
    take_in,
    thinned,
)
from fsm_calib.diagnosis.replay.kinematics import dead_reckon, sensor_motion
from fsm_calib.diagnosis.replay.prepared import prepare
from fsm_calib.diagnosis.replay.simulator import make_simulator
from fsm_calib.errors import DataError
from fsm_calib.recording import read_recording
from fsm_calib.recording.channels import CommandTrack, PoseTrack, TwistTrack, WheelPair, YawRateTrack
from fsm_calib.recording.recording import Recording, RobotFacts
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

ROOT = Path(fsm_calib.__file__).parent.parent
SHARED = (ROOT / os.environ.get("FSM_CALIB_SHARED", "../shared")).resolve() / "recordings"
real = pytest.mark.skipif(
    not SHARED.is_dir(),
    reason=f"no recordings at {SHARED}: set FSM_CALIB_SHARED to the folder that holds them",
)


def shared(name: str) -> Recording:
    return read_recording(SHARED / f"{name}.recording.yaml")


def without_all_but(*names: str) -> set[str]:
    return set(registry()) - set(names)


def test_displacements_of_a_sensor_become_those_of_the_base() -> None:
    """The way back is `identify`'s own model of the sensor's motion."""
    rng = np.random.default_rng(1)
    d, turn = rng.uniform(-0.1, 0.1, 40), rng.uniform(-1.5, 1.5, 40)
    sensor = np.array([0.03, -0.04, -1.5])
    np.testing.assert_allclose(
        base_steps(sensor_motion(d, turn, sensor), sensor), sensor_motion(d, turn, np.zeros(3)), atol=1e-12
    )


def test_chained_steps_lead_where_dead_reckoning_leads() -> None:
    rng = np.random.default_rng(2)
    d, turn = rng.uniform(-0.1, 0.1, 40), rng.uniform(-1.0, 1.0, 40)
    x, y, theta = dead_reckon(d, turn, (0.0, 0.0, 0.0))
    np.testing.assert_allclose(chain(sensor_motion(d, turn, np.zeros(3))), [x, y, theta], atol=1e-12)


def test_outliers_of_any_column_are_found_and_few_others() -> None:
    rng = np.random.default_rng(3)
    residual = rng.normal(size=(500, 3)) * [0.001, 0.001, 0.01]
    residual[[7, 80], [0, 2]] = 0.2
    found = outliers(residual)
    assert found[[7, 80]].all()
    assert found.sum() <= 3


def test_a_yaw_rate_becomes_headings_without_positions() -> None:
    time = np.arange(0.0, 10.0, 0.1)
    recording = Recording(yaw_rate=YawRateTrack(time, 0.3 * np.cos(time)))
    track = headings(recording)
    assert np.isnan(track.x).all()
    np.testing.assert_allclose(track.theta, 0.3 * np.sin(time), atol=1e-3)


def test_headings_alone_leave_positions_out_of_the_likelihood() -> None:
    prepared = prepare(take_in([skidding(0)]).train[0])
    assert prepared.seen[:, 2].all()
    assert not prepared.seen[:, :2].any()
    assert not prepared.poses.placed


def test_a_long_recording_is_cut_to_stretches_spread_over_it() -> None:
    time = np.arange(0.0, 900.0, 0.05)
    poses = PoseTrack(time, np.cos(time), np.sin(time), time)
    recording = Recording(twist=TwistTrack(time, time * 0 + 0.1, time * 0), pose=poses)
    pieces = stretches(recording, 160.0)
    assert len(pieces) == 4
    assert sum(map(duration, pieces)) == pytest.approx(160.0, abs=1.0)
    assert all(piece.pose.time[0] == pytest.approx(0.0, abs=0.1) for piece in pieces)
    firsts = [float(piece.pose.theta[0]) for piece in pieces]
    assert np.diff(firsts) == pytest.approx([225.0] * 3, abs=0.1)


def test_a_short_recording_stays_whole() -> None:
    time = np.arange(0.0, 100.0, 0.05)
    recording = Recording(pose=PoseTrack(time, time, time, time))
    assert stretches(recording, 160.0) == [recording]


def test_a_fast_tracker_is_thinned() -> None:
    time = np.arange(0.0, 10.0, 0.01)
    recording = thinned(Recording(pose=PoseTrack(time, time, time, time)))
    assert np.median(np.diff(recording.pose.time)) == pytest.approx(0.03)


def test_only_inputs_that_can_show_an_effect_consider_it() -> None:
    effects = [registry()[n] for n in ("motor_deadband", "command_point", "skid_steer")]
    time = np.arange(0.0, 10.0, 0.1)
    pose = PoseTrack(time, 0.1 * time, 0.0 * time, 0.0 * time)
    one = np.ones(len(time))
    inputs = {
        "commands": Recording(command=CommandTrack(time, one, one), pose=pose),
        "twists": Recording(twist=TwistTrack(time, one, one), pose=pose),
        "wheels": Recording(wheel_rate=WheelPair(time, one, one, "rad/s"), pose=pose),
    }
    found = {
        kind: [e.name for e in shown_by(effects, [make_simulator(prepare(r))])] for kind, r in inputs.items()
    }
    assert found == {
        "commands": ["motor_deadband"],
        "twists": ["motor_deadband", "command_point", "skid_steer"],
        "wheels": ["skid_steer"],
    }


def test_a_stated_axle_is_believed_within_bounds() -> None:
    slot = near(slot_of("axle_length"), 0.2, AXLE_SPREAD)
    assert (slot.centre, slot.spread) == (0.2, pytest.approx(0.01))
    assert (slot.low, slot.high) == (
        pytest.approx(0.2 - FARTHEST * 0.01),
        pytest.approx(0.2 + FARTHEST * 0.01),
    )


def skidding(seed: int) -> Recording:
    """Measured wheels and a gyro of a robot that turns half as fast as its track says."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, 40.0, 0.1)
    mean, half = 3.0 + np.sin(0.4 * time), 1.5 * np.sin(0.7 * time + seed)
    rate = 0.165 * 2.0 * half / (0.555 * 2.0)
    return Recording(
        robot=RobotFacts("skidding", wheel_radius=0.165, axle_length=0.555),
        wheel_rate=WheelPair(time, mean - half, mean + half, "rad/s"),
        yaw_rate=YawRateTrack(time, rate + 0.01 * rng.normal(size=len(time))),
    )


def test_skidding_is_found_from_wheels_and_a_gyro_alone() -> None:
    result = diagnose(
        [skidding(1), skidding(2)], without=without_all_but("skid_steer", "tyre_scrub", "clock_drift")
    )
    assert [e.name for e in result.verdict.effects] == ["skid_steer"]
    assert result.verdict.effects[0].parameters["stretch"].value == pytest.approx(1.0, abs=0.2)
    assert np.isnan(result.verdict.train.after.xy_m)


def test_nothing_to_fit_is_refused() -> None:
    with pytest.raises(DataError, match="no recording"):
        diagnose([])


@real
@pytest.mark.slow
def test_the_duckiebots_driver_over_compensates() -> None:
    """A real Duckiebot: not slip, not lag, not the axle.

    One drive asks for more of it than the other: a fiftieth of what it explains is another law in each. Without a noise
    of its late commands that was a twelfth, with the three leaps of its poses in the fit an eighth.
    """
    considered = (
        "motor_deadband",
        "motor_gain_curve",
        "tyre_scrub",
        "command_delay",
        "skid_steer",
        "caster_drag",
    )
    runs = [shared(f"duckiebot-watchtower/{run}") for run in ("b1-run1", "b2-run1")]
    result = diagnose(runs, [shared("duckiebot-watchtower/b2-run5")], without=without_all_but(*considered))
    assert result.decision.outcome == "explained"
    (leads,), support = result.decision.named, result.decision.model.supports[0]
    assert leads.among == ("motor_deadband",)
    assert support.law.moved == pytest.approx(0.02, abs=0.015)
    offset = parameter_table().place("motor_deadband.offset")
    assert result.decision.model.fit.values[0, offset] < -0.3
    proof = result.verdict.holdout
    assert proof.after.theta_rad < 0.1 < 0.5 < proof.before.theta_rad


@real
def test_the_husky_skids() -> None:
    runs = [shared(f"husky-skidsteer/{run}") for run in ("run0", "run1")]
    considered = ("skid_steer", "tyre_scrub", "payload_offset", "observation_delay")
    result = diagnose(runs, [shared("husky-skidsteer/run2")], without=without_all_but(*considered))
    assert [e.name for e in result.verdict.effects] == ["skid_steer"]


@real
@pytest.mark.slow
def test_a_husky_on_a_hard_floor_sticks_and_its_wheels_clock_wanders() -> None:
    """Its gyro turns 0.67 to 0.68 times as fast as its wheels say, and stands still where they turn about."""
    runs = [shared(f"husky-terrains/b-{run}") for run in (1, 2, 3)]
    considered = ("skid_steer", "tyre_scrub", "caster_drag", "observation_delay", "clock_drift")
    result = diagnose(runs, without=without_all_but(*considered))
    assert [e.name for e in result.verdict.effects] == ["skid_steer"]
    found = result.verdict.effects[0].parameters
    assert found["stretch"].value == pytest.approx(1.0 / 0.675 - 1.0, abs=0.08)
    assert 0.02 < found["twist"].value < 0.06
    assert result.verdict.base["axle_length"].value == pytest.approx(0.555, rel=0.02)
    assert sum("clock wanders" in note for note in result.notes) == 3


@real
def test_the_khepera_matches_once_it_is_identified() -> None:
    whole = shared("khepera3/l90")
    result = diagnose(
        [whole.window(0.0, 120.0)], without=without_all_but("skid_steer", "tyre_scrub", "sensor_yaw")
    )
    assert result.verdict.verdict == "match"
    assert any("identified" in note for note in result.notes)


def call(*arguments: object) -> Result:
    return CliRunner().invoke(app, ["diagnose", *map(str, arguments)])


MANIFEST = """format: fsm-calib/recording@1
robot: {name: x}
channels:
  pose: {file: pose.csv, time: t, x: x, y: y, theta: theta}
"""


@pytest.mark.parametrize(
    ("table", "said"),
    [
        (None, "does not exist"),
        ("t,x,y,theta\n", "no rows"),
        ("t,x,y,theta\n0,0,0,0\n1,one,0,0\n", "pose.csv:3"),
        ("t,x,y\n0,0,0\n", "theta"),
        ("", "pose.csv"),
    ],
)
def test_bad_recordings_exit_with_2_one_line_and_no_file(
    tmp_path: Path, table: str | None, said: str
) -> None:
    (tmp_path / "bad.yaml").write_text(MANIFEST)
    if table is not None:
        (tmp_path / "pose.csv").write_text(table)
    result = call(tmp_path / "bad.yaml", "--json", tmp_path / "out.json", "--report", tmp_path / "report")
    message = str(result.exception) if result.exception and not result.stderr else result.stderr
    assert said in message
    assert len(message.strip().splitlines()) == 1
    assert not (tmp_path / "out.json").exists()
    assert not (tmp_path / "report").exists()


def test_a_report_onto_a_file_is_refused_before_the_work(tmp_path: Path) -> None:
    (tmp_path / "report").write_text("mine")
    result = call("whatever.yaml", "--report", tmp_path / "report")
    assert "needs a folder" in (result.stderr or str(result.exception))
    assert (tmp_path / "report").read_text() == "mine"


def test_a_report_named_like_a_page_is_refused_before_the_work(tmp_path: Path) -> None:
    result = call("whatever.yaml", "--report", tmp_path / "drive.html")
    assert result.exit_code == 2
    assert f"Give a folder, such as {tmp_path / 'drive'}" in (result.stderr or str(result.exception))
    assert not (tmp_path / "drive.html").exists()
