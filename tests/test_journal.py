"""The journal and its checkpoint survive a crash at any byte."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest

from fsm_calib.errors import DataError, InputError
from fsm_calib.journal import (
    CHECKPOINT_NAME,
    JOURNAL_NAME,
    PREVIOUS_NAME,
    Journal,
    encode,
    plain,
    read_checkpoint,
    read_journal,
    write_atomically,
)
from fsm_calib.sealed import sealed


def small_run(directory: Path) -> bytes:
    """Leave a journal of four events with its checkpoints in a directory; return the journal."""
    journal = Journal(directory)
    for n in range(4):
        journal.append({"seq": n, "commands": [[0.1 * n, 0.3, -0.25]], "sentence": "ä board is in sight"})
        journal.checkpoint({"sequence": n + 1, "bench": {"quiet": 0.125, "side": "left"}})
    journal.close()
    return (directory / JOURNAL_NAME).read_bytes()


def refused(directory: Path) -> bool:
    """Tell whether a run is not gone on with, for a reason that names file and cure."""
    try:
        read_checkpoint(directory)
    except DataError as error:
        return directory.name in str(error) and (
            "Start again" in str(error) or "Or start again" in str(error)
        )
    return False


def test_lines_have_sorted_keys_and_keep_every_digit_of_a_number() -> None:
    assert (
        encode({"b": 0.1 + 0.2, "a": np.float64(1) / 3})
        == b'{"a":0.3333333333333333,"b":0.30000000000000004}\n'
    )


def test_values_become_plain_json() -> None:
    value = {"array": np.arange(2), "nan": float("nan"), "tuple": (1, np.int64(2)), 3: np.True_}
    assert plain(value) == {"array": [0, 1], "nan": None, "tuple": [1, 2], "3": True}


def test_finite_numbers_stay_what_they_are() -> None:
    assert plain({"a": 0.5, "b": [np.float64(0.25), -2]}) == {"a": 0.5, "b": [0.25, -2]}


def test_the_event_before_is_kept_where_the_file_system_has_no_links(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_links(*paths: Path) -> None:
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr("fsm_calib.journal.os.link", no_links)
    small_run(tmp_path)
    (tmp_path / PREVIOUS_NAME).replace(tmp_path / CHECKPOINT_NAME)
    state = read_checkpoint(tmp_path)
    assert state is not None
    assert state["sequence"] == 3


def test_events_are_read_back_as_they_were_written(tmp_path) -> None:
    journal = Journal(tmp_path)
    events = [{"seq": n, "text": "ä\n"} for n in range(3)]
    for event in events:
        journal.append(event)
    journal.close()
    assert list(read_journal(tmp_path / "journal.jsonl")) == events


def test_a_torn_last_line_is_left_out_at_every_byte(tmp_path) -> None:
    path = tmp_path / "journal.jsonl"
    one, chain = sealed(encode({"seq": 0}))
    whole, first = one + sealed(encode({"seq": 1, "x": 0.5}), chain)[0], len(one)
    for length in range(first, len(whole)):
        path.write_bytes(whole[:length])
        assert [event["seq"] for event in read_journal(path)] == [0]


def test_a_damaged_line_in_the_middle_names_its_number(tmp_path) -> None:
    path = tmp_path / "journal.jsonl"
    lines = small_run(tmp_path).splitlines(keepends=True)
    path.write_bytes(lines[0] + b'{"se\n' + lines[2])
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
    resumed = Journal(tmp_path, state["journal_length"], state["journal_chain"])
    resumed.append({"seq": "again"})
    resumed.close()
    assert [event["seq"] for event in read_journal(tmp_path / "journal.jsonl")] == [0, "again"]


def names_in(directory: Path) -> list[str]:
    return sorted(path.name for path in directory.iterdir())


def test_a_kill_before_the_checkpoint_took_its_name_leaves_no_file_behind(tmp_path) -> None:
    Journal(tmp_path).checkpoint({"event": 1})
    os.link(tmp_path / CHECKPOINT_NAME, tmp_path / PREVIOUS_NAME)  # kept as the one before, then killed
    Journal(tmp_path).checkpoint({"event": 1})
    assert names_in(tmp_path) == sorted([CHECKPOINT_NAME, PREVIOUS_NAME, JOURNAL_NAME])


def test_what_a_killed_process_was_writing_goes_when_the_run_goes_on(tmp_path) -> None:
    for name in (CHECKPOINT_NAME, PREVIOUS_NAME):
        (tmp_path / f".{name}.tmp").write_text("half a")
    Journal(tmp_path).close()
    assert names_in(tmp_path) == [JOURNAL_NAME]


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


@pytest.mark.parametrize("name", [JOURNAL_NAME, CHECKPOINT_NAME])
def test_a_run_whose_file_was_cut_at_any_byte_is_not_gone_on_with(tmp_path, name: str) -> None:
    small_run(tmp_path)
    whole = (tmp_path / name).read_bytes()
    for length in range(len(whole)):
        (tmp_path / name).write_bytes(whole[:length])
        assert refused(tmp_path), length
    (tmp_path / name).write_bytes(whole)
    assert read_checkpoint(tmp_path)


@pytest.mark.parametrize("name", [JOURNAL_NAME, CHECKPOINT_NAME])
def test_a_run_in_which_any_bit_was_flipped_is_not_gone_on_with(tmp_path, name: str) -> None:
    small_run(tmp_path)
    whole = (tmp_path / name).read_bytes()
    for bit in range(0, 8 * len(whole), 5):  # every byte, and more often than every 97th bit
        changed = bytearray(whole)
        changed[bit // 8] ^= 1 << bit % 8
        (tmp_path / name).write_bytes(changed)
        assert refused(tmp_path), bit


def test_a_value_replaced_in_the_checkpoint_is_refused_though_it_is_sound_json(tmp_path) -> None:
    small_run(tmp_path)
    path = tmp_path / CHECKPOINT_NAME
    path.write_text(path.read_text().replace('"side":"left"', '"side":"right"'))
    assert json.loads(path.read_bytes())["bench"]["side"] == "right"
    assert refused(tmp_path)


def test_events_that_were_exchanged_or_left_out_are_refused(tmp_path) -> None:
    lines = small_run(tmp_path).splitlines(keepends=True)
    for changed in (
        lines[:1] + lines[2:],
        [lines[1], lines[0], *lines[2:]],
        lines[1:],
        [*lines[:2], *lines[1:]],
    ):
        (tmp_path / JOURNAL_NAME).write_bytes(b"".join(changed))
        assert refused(tmp_path)


def test_a_missing_journal_is_refused(tmp_path) -> None:
    small_run(tmp_path)
    (tmp_path / JOURNAL_NAME).unlink()
    assert refused(tmp_path)


def test_a_damaged_checkpoint_leads_back_to_the_event_before(tmp_path) -> None:
    small_run(tmp_path)
    (tmp_path / CHECKPOINT_NAME).write_bytes(b"{")
    with pytest.raises(DataError, match=f"mv .*{PREVIOUS_NAME} .*{CHECKPOINT_NAME}"):
        read_checkpoint(tmp_path)
    (tmp_path / PREVIOUS_NAME).replace(tmp_path / CHECKPOINT_NAME)
    state = read_checkpoint(tmp_path)
    assert state is not None
    assert state["sequence"] == 3


def test_damage_before_both_checkpoints_leads_to_the_beginning(tmp_path) -> None:
    content = small_run(tmp_path)
    (tmp_path / JOURNAL_NAME).write_bytes(content.replace(b"0.1", b"0.2", 1))
    with pytest.raises(DataError, match=r"journal\.jsonl:2: .* Start again"):
        read_checkpoint(tmp_path)


def test_a_refused_run_is_left_as_it_is(tmp_path) -> None:
    content = small_run(tmp_path)[:-10]
    (tmp_path / JOURNAL_NAME).write_bytes(content)
    assert refused(tmp_path)
    assert (tmp_path / JOURNAL_NAME).read_bytes() == content


def test_an_event_is_with_the_operating_system_before_the_next_begins(tmp_path) -> None:
    journal = Journal(tmp_path)
    journal.append({"seq": 0})
    assert [event["seq"] for event in read_journal(tmp_path / JOURNAL_NAME)] == [0]
    journal.close()


def test_a_durable_checkpoint_follows_a_durable_journal(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    synced: list[int] = []
    monkeypatch.setattr("fsm_calib.journal.os.fsync", synced.append)
    journal = Journal(tmp_path)
    journal.append({"seq": 0})
    journal.checkpoint({"sequence": 1})
    assert synced == []
    journal.checkpoint({"sequence": 1}, durable=True)
    assert len(synced) == 2
    journal.close()


def test_a_file_that_cannot_be_written_whole_is_left_as_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "result.json"
    path.write_bytes(b"old")

    def full(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(OSError, match="No space"):
        write_atomically(path, b"new", durable=True)
    assert path.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_link_stays_a_link_and_a_pipe_a_pipe(tmp_path: Path) -> None:
    (tmp_path / "real.json").write_bytes(b"old")
    (tmp_path / "link.json").symlink_to("real.json")
    write_atomically(tmp_path / "link.json", b"new")
    assert (tmp_path / "link.json").is_symlink()
    assert (tmp_path / "real.json").read_bytes() == b"new"
    os.mkfifo(tmp_path / "pipe")
    reader = os.open(tmp_path / "pipe", os.O_RDONLY | os.O_NONBLOCK)
    write_atomically(tmp_path / "pipe", b"new")
    assert os.read(reader, 10) == b"new"
    os.close(reader)
