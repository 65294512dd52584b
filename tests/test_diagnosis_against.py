"""A user's simulator beside the real robot: named is what the simulator lacks or has otherwise, nothing else."""

import json

import pytest
from diagnosis_robots import GAIN_LEFT, recording
from typer.testing import CliRunner

from fsm_calib.cli import app
from fsm_calib.diagnosis.against import diagnose_against
from fsm_calib.errors import DataError
from fsm_calib.recording.writers import write_recording
from fsm_calib.world2d.effects import registry

CONSIDERED = ("motor_deadband", "motor_reverse_asymmetry")
WITHOUT = [name for name in registry() if name not in CONSIDERED]
DEADBAND = {"motor_deadband__offset": 0.08}
REVERSE = {"motor_reverse_asymmetry__loss": 0.15}


def drives(*seeds, **effects):
    return [recording(seed, 30.0, **effects) for seed in seeds]


def compared(real, simulated):
    return diagnose_against(drives(1, 2, **real), drives(3, 4, **simulated), without=WITHOUT)


def difference(found, name):
    return next(d for d in found.differences if d.name == name)


def test_what_the_simulator_lacks_is_named_and_what_it_has_is_not():
    found = compared({**DEADBAND, **REVERSE}, DEADBAND)
    told = found.as_json()["against"]
    assert (told["lacks"], told["otherwise"], told["alike"]) == (
        ["motor_reverse_asymmetry"],
        [],
        ["motor_deadband"],
    )
    loss = difference(found, "motor_reverse_asymmetry.loss")
    assert loss.value == pytest.approx(0.15, abs=3 * loss.sd)
    assert loss.z > 5.0


def test_nothing_is_named_between_equal_ones():
    found = compared(DEADBAND, DEADBAND)
    assert found.real.verdict.verdict == "match"
    assert found.as_json()["against"]["alike"] == ["motor_deadband"]
    assert all(abs(d.z) < 4.0 for d in found.differences)


def test_an_effect_of_another_size_is_told_with_the_difference_and_its_interval():
    found = compared(DEADBAND, {"motor_deadband__offset": 0.03})
    assert found.as_json()["against"]["otherwise"] == ["motor_deadband"]
    offset = difference(found, "motor_deadband.offset")
    assert offset.value == pytest.approx(0.05, abs=3 * offset.sd)
    assert offset.z == pytest.approx(offset.value / offset.sd)


def test_a_weaker_real_motor_is_a_difference_of_the_base():
    found = compared({"gain_left": 0.9 * GAIN_LEFT}, {})
    assert found.real.verdict.verdict == "match"
    assert difference(found, "gain_left").value == pytest.approx(-0.1 * GAIN_LEFT, rel=0.1)
    assert difference(found, "gain_left").z < -5.0


def test_no_simulated_recording_is_refused():
    with pytest.raises(DataError, match="no simulated recording"):
        diagnose_against(drives(1), [])


def test_the_command_says_it_in_words_and_as_json(tmp_path):
    real, simulated = (
        str(write_recording(one, tmp_path / name))
        for one, name in ((*drives(1, **DEADBAND), "real"), (*drives(3), "simulated"))
    )
    hidden = [text for name in WITHOUT for text in ("--without", name)]
    out = tmp_path / "verdict.json"
    answer = CliRunner().invoke(app, ["diagnose", real, "--against", simulated, "--json", str(out), *hidden])
    assert answer.exit_code == 0, answer.output
    assert "the simulator lacks: motor_deadband" in answer.output
    told = json.loads(out.read_text())
    assert [effect["name"] for effect in told["effects"]] == ["motor_deadband"]
    assert told["against"]["differences"][0]["name"] == "motor_deadband.offset"


def test_a_world_and_a_simulator_at_once_are_refused(tmp_path):
    world = tmp_path / "world.yaml"
    world.write_text("name: mine\n")
    answer = CliRunner().invoke(app, ["diagnose", "a", "--against", "b", "--world", str(world)])
    assert answer.exit_code == 2
    assert "--against" in answer.output
