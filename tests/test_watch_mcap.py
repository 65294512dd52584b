"""A run as an MCAP file: what a viewer reads back is what the journal says; skipped without foxglove-sdk."""

from __future__ import annotations

import io
import json
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from fsm_calib.cli import app
from fsm_calib.errors import InputError
from fsm_calib.journal import read_journal
from fsm_calib.runner.run import run_scenario
from fsm_calib.scenario.load import scenario_from
from fsm_calib.scenario.yaml_source import parse_yaml
from fsm_calib.watch.area import write_area
from fsm_calib.watch.mcap_file import write_mcap

SCENARIO = """
name: short
seed: 4
robot: {source: nominal, known: {camera: true}}
plan: [orientation]
output: {report: false, recording: false, bag: none, frames: 3}
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    scenario, folder = scenario_from(parse_yaml(SCENARIO)), tmp_path_factory.mktemp("mcap") / "run"
    write_area(folder, scenario)
    run_scenario(scenario, folder)
    return folder


def need_foxglove() -> None:
    pytest.importorskip("foxglove", reason="foxglove-sdk is not installed (pip install 'fsm-calib[viz]')")


def test_a_viewer_reads_back_states_poses_frames_and_the_area(run: Path, tmp_path: Path) -> None:
    need_foxglove()
    reader_of = pytest.importorskip("mcap.reader", reason="mcap is not installed").make_reader
    path = tmp_path / "run.mcap"
    written = write_mcap(run, path)
    found: dict[str, list[tuple[str, int, bytes]]] = {}
    for schema, channel, message in reader_of(io.BytesIO(path.read_bytes())).iter_messages():
        found.setdefault(channel.topic, []).append((schema.name, message.log_time, message.data))
    events = list(read_journal(run / "journal.jsonl"))
    assert sum(map(len, found.values())) == written
    assert {topic: rows[0][0] for topic, rows in found.items()} == {
        "/area": "foxglove.SceneUpdate",
        "/camera": "foxglove.CompressedImage",
        "/log": "foxglove.Log",
        "/state": "fsm_calib.State",
        "/tf": "foxglove.FrameTransform",
    }
    states = [json.loads(data) for _, _, data in found["/state"]]
    assert [(s["path"], s["dest"]) for s in states] == [(e["path"], e["dest"]) for e in events]
    assert [time for _, time, _ in found["/state"]] == [round(e["time"] * 1e9) for e in events]
    assert len(found["/tf"]) == len(events)
    assert all(b"\xff\xd8" in data for _, _, data in found["/camera"])


def test_the_command_writes_the_file_and_says_how_much(run: Path, tmp_path: Path) -> None:
    need_foxglove()
    path = tmp_path / "run.mcap"
    said = CliRunner().invoke(app, ["watch", str(run), "--mcap", str(path)])
    assert said.exit_code == 0, said.output
    assert f"messages in {path}" in said.output
    assert path.read_bytes()[1:5] == b"MCAP"


def test_a_file_that_is_there_is_kept(run: Path, tmp_path: Path) -> None:
    need_foxglove()
    path = tmp_path / "run.mcap"
    path.write_bytes(b"mine")
    with pytest.raises(InputError, match="cannot be written"):
        write_mcap(run, path)
    assert path.read_bytes() == b"mine"


def test_without_the_library_the_cure_names_the_extra(
    run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "foxglove", None)
    with pytest.raises(InputError, match=r"fsm-calib\[viz\]"):
        write_mcap(run, tmp_path / "run.mcap")
