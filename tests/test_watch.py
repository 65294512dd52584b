"""The page of a run: what it reads, what it serves, who may stop the robot, and the lit state in a real browser."""

import http.client
import json
import re

import pytest
from browser import needs_browser, page_after_scripts
from ros_rig import DEADLINE

from fsm_calib.commands.run import read_scenario
from fsm_calib.errors import InputError
from fsm_calib.journal import encode
from fsm_calib.shipped import shipped_folder
from fsm_calib.watch.area import write_area
from fsm_calib.watch.follow import Follower
from fsm_calib.watch.server import WatchServer

PATHS = ("between", "focus/watching", "scan/starting", "scan/clockwise/collecting", "wheels/forward", "done")


def event(number, path):
    return {
        "seq": number, "time": 0.5 * number, "phase": path.split("/")[0], "path": path, "dest": path,
        "trigger": "board_seen", "activity": "look", "sentence": f"Sentence {number}.", "cure": "",
        "pose": [0.01 * number, 0.0, 0.0], "board": 0, "evidence": {"wheel_ratio": 0.97} if number == 4 else {},
        "guards": {}, "commands": [],
    }  # fmt: skip


@pytest.fixture
def folder(tmp_path):
    run = tmp_path / "run"
    write_area(run, read_scenario(shipped_folder("scenarios") / "full_calibration.yaml"))
    (run / "journal.jsonl").write_bytes(b"".join(encode(event(n, path)) for n, path in enumerate(PATHS)))
    return run


@pytest.fixture
def server(folder):
    stopped = []
    serving = WatchServer(folder, stop=lambda: stopped.append(True))
    serving.stopped = stopped
    serving.start()
    yield serving
    serving.close()


def ask(server, method, path, **headers):
    link = http.client.HTTPConnection(*server.server_address[:2], timeout=DEADLINE)
    link.request(method, path, headers=headers)
    answer = link.getresponse()
    content = answer.read()
    link.close()
    return answer.status, content


def test_follower_reads_whole_lines_as_they_come(folder) -> None:
    follower, journal = Follower(folder), folder / "journal.jsonl"
    assert [one["path"] for one in follower.read()] == list(PATHS)
    line = encode(event(6, "failed/wall_hit"))
    with journal.open("ab") as file:
        file.write(line[:20])
    assert len(follower.read()) == len(PATHS)
    with journal.open("ab") as file:
        file.write(line[20:])
    assert follower.read()[-1]["path"] == "failed/wall_hit"


def test_follower_begins_anew_with_a_new_run(folder) -> None:
    follower = Follower(folder)
    follower.read()
    (folder / "journal.jsonl").write_bytes(encode(event(0, "between")))
    assert [one["path"] for one in follower.read()] == ["between"]


@pytest.mark.parametrize("line", [b"[1, 2]", b"7", b"{", b"[" * 20_000, b"\xff"])
def test_follower_leaves_out_what_is_no_event(folder, line) -> None:
    before = len(Follower(folder).read())
    with (folder / "journal.jsonl").open("ab") as journal:
        journal.write(line + b"\n")
    (folder / "checkpoint.json").write_bytes(line)
    follower = Follower(folder)
    assert len(follower.read()) == before
    assert follower.pictures() == []


def test_missing_folder_is_refused(tmp_path) -> None:
    with pytest.raises(InputError, match="no such folder"):
        Follower(tmp_path / "nothing")


def test_area_holds_boards_tags_and_road(folder) -> None:
    area = Follower(folder).area()
    kinds = [shape["kind"] for shape in area["shapes"]]
    assert kinds.count("board") == 3
    assert kinds.count("tag") == 99
    assert kinds.count("white") == 2
    assert area["plan"][0] == "focus"


def test_stream_sends_what_is_new_since_the_last_event_seen(server) -> None:
    link = http.client.HTTPConnection(*server.server_address[:2], timeout=DEADLINE)
    link.request("GET", "/stream", headers={"Last-Event-ID": "4"})
    answer = link.getresponse()
    lines = [answer.readline().decode().strip() for _ in range(3)]
    link.close()
    assert lines[:2] == ["id: 6", "event: events"]
    news = json.loads(lines[2].removeprefix("data: "))
    assert [one["path"] for one in news["events"]] == ["wheels/forward", "done"]


def test_stop_needs_the_pages_token(server) -> None:
    assert ask(server, "POST", "/stop")[0] == 403
    assert ask(server, "POST", "/stop", **{"X-Token": "guess"})[0] == 403
    assert not server.stopped
    assert ask(server, "POST", "/stop", **{"X-Token": server.token})[0] == 200
    assert server.stopped == [True]


def test_other_sites_names_for_this_machine_get_nothing(server) -> None:
    assert ask(server, "GET", "/run.json", Host="evil.example")[0] == 403


@pytest.mark.parametrize(
    "path", ["/../journal.jsonl", "/frames/../journal.jsonl", "/diagrams/..%2fscan.svg", "/x"]
)
def test_only_the_pages_files_are_served(server, path) -> None:
    assert ask(server, "GET", path)[0] == 404


def test_diagram_of_every_phase_is_served(server) -> None:
    for phase in json.loads(ask(server, "GET", "/run.json")[1])["plan"]:
        status, content = ask(server, "GET", f"/diagrams/{phase}.svg")
        assert status == 200
        assert b"<svg" in content


@needs_browser
@pytest.mark.parametrize(
    ("number", "lit"), [(1, "watching"), (3, "clockwise__collecting"), (4, "forward"), (5, "done")]
)
def test_lit_state_follows_the_journal(server, tmp_path, number, lit) -> None:
    page = page_after_scripts(f"{server.address}?at={number}", tmp_path)
    assert f'data-state="{PATHS[number]}"' in page
    lit_nodes = re.findall(r'<g [^>]*class="[^"]*\blit\b[^"]*"[^>]*>\s*<title>([^<]*)</title>', page)
    assert lit_nodes == [lit]
    assert f"Sentence {number}." in page
