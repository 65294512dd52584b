"""The campaign of runs sees what is planted: other files, an unexpected code, words that are no sentence, a hang."""

import importlib.util
import os
import random
import signal
import sys
import time
from pathlib import Path

import pytest
from recording_samples import ROOT

from fsm_calib.journal import CHECKPOINT_NAME, JOURNAL_NAME, Journal, read_checkpoint

sys.path.insert(0, str(ROOT / "benchmarks"))
_spec = importlib.util.spec_from_file_location("campaign_runs", ROOT / "benchmarks" / "campaign_runs.py")
campaign_runs = importlib.util.module_from_spec(_spec)
sys.modules["campaign_runs"] = campaign_runs
_spec.loader.exec_module(campaign_runs)
import campaign_hazards  # noqa: E402 - beside the benchmark
from campaign_case import Case, Wrong  # noqa: E402
from campaign_children import Child, Hang, started  # noqa: E402
from campaign_faults import expect_named, spans_of, state_at  # noqa: E402
from campaign_hazards import expect_equal, expect_sentence  # noqa: E402


def ended(folder: Path, code: int, said: str) -> Child:
    (folder / "stderr").write_text(said)
    return Child(0, folder, code)


def test_a_sentence_with_its_exit_code_is_right(tmp_path: Path) -> None:
    expect_sentence(ended(tmp_path, 1, "a bar\nfsm-calib: the disk is full.\n"), (0, 1))


@pytest.mark.parametrize(
    ("code", "said"),
    [
        (3, "fsm-calib: no.\n"),
        (1, "Traceback (most recent call last)\nfsm-calib: no.\n"),
        (1, ""),
        (1, "fsm-calib: \x1b[2J\n"),
        (1, f"fsm-calib: {'x' * 2000}\n"),
        (-9, ""),
    ],
)
def test_another_code_a_traceback_and_no_readable_sentence_are_wrong(
    tmp_path: Path, code: int, said: str
) -> None:
    with pytest.raises(Wrong):
        expect_sentence(ended(tmp_path, code, said), (0, 1))


@pytest.fixture
def alike(tmp_path: Path) -> tuple[Path, Path]:
    for name in ("one", "other"):
        folder = tmp_path / name
        (folder / "frames").mkdir(parents=True)
        (folder / "frames" / "a.jpg").write_bytes(b"picture")
        (folder / "report.html").write_text(name)
        (folder / "result.json").write_text(f'{{"seconds": {{"wall": {len(name)}, "simulated": 2}}}}')
    return tmp_path / "one", tmp_path / "other"


def test_runs_that_differ_in_the_computers_time_alone_are_equal(alike: tuple[Path, Path]) -> None:
    expect_equal(*alike)


@pytest.mark.parametrize("change", ["frames/a.jpg", "result.json", "frames/b.jpg"])
def test_another_missing_or_new_file_is_wrong(alike: tuple[Path, Path], change: str) -> None:
    (alike[0] / change).write_text('{"seconds": {"simulated": 3}}')
    with pytest.raises(Wrong, match=change):
        expect_equal(*alike)


def test_a_child_hands_on_its_code_and_what_it_says(tmp_path: Path) -> None:
    child = started(lambda: 7 if os.write(2, b"so it is\n") else 0, tmp_path).wait()
    assert (child.code, child.stderr()) == (7, "so it is\n")


def test_a_child_that_does_not_end_is_a_hang(tmp_path: Path) -> None:
    child = started(lambda: time.sleep(60) or 0, tmp_path)
    with pytest.raises(Hang):
        child.wait(0.2)
    assert child.code is None or child.code == -signal.SIGKILL


def test_a_case_that_is_not_right_is_kept_with_its_plan_and_not_judged_twice(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def planted(case: Case) -> None:
        case.choose(number=case.rng.random())
        (case.folder / "trace").write_text("what happened")
        raise Wrong("planted")

    monkeypatch.setitem(campaign_hazards.HAZARDS, "kill", planted)
    first = campaign_runs.Campaign(tmp_path, 3)
    first.add(first.judge("kill", first.next_case("kill")))
    again = campaign_runs.Campaign(tmp_path, 3)
    assert again.next_case("kill") == 1
    assert again.rows[0]["plan"] == {"number": random.Random("3/kill/0").random()}
    assert (tmp_path / "repro" / "kill-0" / "trace").read_text() == "what happened"
    assert "planted" in (tmp_path / "report.md").read_text()
    with pytest.raises(SystemExit, match="another seed"):
        campaign_runs.Campaign(tmp_path, 4)


def test_damage_that_is_gone_on_with_is_seen(tmp_path: Path) -> None:
    journal = Journal(tmp_path)
    for number in range(3):
        journal.append({"seq": number})
        journal.checkpoint({"sequence": number + 1})
    journal.close()
    sound = campaign_hazards.taken_up(tmp_path)
    whole = (tmp_path / JOURNAL_NAME).read_bytes()
    assert sound == (read_checkpoint(tmp_path), whole)
    (tmp_path / JOURNAL_NAME).write_bytes(whole + b"{")
    assert campaign_hazards.taken_up(tmp_path) == sound
    (tmp_path / JOURNAL_NAME).write_bytes(whole.replace(b"1", b"2", 1))
    assert campaign_hazards.taken_up(tmp_path) is None
    (tmp_path / CHECKPOINT_NAME).unlink()
    assert campaign_hazards.taken_up(tmp_path) == ({}, b"")


def test_a_file_is_cut_at_every_byte_and_loses_single_bits() -> None:
    harmed = list(campaign_hazards.damaged(b"abc", random.Random(1)))
    assert harmed[:3] == [b"", b"a", b"ab"]
    assert len(harmed) == 3 + campaign_hazards.FLIPS
    bits = {int.from_bytes(one, "big") ^ int.from_bytes(b"abc", "big") for one in harmed[3:]}
    assert bits == {1 << bit for bit in range(24)}


def test_kinds_take_turns_until_each_has_had_its_cases(tmp_path: Path) -> None:
    campaign = campaign_runs.Campaign(tmp_path, 3)
    taken = []
    for kind in campaign.turns(["kill", "place"], 2):
        taken.append(kind)
        campaign.rows.append({"kind": kind})
    assert taken == ["kill", "place", "kill", "place"]


def test_the_state_in_which_a_fault_began_is_read_from_the_journal(tmp_path: Path) -> None:
    journal = Journal(tmp_path)
    for path, moment in (("a", 2.0), ("b", 2.0), ("c/d", 5.0)):
        journal.append({"path": path, "time": moment, "pose": [moment, 0.0, 0.0]})
    journal.close()
    spans = spans_of(tmp_path)
    assert [(span.state, span.begin, span.end, span.pose[0]) for span in spans] == [
        ("a", 0.0, 2.0, 0.0),
        ("c/d", 2.0, 5.0, 2.0),
    ]
    assert [state_at(spans, moment) for moment in (1.9, 2.0, 5.0)] == ["a", "c/d", ""]


DONE = {
    "outcome": "done",
    "failure": None,
    "last_command": [0.0, 0.0],
    "seconds": {"simulated": 300.0},
    "camera": {"true_px": 0.3, "predicted_px": 0.25},
    "wheels": {"deviation_2m_m": -0.02},
    "in_lane": {"deviation_before_m": 0.5, "deviation_after_m": -0.12},
}
NAMED = {"name": "wall_hit", "reason": "It stands.", "cure": "Move it."}


@pytest.mark.parametrize("row", [DONE, DONE | {"outcome": "failed", "failure": NAMED, "wheels": None}])
def test_a_good_result_and_a_named_failure_are_right(row: dict) -> None:
    expect_named(row)


@pytest.mark.parametrize(
    ("change", "found"),
    [
        ({"last_command": [0.1, 0.0]}, "wheels at"),
        ({"seconds": {"simulated": 1000.0}}, "1000 s"),
        ({"outcome": "failed"}, "without a name"),
        ({"outcome": "failed", "failure": NAMED | {"cure": " "}}, "without a name"),
        ({"camera": {"true_px": 0.6, "predicted_px": 0.25}}, "camera"),
        ({"wheels": {"deviation_2m_m": -0.2}}, "off after 2 m"),
        ({"in_lane": {"deviation_before_m": 0.02, "deviation_after_m": -0.12}}, "what the lane told"),
    ],
)
def test_a_wrong_end_of_a_run_with_faults_is_seen(change: dict, found: str) -> None:
    with pytest.raises(Wrong, match=found):
        expect_named(DONE | change)
