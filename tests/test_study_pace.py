"""What a study says of the time that is left, before any robot has ended."""

import io
import json

import pytest
from rich.console import Console

from fsm_calib.progress.fleet import FleetBar, studied_name
from fsm_calib.study.pace import TYPICAL, Pace, Work, stages_of

ALL = ("by_hand", "test_1", "test_2")
WHOLE = sum(TYPICAL.values())


def works(tmp_path, count=4):
    return {i: Work(f"base-robot-{i}", ALL, tmp_path / str(i)) for i in range(count)}


def begin(work, *ended):
    """Lay down what a worker leaves that has begun with a robot and ended some of its stages."""
    work.folder.mkdir()
    (work.folder / "starts").write_bytes(b".")
    for stage in ended:
        (work.folder / f"{stage}.json").write_text(json.dumps({"result": {}, "cost": {"wall": 1.0}}))


def test_time_left_is_told_before_anything_has_begun(tmp_path):
    pace = Pace(works(tmp_path), (), workers=2)
    assert pace.seconds_left() == pytest.approx(4 * WHOLE / 2)
    assert pace.sentence() == "about 52 s left"


def test_every_stage_that_ends_shortens_what_is_left_and_the_stage_at_work_is_named(tmp_path):
    left = works(tmp_path, 1)
    pace = Pace(left, (), workers=2)
    begin(left[0], "by_hand")
    assert pace.seconds_left() == pytest.approx(TYPICAL["test_1"] + TYPICAL["test_2"], abs=1.0)
    assert "base-robot-0 test_1" in pace.sentence()


def test_the_pace_is_learnt_from_the_robots_that_ended(tmp_path):
    slow = {"cost": {stage: {"wall": 100.0} for stage in ALL}}
    pace = Pace(works(tmp_path, 3), (), workers=1)
    pace.ended(0, slow)
    assert pace.seconds_left() == pytest.approx(600.0)
    assert "10 min left" in pace.sentence()
    assert Pace(works(tmp_path, 1), [slow], workers=1).seconds_left() == pytest.approx(300.0)


def test_a_robot_whose_folder_is_gone_is_no_error(tmp_path):
    left = works(tmp_path, 1)
    begin(left[0], *ALL)
    assert Pace(left, (), workers=1).under_way() == []


def test_the_stages_are_those_of_the_trial():
    assert stages_of(("test_1",), "base") == ("by_hand", "test_1")
    assert stages_of(ALL, "no-sharpness") == ("test_2",)


def test_the_bar_says_it_at_once(tmp_path):
    out = io.StringIO()
    with FleetBar(studied_name, Console(file=out, width=120)) as bar:
        bar.begin(0, 4, 2, Pace(works(tmp_path), (), workers=2))
        bar.row({"robot": 1, "variant": "base", "error": {"name": "DataError", "reason": "no wheels"}})
    first, second = out.getvalue().splitlines()
    assert first == "0 of 4 robots are there; 2 at a time; about 52 s left"
    assert second.endswith("DataError: no wheels")
