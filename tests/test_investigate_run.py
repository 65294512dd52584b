"""An investigation from its scenario to its answer, and taken up again where it was killed."""

import dataclasses
import json
import shutil

import numpy as np
import pytest

from fsm_calib.actions.notebook import Notebook
from fsm_calib.commands.investigate import tell
from fsm_calib.commands.run_place import run_directory
from fsm_calib.errors import DataError, InputError
from fsm_calib.perception.camera_files import write_extrinsics, write_intrinsics
from fsm_calib.perception.extrinsics import floor_homography, rectified_matrix
from fsm_calib.perception.fleet_camera import fleet_camera
from fsm_calib.runner.investigation import run as runs
from fsm_calib.runner.investigation.run import investigate
from fsm_calib.runner.investigation.session import Before, area_of, refuse_blind
from fsm_calib.runner.knowledge import teach_files
from fsm_calib.runner.loop import step
from fsm_calib.runner.progress import Silent
from fsm_calib.scenario.models import Scenario
from fsm_calib.scenario.scene import scene_of
from fsm_calib.types import CameraMount

TIMES = ("seconds", "seconds_by_part")


def scenario(budget=22.0, **effects):
    return Scenario.model_validate(
        {
            "name": "hidden",
            "seed": 5,
            "robot": {"source": "nominal", "effects": effects},
            "scene": {"boards": {"placed": ({"board": {}, "x": 3.0, "y": 0.0},)}},
            "investigate": {"budget": budget},
        }
    )


HIDDEN = scenario(tyre_scrub={"moment": 0.02})


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("whole")
    going, result = investigate(HIDDEN, folder)
    return going, result, folder


def untimed(result):
    return {name: value for name, value in result.items() if name not in TIMES}


def test_hidden_effect_is_named_within_the_budget(finished):
    _, result, _ = finished
    assert result["verdict"] == "explained"
    assert [effect["name"] for effect in result["effects"]] == ["tyre_scrub"]
    assert result["robot"]["seconds"] < 30.0


def test_every_drive_says_why_and_what_came_of_it(finished):
    _, result, folder = finished
    assert result["drives"]
    assert all(d["why"] and d["expected"] > 0.3 and d["reached"] > 0.3 for d in result["drives"])
    assert (folder / "drives" / "drive-01" / "recording.yaml").exists()
    assert json.loads((folder / "investigation.json").read_text())["ended"] == result["ended"]


def test_answer_is_printed_with_its_drives(finished, capsys):
    _, result, folder = finished
    tell(result, folder, None)
    said = capsys.readouterr().out
    assert "explained: " in said
    assert all(f"drive {number}: " in said for number in range(1, len(result["drives"]) + 1))


def test_robot_stayed_in_its_area(finished):
    going, _, _ = finished
    trace, area = going.connection.world.truth.trace, going.mind.area
    assert area.clearance(trace[:, 1], trace[:, 2]).min() > -area.margin


def test_what_is_thought_never_touches_the_world(finished):
    going, _, _ = finished
    assert not hasattr(going.bench.robot, "truth")
    assert not hasattr(going.bench.tracker, "world")


def test_killed_investigation_goes_on_to_the_same_answer(finished, tmp_path):
    going = runs.session(HIDDEN, tmp_path, Before(), False, Silent(), runs.design)
    for _ in range(4):
        step(going.run)
    going.run.journal.close()  # the process is gone; what is on the disk stays
    _, result = investigate(HIDDEN, tmp_path, resume=True)
    assert untimed(result) == untimed(finished[1])


def test_walls_and_boards_of_the_drawing_are_obstacles():
    drawn = Scenario.model_validate(
        {
            "name": "walled",
            "scene": {
                "boards": {"placed": ({"board": {}, "x": 3.0, "y": 0.0},)},
                "walls": ({"x0": 0.5, "y0": -0.2, "x1": 0.5, "y1": 0.2},),
            },
        }
    )
    area = area_of(drawn.investigate.build(), scene_of(drawn))
    assert area.clearance(0.48, 0.0) < 0.0 < area.clearance(0.0, 0.0)


def test_directory_of_an_investigation_is_not_written_over(tmp_path):
    (tmp_path / "drives").mkdir()
    with pytest.raises(InputError, match="earlier run"):
        run_directory(tmp_path, None, overwrite=False)
    assert run_directory(tmp_path, None, overwrite=True) == tmp_path


def test_earlier_drives_are_replaced(finished, tmp_path):
    shutil.copytree(finished[2], tmp_path / "old")
    (tmp_path / "old" / "drives" / "drive-99").mkdir()
    investigate(scenario(budget=9.0), tmp_path / "old")
    assert not (tmp_path / "old" / "drives" / "drive-99").exists()


def test_own_camera_over_markers_tells_the_poses_of_a_drive_and_keeps_markers_in_sight(tmp_path):
    own = Scenario.model_validate(
        {
            "name": "own-camera",
            "seed": 4,
            "robot": {"known": {"camera": True}, "start": {"x": -0.9, "y": 0.0, "theta": 2.0}},
            "investigate": {
                "poses": "camera", "centre_x": -0.9, "width": 1.7, "depth": 1.4,
                "command": 0.3, "longest": 8.0, "look_every": 0.2,
            },
        }
    )  # fmt: skip
    going = runs.session(own, tmp_path, Before(), False, Silent(), runs.design)
    for _ in range(3):
        step(going.run)
    going.run.journal.close()
    assert not hasattr(going.bench.tracker, "world")
    recording = going.mind.recordings(going.bench)[0]
    trace = going.connection.world.truth.trace
    begin = going.bench.findings.drives[0].commands[0][0]
    x, y = (np.interp(recording.pose.time + begin, trace[:, 0], trace[:, i]) for i in (1, 2))
    off = np.hypot(recording.pose.x - x, recording.pose.y - y)
    assert len(off) > 20
    assert np.median(off) < 0.004
    path = trace[trace[:, 0] > begin][None, ::2, 1:4]
    assert going.mind.area.sight.enough(path).mean() > 0.95


def test_robot_of_which_nothing_tells_where_it_is_is_refused_before_it_is_connected(tmp_path):
    real = Scenario.model_validate({"name": "real", "robot": {"connect": "ros1", "host": "nowhere"}})
    with pytest.raises(InputError, match="no tracker"):
        refuse_blind(real, Before())
    blind = real.model_copy(update={"investigate": real.investigate.model_copy(update={"poses": "camera"})})
    with pytest.raises(InputError, match="not known"):
        refuse_blind(blind, Before())
    refuse_blind(blind, Before(calibration=tmp_path))


def test_investigation_that_was_killed_after_its_last_event_writes_its_answer(finished, tmp_path):
    shutil.copytree(finished[2], tmp_path / "old")
    (tmp_path / "old" / "investigation.json").unlink()
    _, again = investigate(HIDDEN, tmp_path / "old", resume=True)
    assert untimed(again) == untimed(finished[1])


def test_investigation_is_not_taken_up_with_other_recordings(finished, tmp_path):
    shutil.copytree(finished[2], tmp_path / "old")
    drive = finished[0].mind.recordings(finished[0].bench)[0]
    with pytest.raises(DataError, match="recordings"):
        investigate(HIDDEN, tmp_path / "old", given=[drive], resume=True)


def test_camera_files_of_a_run_tell_where_the_camera_sits(tmp_path):
    camera, mount = fleet_camera(), CameraMount(0.06, 0.004, 0.104, 0.38, 0.02, 0.05)
    write_intrinsics(tmp_path / "calibrations" / "camera_intrinsic" / "bot.yaml", camera, "bot")
    where = tmp_path / "calibrations" / "camera_extrinsic" / "bot.yaml"
    write_extrinsics(where, floor_homography(mount, rectified_matrix(camera)), "2026-01-01")
    notebook = Notebook()
    teach_files(notebook, tmp_path)
    assert dataclasses.astuple(notebook.mount) == pytest.approx(dataclasses.astuple(mount), abs=1e-6)
    assert np.allclose(notebook.camera.matrix, camera.matrix, atol=1e-3)
