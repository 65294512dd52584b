"""Identification of real robots, against what their publishers found (recordings lie outside the repository)."""

import json

import numpy as np
import pytest
from recording_samples import shared
from typer.testing import CliRunner

from fsm_calib.cli import app
from fsm_calib.diagnosis.identify.identify import identify
from fsm_calib.recording import read_recording

NAMES = ("wheel_radius_left", "wheel_radius_right", "axle_length", "sensor.x", "sensor.y", "sensor.theta")


def published(name: str, subset: str) -> tuple[np.ndarray, np.ndarray]:
    """Return values and standard deviations of Censi et al. 2013 in the order of NAMES."""
    found = json.loads(shared(f"khepera3/{name}_published_results.json").read_text())[subset]
    values = [
        found["l_diam"] / 2,
        found["r_diam"] / 2,
        *(found[k] for k in ("axle", "l_x", "l_y", "l_theta")),
    ]
    return np.array(values), np.sqrt(np.diag(found["covariance"]))


def khepera(name: str, subset: str):
    recording = read_recording(shared(f"khepera3/{name}.recording.yaml"))
    if subset == "_all":
        return recording
    rows = slice(int(subset[1:]), None, 3)
    return type(recording)(
        recording.robot,
        wheel_rate=recording.wheel_rate.rows(rows),
        displacement=recording.displacement.rows(rows),
    )


@pytest.mark.parametrize("subset", ["_all", "_0", "_1", "_2"])
@pytest.mark.parametrize("name", ["l90", "lmov"])
def test_khepera_agrees_with_the_published_calibration(name, subset):
    found = identify([khepera(name, subset)])
    values, sds = published(name, subset)
    limit = np.maximum(3.0 * sds, 0.002 * np.abs(values))
    ours = np.array([found.value(key) for key in NAMES])
    assert (np.abs(ours - values) <= limit).all()
    assert found.residual["outliers"] > 0.005 * found.residual["rows"]


@pytest.mark.parametrize("name", ["l90", "lmov"])
def test_khepera_subsets_agree_with_each_other_within_our_deviations(name):
    fits = [identify([khepera(name, subset)]).estimates for subset in ("_0", "_1", "_2")]
    for key in NAMES:
        values = np.array([fit[key].value for fit in fits])
        sds = np.array([fit[key].sd for fit in fits])
        assert np.ptp(values) < 4.0 * np.sqrt(2.0) * sds.max()


def test_khepera_deviations_lie_within_a_factor_two_of_the_published_ones():
    for name in ("l90", "lmov"):
        estimates = identify([khepera(name, "_all")]).estimates
        ratio = np.array([estimates[key].sd for key in NAMES]) / published(name, "_all")[1]
        assert ((ratio > 0.5) & (ratio < 2.0)).all()
        assert all(estimates[key].sd_robust < 0.2 * estimates[key].sd for key in NAMES)


def test_lego_positions_are_predicted_within_32_mm():
    found = identify([read_recording(shared("lego-nxt/drive.recording.yaml"))])
    assert found.residual["xy_m"] <= 0.032
    assert found.value("wheel_radius_left") is None
    assert found.value("metres_per_tick_left") == pytest.approx(0.00036, rel=0.05)


def test_labyrinth_positions_are_predicted_within_30_mm_and_wrong_facts_are_said():
    found = identify([read_recording(shared("labyrinth-uwb/drive.recording.yaml"))])
    assert found.residual["xy_m"] <= 0.030
    assert any("signs of both wheel channels are reversed" in note for note in found.notes)
    assert any("stated axle_length of 0.0785 m is wrong" in note for note in found.notes)
    assert found.value("axle_length") == pytest.approx(2.0 * 0.0785, rel=0.03)


def test_husky_turns_as_if_its_axle_were_longer():
    found = identify([read_recording(shared("husky-skidsteer/run1.recording.yaml"))])
    assert found.value("axle_length") is None
    assert any("effective axle" in note for note in found.notes)


@pytest.mark.parametrize("run", [1, 2, 3])
def test_a_husky_that_spins_on_loam_turns_as_fast_as_its_makers_recordings_say(run):
    found = identify([read_recording(shared(f"husky-terrains/a-{run}.recording.yaml"))])
    ratio = found.value("wheel_gain_over_axle_left") * 0.555
    assert ratio == pytest.approx(0.57, abs=0.02)


@pytest.mark.parametrize("run", ["a-2", "a-4"])
def test_a_warthog_that_slides_on_gravel_keeps_the_size_of_its_wheels(run):
    """Its makers' recordings: 0.92 of the wheels' way and 0.58 of their turning, in the middle; wheels of 0.3 m."""
    found = identify([read_recording(shared(f"warthog-floors/{run}.recording.yaml"))])
    for side in ("left", "right"):
        assert found.value(f"wheel_radius_{side}") == pytest.approx(0.3 * 0.92, rel=0.1)
    assert found.value("axle_length") == pytest.approx(1.08 * 0.92 / 0.58, rel=0.1)


def test_a_duckiebot_whose_commands_answer_its_poses_does_not_move_before_it_is_told_to():
    found = identify([read_recording(shared("duckiebot-watchtower/b1-run3.recording.yaml"))])
    assert 0.0 <= found.value("command_delay") < 0.05
    assert 0.1 < found.value("tau_turn") < 0.2


def test_a_few_commands_that_were_not_recorded_do_not_tell_a_delay():
    laps = [
        identify([read_recording(shared(f"duckiebot-watchtower/{run}.recording.yaml"))])
        for run in ("b2-run3", "b2-run5")
    ]
    delays = [lap.value("command_delay") for lap in laps]
    spread = [lap.estimates["command_delay"].sd for lap in laps]
    assert min(spread) > 0.002
    assert abs(delays[0] - delays[1]) < 3.0 * np.hypot(*spread)


def test_command_line_writes_the_contract(tmp_path):
    out = tmp_path / "out.json"
    path = shared("khepera3/l90.recording.yaml")
    answer = CliRunner().invoke(app, ["identify", str(path), "--json", str(out)])
    assert answer.exit_code == 0
    plain = json.loads(out.read_text())
    assert set(plain["wheel_radius_left"]) >= {"value", "sd", "unit"}
    assert set(plain["sensor"]) == {"x", "y", "theta"}
    assert plain["residual"]["xy_m"] < 0.002
