"""What the commands share about files: places are refused early, `-` is standard output."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from fsm_calib.cli import app
from fsm_calib.commands.files import STANDARD_OUTPUT, check_folders, check_places, tell_result, write_file
from fsm_calib.errors import InputError


def test_a_file_in_a_folder_that_does_not_exist_is_refused_with_the_cure(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such folder") as caught:
        check_places(tmp_path / "nowhere" / "result.json")
    assert "nowhere first" in str(caught.value)


def test_a_folder_in_place_of_a_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be written"):
        check_places(None, tmp_path)


def test_a_folder_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="no folder can be made here: Not a directory"):
        check_folders(None, tmp_path / "file" / "answer")


def test_a_folder_that_is_only_checked_is_not_left(tmp_path: Path) -> None:
    (tmp_path / "kept").mkdir()
    check_folders(tmp_path / "kept" / "new" / "newer", tmp_path / "kept")
    assert [path.name for path in tmp_path.rglob("*")] == ["kept"]


@pytest.mark.parametrize("option", ["--report", "--export", "--plan"])
def test_a_diagnosis_refuses_its_folders_before_it_reads_a_recording(tmp_path: Path, option: str) -> None:
    (tmp_path / "file").touch()
    done = CliRunner().invoke(app, ["diagnose", "nothing.yaml", option, str(tmp_path / "file" / "answer")])
    assert done.exit_code == 2
    assert "no folder can be made here" in done.output


def test_standard_output_and_no_file_are_no_places_to_check(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    STANDARD_OUTPUT.mkdir()
    assert check_places(None, STANDARD_OUTPUT) is None


def test_a_write_that_fails_says_which_file_and_why(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be written: Is a directory"):
        write_file(tmp_path, "text")


def test_a_result_is_told_in_words_and_written_as_json(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    tell_result({"value": 1.5}, "one and a half", tmp_path / "result.json")
    assert capsys.readouterr().out == "one and a half\n"
    assert json.loads((tmp_path / "result.json").read_text()) == {"value": 1.5}


def test_a_dash_prints_the_json_alone(capsys: pytest.CaptureFixture[str]) -> None:
    tell_result({"value": 1.5}, "one and a half", STANDARD_OUTPUT)
    assert json.loads(capsys.readouterr().out) == {"value": 1.5}
