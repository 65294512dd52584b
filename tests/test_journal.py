"""The journal and its checkpoint survive a crash at any byte."""

from __future__ import annotations

import json

import numpy as np
import pytest

from fsm_calib.errors import DataError, InputError
from fsm_calib.journal import Journal, encode, plain, read_checkpoint, read_journal, write_atomically


def test_lines_have_sorted_keys_and_keep_every_digit_of_a_number() -> None:
    assert (
        encode({"b": 0.1 + 0.2, "a": np.float64(1) / 3})
        == b'{"a":0.3333333333333333,"b":0.30000000000000004}\n'
    )


def test_values_become_plain_json() -> None:
    value = {"array": np.arange(2), "nan": float("nan"), "tuple": (1, np.int64(2)), 3: np.True_}
    assert plain(value) == {"array": [0, 1], "nan": None, "tuple": [1, 2], "3": True}


def test_events_are_read_back_as_they_were_written(tmp_path) -> None:
    journal = Journal(tmp_path)
    events = [{"seq": n, "text": "ä\n"} for n in range(3)]
    for event in events:
        journal.append(event)
    journal.close()
    assert list(read_journal(tmp_path / "journal.jsonl")) == events


def test_a_torn_last_line_is_left_out_at_every_byte(tmp_path) -> None:
    path = tmp_path / "journal.jsonl"
    whole = encode({"seq": 0}) + encode({"seq": 1, "x": 0.5})
    first = len(encode({"seq": 0}))
    for length in range(first, len(whole)):
        path.write_bytes(whole[:length])
        assert [event["seq"] for event in read_journal(path)] == [0]


def test_a_damaged_line_in_the_middle_names_its_number(tmp_path) -> None:
    path = tmp_path / "journal.jsonl"
    path.write_bytes(b'{"seq":0}\n{"se\n{"seq":2}\n')
    with pytest.raises(DataError, match=r"journal\.jsonl:2"):
        list(read_journal(path))


def test_resuming_cuts_what_came_after_the_checkpoint(tmp_path) -> None:
    journal = Journal(tmp_path)
    journal.append({"seq": 0})
    journal.checkpoint({"seq": 1})
    journal.append({"seq": 1})
    journal.close()
    state = read_checkpoint(tmp_path)
    assert state is not None
    resumed = Journal(tmp_path, state["journal_length"])
    resumed.append({"seq": "again"})
    resumed.close()
    assert [event["seq"] for event in read_journal(tmp_path / "journal.jsonl")] == [0, "again"]


@pytest.mark.parametrize("durable", [False, True])
def test_an_atomic_write_replaces_the_file_and_leaves_no_other(tmp_path, durable: bool) -> None:
    path = tmp_path / "x.json"
    path.write_bytes(b"old")
    write_atomically(path, b"new", durable=durable)
    assert path.read_bytes() == b"new"
    assert list(tmp_path.iterdir()) == [path]


def test_no_checkpoint_means_start_again_and_no_directory_is_wrong_use(tmp_path) -> None:
    assert read_checkpoint(tmp_path) is None
    with pytest.raises(InputError, match="no such directory"):
        read_checkpoint(tmp_path / "nowhere")


@pytest.mark.parametrize("content", ["{", "[]", json.dumps({"schema": "other"})])
def test_a_damaged_or_foreign_checkpoint_is_refused(tmp_path, content: str) -> None:
    (tmp_path / "checkpoint.json").write_text(content)
    with pytest.raises(DataError, match=r"checkpoint\.json"):
        read_checkpoint(tmp_path)
