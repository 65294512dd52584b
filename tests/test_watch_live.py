"""A run served live to Foxglove: what a viewer receives; skipped without foxglove-sdk and a WebSocket client."""

from __future__ import annotations

import json
import shutil
import struct
import threading
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from typing import Any

import pytest
from ros_rig import DEADLINE

from fsm_calib.errors import InputError
from fsm_calib.runner.run import run_scenario
from fsm_calib.scenario.load import scenario_from
from fsm_calib.scenario.yaml_source import parse_yaml
from fsm_calib.watch.area import write_area
from fsm_calib.watch.live import LiveView

SCENARIO = """
name: short
seed: 4
robot: {source: nominal, known: {camera: true}}
plan: [orientation]
output: {report: false, recording: false, bag: none, frames: 3}
"""
MESSAGE = struct.Struct("<BIQ")
"""Head of a message of the protocol: kind 1, subscription, time [ns]."""


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("foxglove", reason="foxglove-sdk is not installed (pip install 'fsm-calib[viz]')")
    scenario, folder = scenario_from(parse_yaml(SCENARIO)), tmp_path_factory.mktemp("live") / "run"
    write_area(folder, scenario)
    run_scenario(scenario, folder)
    return folder


@contextmanager
def served(folder: Path) -> Iterator[LiveView]:
    ended = threading.Event()
    with closing(LiveView(folder, 0)) as view:
        thread = threading.Thread(target=view.serve, args=(ended,))
        thread.start()
        try:
            yield view
        finally:
            ended.set()
            thread.join()


class Viewer:
    """A client of the protocol that subscribes to every channel."""

    def __init__(self, address: str) -> None:
        client = pytest.importorskip("websockets.sync.client", reason="websockets is not installed")
        self._ended = ExitStack()
        asked = {"subprotocols": ["foxglove.sdk.v1"], "open_timeout": DEADLINE}
        self._link = self._ended.enter_context(client.connect(address, **asked))
        self._topics: dict[int, str] = {}

    def messages(self) -> Iterator[tuple[str, bytes]]:
        """Yield (topic, body) as they come."""
        while True:
            data = self._link.recv(timeout=DEADLINE)
            if isinstance(data, str):
                self._subscribe(json.loads(data))
            elif data[0] == 1:
                _, subscription, _ = MESSAGE.unpack_from(data)
                yield self._topics[subscription], data[MESSAGE.size :]

    def _subscribe(self, said: dict[str, Any]) -> None:
        wanted = {channel["id"]: channel["topic"] for channel in said.get("channels", ())}
        if said["op"] != "advertise" or not wanted:
            return
        self._topics |= wanted
        rows = [{"id": number, "channelId": number} for number in wanted]
        self._link.send(json.dumps({"op": "subscribe", "subscriptions": rows}))

    def close(self) -> None:
        self._ended.close()


def test_a_viewer_that_comes_late_gets_the_area_and_the_present_state(run: Path) -> None:
    last = json.loads((run / "journal.jsonl").read_text().splitlines()[-1])
    with served(run) as view, closing(Viewer(view.address)) as viewer:
        found: dict[str, bytes] = {}
        for topic, body in viewer.messages():
            found[topic] = body
            if {"/area", "/state", "/tf", "/log", "/camera"} <= set(found):
                break
    assert json.loads(found["/state"])["dest"] == last["dest"]


def test_a_viewer_gets_the_events_of_a_run_as_they_are_written(run: Path, tmp_path: Path) -> None:
    growing = tmp_path / "run"
    shutil.copytree(run, growing)
    lines = (run / "journal.jsonl").read_text().splitlines(keepends=True)
    (growing / "journal.jsonl").write_text(lines[0])
    with served(growing) as view, closing(Viewer(view.address)) as viewer:
        states = (json.loads(body) for topic, body in viewer.messages() if topic == "/state")
        next(states)
        with (growing / "journal.jsonl").open("a") as file:
            file.writelines(lines[1:])
        dest = json.loads(lines[-1])["dest"]
        assert any(state["dest"] == dest for state in states)


def test_a_port_that_is_taken_is_refused_with_its_cure(run: Path) -> None:
    with closing(LiveView(run, 0)) as view:
        port = int(view.address.rsplit(":", 1)[1])
        with pytest.raises(InputError, match="port"):
            LiveView(run, port)
