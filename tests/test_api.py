"""The functions of the package: what the commands of their names do, without printing."""

import subprocess
import sys

import pytest
from diagnosis_robots import recording

import fsm_calib
from fsm_calib.errors import InputError, UnknownNameError
from fsm_calib.recording.writers import write_recording
from fsm_calib.world2d.effects import registry


def test_package_loads_nothing_heavy_until_a_function_is_asked_for() -> None:
    code = (
        "import sys, fsm_calib; print([m for m in ('numpy', 'cv2', 'numba', 'pymunk') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_diagnosis_of_a_manifest_loads_no_camera(tmp_path) -> None:
    path = write_recording(recording(1, duration=5.0), tmp_path / "drive")
    code = (
        "import sys; from fsm_calib.recording.read import read_recording; import fsm_calib.diagnosis.diagnose;"
        f"read_recording({str(path)!r}); print([m for m in ('cv2', 'fsm_calib.actions') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_every_public_name_is_there_and_documented() -> None:
    for name in fsm_calib.__all__:
        assert getattr(fsm_calib, name).__doc__
        assert name in dir(fsm_calib)
    with pytest.raises(AttributeError):
        fsm_calib.nothing  # noqa: B018


def test_identify_takes_recordings_and_paths_alike(tmp_path) -> None:
    drive = recording(1, duration=25.0)
    path = write_recording(drive, tmp_path / "drive")
    read, given = fsm_calib.identify(path), fsm_calib.identify(drive)
    assert read.json["wheel_gain_left"]["value"] == pytest.approx(
        given.json["wheel_gain_left"]["value"], rel=1e-6
    )
    assert "wheel_gain_left" in given._repr_html_()
    assert str(given).startswith(given.title)


def test_diagnose_names_the_effect_and_writes_its_page(tmp_path) -> None:
    drives = [recording(seed, motor_deadband__offset=0.05) for seed in (1, 2)]
    others = [name for name in registry() if name not in ("motor_deadband", "coulomb_friction")]
    answer = fsm_calib.diagnose(drives, without=others)
    assert [effect["name"] for effect in answer.json["effects"]] == ["motor_deadband"]
    assert "motor_deadband" in answer._repr_html_()
    assert answer.write_report(tmp_path / "page").is_file()
    assert (tmp_path / "page" / "world.yaml").is_file()


def test_world_of_a_shipped_scenario_is_loaded_by_name() -> None:
    assert fsm_calib.load_world("full_calibration").seed == 7


def test_unknown_names_are_refused() -> None:
    with pytest.raises(UnknownNameError):
        fsm_calib.load_world("full_calibraton")
    with pytest.raises(UnknownNameError):
        fsm_calib.calibrate_camera(["x.png"], 9, 6, 0.025, kind="photo")
    with pytest.raises(InputError):
        fsm_calib.read_recording("nowhere")


def test_run_leaves_its_page_and_its_calibration(tmp_path) -> None:
    scenario = tmp_path / "focus.yaml"
    scenario.write_text("name: focus\nplan: [focus]\n")
    run = fsm_calib.run(scenario, tmp_path / "out")
    assert run.json["outcome"] == "done"
    assert (run.directory / "report.html").is_file()
