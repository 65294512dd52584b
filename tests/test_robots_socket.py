"""The socket of a robot: how it is named, and what becomes of a robot that is lost."""

from __future__ import annotations

from pathlib import Path

import pytest

from fsm_calib.errors import EmergencyStopped, InputError, LinkLost, RobotLost
from fsm_calib.journal import read_journal
from fsm_calib.robots.address import RobotAddress, parse_address
from fsm_calib.robots.settings import LinkSettings
from fsm_calib.runner.connecting import address_of, with_robot
from fsm_calib.runner.loop import run_to_end
from fsm_calib.runner.parts import Parts
from fsm_calib.runner.progress import Silent
from fsm_calib.runner.result import result_of
from fsm_calib.runner.session import new_session
from fsm_calib.scenario.load import scenario_from
from fsm_calib.scenario.models import Scenario
from fsm_calib.scenario.yaml_source import parse_yaml


def scenario(robot: str = "{source: nominal, known: {camera: true}}") -> Scenario:
    return scenario_from(parse_yaml(f"name: short\nseed: 4\nrobot: {robot}\nplan: [orientation]\n"))


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("ros1://duckie.local/duckie", RobotAddress("ros1", "duckie.local", 11311, "duckie")),
        ("ros1://10.0.0.7:11411/db_1/", RobotAddress("ros1", "10.0.0.7", 11411, "db_1")),
        ("dtps://duckie.local/duckie", RobotAddress("dtps", "duckie.local", 11511, "duckie")),
    ],
)
def test_an_address_names_protocol_host_port_and_vehicle(text: str, address: RobotAddress) -> None:
    assert parse_address(text) == address
    assert parse_address(str(address)) == address


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("duckie.local", "does not begin with"),
        ("http://duckie.local/duckie", "does not begin with"),
        ("ros1:///duckie", "no host"),
        ("ros1://duckie.local", "no vehicle"),
        ("ros1://duckie.local/my-duckie", "no vehicle"),
        ("ros1://duckie.local:99999/duckie", "ort"),
    ],
)
def test_an_address_that_is_none_is_refused_with_an_example(text: str, problem: str) -> None:
    with pytest.raises(InputError, match=problem) as caught:
        parse_address(text)
    assert "ros1://duckie.local/duckie" in str(caught.value)


def test_a_scenario_of_a_real_robot_needs_its_name_alone() -> None:
    assert str(address_of(scenario("{connect: ros1, name: duckie}"))) == "ros1://duckie.local:11311/duckie"


def test_an_address_on_the_command_line_replaces_the_scenarios_robot() -> None:
    real = with_robot(scenario(), "ros1://10.0.0.7/duckie")
    assert (real.robot.connect, real.robot.name, real.plan) == ("ros1", "duckie", ("orientation",))
    assert str(address_of(real)) == "ros1://10.0.0.7:11311/duckie"


def test_a_watch_that_is_shorter_than_the_repetition_is_refused() -> None:
    with pytest.raises(InputError, match="quiet"):
        LinkSettings(resend=0.3, quiet=0.2)


@pytest.mark.parametrize("kind", [LinkLost, EmergencyStopped])
def test_a_lost_robot_ends_the_run_with_reason_and_cure_in_journal_and_result(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: type[RobotLost]
) -> None:
    session = new_session(scenario(), tmp_path, Parts("start"), Silent())

    def lose(*arguments: object) -> None:
        raise kind("The cable is out", cure="Put it in.")

    monkeypatch.setattr(session.run.robot, "capture", lose)
    run_to_end(session.run)
    last = list(read_journal(tmp_path / "journal.jsonl"))[-1]
    assert (last["dest"], last["sentence"], last["cure"]) == ("aborted", "The cable is out.", "Put it in.")
    result = result_of(session, 0.0, {})
    assert result["outcome"] == "aborted"
    assert result["lost"] == {"name": kind.__name__, "reason": "The cable is out.", "cure": "Put it in."}
