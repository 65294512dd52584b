"""The options of all commands: each value has a word, and none is taken that then does nothing."""

import pytest
import typer
from typer.testing import CliRunner

from fsm_calib.cli import app


def commands(group=None, name=""):
    """Yield every command with its name."""
    group = typer.main.get_command(app) if group is None else group
    for part, command in group.commands.items():
        whole = f"{name} {part}".strip()
        yield from commands(command, whole) if hasattr(command, "commands") else [(whole, command)]


def refused(*arguments: str) -> str:
    ran = CliRunner().invoke(app, arguments)
    assert ran.exit_code == 2
    return ran.stderr


def test_every_value_of_a_command_line_has_a_word_and_a_sentence():
    assert [
        (name, parameter.name)
        for name, command in commands()
        for parameter in command.params
        if not getattr(parameter, "is_flag", False) and not (parameter.metavar and parameter.help)
    ] == []


@pytest.mark.parametrize("option", [("--area", "2x2"), ("--longest", "20")])
def test_what_is_said_of_a_next_drive_that_nobody_asked_for_is_refused(option):
    assert f"{option[0]}: this is of the next drive. Give --plan DIR, too." in refused(
        "diagnose", "x", *option
    )


@pytest.mark.parametrize("option", [("--format", "opencv"), ("--name", "front")])
def test_what_is_said_of_a_cameras_file_that_nobody_asked_for_is_refused(option):
    assert f"{option[0]}: this is of the camera's file. Give --out FILE, too." in refused(
        "calibrate-camera", "x.png", "--board", "9x6", *option
    )


@pytest.mark.parametrize("option", [("--out", "c.yaml"), ("--format", "opencv"), ("--name", "front")])
def test_a_comparison_of_cameras_refuses_what_is_said_of_a_file(option):
    assert f"{option[0]}: a comparison writes no camera. Leave it out." in refused(
        "calibrate-camera", "--compare", "a.yaml", "b.yaml", *option
    )


@pytest.mark.parametrize("option", [("--marker", "0.02"), ("--dictionary", "DICT_5X5_50"), ("--gap", "0.2")])
def test_an_option_of_another_kind_of_board_is_told_to_do_nothing(option):
    said = refused("calibrate-camera", "x.png", "--board", "9x6", *option)
    assert said.startswith(f"{option[0]} does nothing: it is of boards of the kind ")


def test_two_schemas_at_once_are_refused():
    assert "Leave out --study or --recording." in refused("schema", "--study", "--recording")


def test_a_schema_that_cannot_be_written_is_refused(tmp_path):
    assert "no such folder" in refused("schema", "--out", str(tmp_path / "none" / "schema.json"))
