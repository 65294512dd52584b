"""Clocks that begin anywhere: epoch seconds, epoch nanoseconds, ISO times; the first stamp is taken off exactly."""

import csv
import gzip
import io
from decimal import Decimal

import numpy as np
import pytest
from recording_samples import shared
from test_recording_manifest import HEAD, POSE, ROWS, refused, write

from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.recording import read_recording
from fsm_calib.recording.stamps import read_stamps
from fsm_calib.world2d.effects import registry

EPOCH = 1_700_000_000


def shifted(folder, name, seconds, out):
    """Copy a recording's tables, every time later by `seconds`; return the new manifest."""
    out.mkdir()
    for path in folder.iterdir():
        data = gzip.decompress(path.read_bytes()) if path.suffix == ".gz" else path.read_bytes()
        if ".csv" in path.name:
            rows = list(csv.reader(io.StringIO(data.decode())))
            late = [[str(Decimal(row[0]) + seconds), *row[1:]] for row in rows[1:]]
            data = "\n".join(",".join(row) for row in [rows[0], *late]).encode()
        (out / path.name).write_bytes(gzip.compress(data) if path.suffix == ".gz" else data)
    return out / name


def times(cells, unit=None):
    stamps = read_stamps(cells, unit)
    return stamps.since(stamps.first)


@pytest.mark.parametrize("seconds", [EPOCH, 20_000, Decimal("0.37")])
def test_a_clock_that_begins_anywhere_changes_no_digit_of_the_recording(tmp_path, seconds):
    run = shared("concealed-development/robot-04/run-a")
    late = read_recording(shifted(run, "recording.yaml", seconds, tmp_path / "late"))
    plain = read_recording(run)
    assert late == plain
    assert late.clock_zero - plain.clock_zero == pytest.approx(float(seconds))


def test_epoch_stamps_change_no_digit_of_the_verdict(tmp_path):
    run = shared("concealed-development/robot-04/run-a")
    late = read_recording(shifted(run, "recording.yaml", EPOCH, tmp_path / "late"))
    few = set(registry()) - {"sensor_offset"}
    told = [
        diagnose([r.window(0.0, 20.0)], without=few).verdict.as_json() for r in (read_recording(run), late)
    ]
    for plain in told:
        plain.pop("seconds")
        plain.pop("seconds_by_part")
    assert told[0] == told[1]
    assert told[0]["effects"][0]["name"] == "sensor_offset"


def test_an_epoch_clock_is_told_with_its_date(tmp_path):
    rows = "t,x,y,h\n" + "".join(f"{EPOCH + 0.1 * i:.1f},{0.1 * i},0,0\n" for i in range(9))
    recording = read_recording(write(tmp_path, p=rows))
    assert any("2023-11-14 22:13:20 UTC" in str(finding) for finding in recording.checks)


@pytest.mark.parametrize("per_second", [10**3, 10**6, 10**9])
def test_whole_epoch_numbers_are_read_in_the_unit_that_their_size_tells(per_second):
    cells = [str(EPOCH * per_second + i * per_second // 10) for i in range(4)]
    assert times(cells) == pytest.approx([0.0, 0.1, 0.2, 0.3], abs=1e-12)


def test_a_stated_time_unit_is_not_guessed():
    assert times([str(EPOCH * 1000), str(EPOCH * 1000 + 5)], 1.0) == pytest.approx([0.0, 5.0])


def test_iso_times_keep_their_nanoseconds_and_zones():
    cells = ["2023-11-14T22:13:20.000000001Z", "2023-11-14 23:13:20.500000001+01:00", "2023-11-14T22:13:21Z"]
    assert list(times(cells)) == [0.0, 0.5, 0.999999999]


def test_a_clock_that_was_set_during_the_drive_is_refused(tmp_path):
    rows = ROWS.splitlines()
    rows[1] = "-1700000000,0,0,0.46"
    assert "the clock was set meanwhile" in refused(write(tmp_path, p="\n".join(rows)))


def test_channels_on_two_far_clocks_each_begin_at_their_own_zero(tmp_path):
    manifest = POSE + "  command: {file: c.csv, time: t, left: l, right: r}\n"
    commands = "t,l,r\n" + "".join(f"{EPOCH + i},0.2,0.2\n" for i in range(6))
    recording = read_recording(write(tmp_path, manifest, p=ROWS, c=commands))
    assert recording.command.time == pytest.approx(np.arange(6.0))


def test_a_word_in_the_time_column_is_refused_with_its_line(tmp_path):
    assert "p.csv:3: column 't' holds 'late'" in refused(
        write(tmp_path, HEAD + "  pose: {file: p.csv, time: t, x: x, y: x}\n", p="t,x\n0,0\nlate,1\n")
    )
