"""Manifests and CSV files: units, and one clear sentence for whatever is damaged."""

import gzip
import importlib.util

import numpy as np
import pytest
from recording_samples import ROOT, every_channel
from typer.testing import CliRunner

from fsm_calib.cli import app
from fsm_calib.errors import InputError
from fsm_calib.recording import PoseTrack, Recording, read_recording
from fsm_calib.recording.csv_table import LONGEST_LINE
from fsm_calib.recording.writers import write_recording

HEAD = "format: fsm-calib/recording@1\nrobot: {name: r, axle_length: 0.1}\nchannels:\n"
POSE = HEAD + "  pose: {file: p.csv, time: t, x: x, y: y, theta: h}\n"
ROWS = "t,x,y,h\n" + "".join(f"{0.1 * i:.1f},{0.1 * i:.2f},{0.05 * i:.2f},0.46\n" for i in range(60))


def write(folder, manifest=POSE, **tables):
    (folder / "r.yaml").write_text(manifest)
    for name, text in tables.items():
        (folder / f"{name}.csv").write_text(text)
    return folder / "r.yaml"


def refused(path) -> str:
    with pytest.raises(InputError) as caught:
        read_recording(path)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_units_become_si(tmp_path):
    manifest = HEAD + (
        "  wheel_angle: {file: w.csv, time: ms, time_unit: 0.001, left: l, right: r, unit: tick,\n"
        "    ticks_per_turn: 100}\n"
        "  pose: {file: p.csv, time: ms, time_unit: 1e-3, x: x, y: y, length_unit: 0.01}\n"
    )
    recording = read_recording(
        write(tmp_path, manifest, w="ms,l,r\n0,0,0\n500,50,25\n", p="ms,x,y\n0,0,0\n500,20,10\n")
    )
    assert recording.wheel_angle.time == pytest.approx([0.0, 0.5])
    assert recording.wheel_angle.left == pytest.approx([0.0, np.pi])
    assert recording.wheel_angle.resolution == pytest.approx(2.0 * np.pi / 100)
    assert recording.pose.x == pytest.approx([0.0, 0.2])
    assert not recording.pose.has_heading


def test_ticks_without_a_turn_stay_ticks(tmp_path):
    manifest = HEAD + "  wheel_angle: {file: w.csv, time: t, left: l, right: r, unit: tick}\n"
    assert read_recording(write(tmp_path, manifest, w="t,l,r\n0,3,4\n1,5,6\n")).wheel_angle.unit == "tick"


def test_durations_become_times_of_intervals(tmp_path):
    manifest = HEAD + "  wheel_rate: {file: w.csv, duration: T, left: l, right: r, unit: rad/s}\n"
    track = read_recording(write(tmp_path, manifest, w="T,l,r\n0.5,1,2\n0.25,1,2\n1,1,2\n")).wheel_rate
    assert track.time == pytest.approx([0.0, 0.5, 0.75])


@pytest.mark.parametrize("twist", [False, True])
@pytest.mark.parametrize("compress", [False, True])
def test_written_recording_reads_back_equal(tmp_path, twist, compress):
    recording = every_channel(3, twist)
    assert read_recording(write_recording(recording, tmp_path / "out", compress)) == recording


def test_positions_without_heading_read_back_equal(tmp_path):
    t = np.arange(5.0)
    recording = Recording(pose=PoseTrack(t, t, t, np.full(5, np.nan)))
    assert read_recording(write_recording(recording, tmp_path)) == recording


def test_same_recording_writes_the_same_bytes(tmp_path):
    write_recording(every_channel(), tmp_path / "a")
    write_recording(every_channel(), tmp_path / "b")
    assert (tmp_path / "a/pose.csv.gz").read_bytes() == (tmp_path / "b/pose.csv.gz").read_bytes()


def test_every_mistake_of_a_manifest_is_told_with_its_place(tmp_path):
    text = (
        HEAD.replace("axle_length: 0.1", "axle_lenght: 0.1") + "  pose: {file: p.csv, time: t, x: x, z: y}\n"
    )
    with pytest.raises(InputError) as caught:
        read_recording(write(tmp_path, text, p=ROWS))
    lines = str(caught.value).split("\n")
    assert len(lines) == 3
    assert "r.yaml:2:18" in lines[0]
    assert "axle_length" in lines[0]


def test_empty_csv_is_refused(tmp_path):
    assert "p.csv:1: the file is empty" in refused(write(tmp_path, p=""))


def test_header_without_rows_is_refused(tmp_path):
    assert "p.csv:1" in refused(write(tmp_path, p="t,x,y,h\n"))


@pytest.mark.parametrize("cell", ["nan", "inf", "", "fast", "1_000", "1e400"])
def test_cell_that_is_no_finite_number_is_refused_with_its_line(tmp_path, cell):
    lines = ROWS.split("\n")
    lines[7] = f"0.6,{cell},0.3,0.46"
    message = refused(write(tmp_path, p="\n".join(lines)))
    assert "p.csv:8" in message
    assert "'x'" in message


def test_line_numbers_count_blank_lines(tmp_path):
    lines = ROWS.split("\n")
    lines[5:5] = ["", ""]
    lines[9] = "0.6,bad,0.3,0.46"
    assert "p.csv:10" in refused(write(tmp_path, p="\n".join(lines)))


def test_short_row_is_refused_with_its_line(tmp_path):
    assert "p.csv:3: the row has 2 cells" in refused(write(tmp_path, p="t,x,y,h\n0,1,2,3\n1,1\n2,1,1,1\n"))


def test_missing_file_is_told_at_the_manifest_line(tmp_path):
    assert "r.yaml:4:16: the file 'p.csv' does not exist" in refused(write(tmp_path))


def test_missing_column_offers_the_nearest(tmp_path):
    assert "Did you mean" in refused(write(tmp_path, p=ROWS.replace("t,x,y,h", "t,x,y,hh")))


def test_column_of_text_is_refused(tmp_path):
    assert "p.csv:2" in refused(write(tmp_path, p="t,x,y,h\n0,left,1,1\n1,right,1,1\n"))


def test_time_column_that_runs_backwards_is_refused(tmp_path):
    assert "Is this the time column?" in refused(
        write(tmp_path, POSE.replace("time: t, x: x", "time: h2, x: x"), p=swapped())
    )


def swapped() -> str:
    rng = np.random.default_rng(0)
    return "t,x,y,h,h2\n" + "".join(f"{i},{i},{i},0.7,{rng.normal():.3f}\n" for i in range(60))


@pytest.mark.parametrize(
    ("a", "b"), [("x: x, y: y", "x: y, y: x"), ("x: x, y: y, theta: h", "x: h, y: y, theta: x")]
)
def test_swapped_columns_of_a_curve_are_refused(tmp_path, a, b):
    t = np.arange(0.0, 20.0, 0.1)
    x, y = np.cumsum(0.1 * np.cos(t / 3.0)), np.cumsum(0.1 * np.sin(t / 3.0))
    rows = "t,x,y,h\n" + "".join(
        f"{q:.1f},{v:.4f},{w:.4f},{q / 3.0:.4f}\n" for q, v, w in zip(t, x, y, strict=True)
    )
    read_recording(write(tmp_path, p=rows))
    assert "p.csv:2" in refused(write(tmp_path, POSE.replace(a, b), p=rows))


def test_command_in_place_of_which_time_was_given_is_refused(tmp_path):
    manifest = HEAD + "  command: {file: c.csv, time: t, left: t, right: r, unit: normalized}\n"
    assert "far beyond -1 to 1" in refused(write(tmp_path, manifest, c="t,r\n0,0.1\n1,0.2\n2,0.1\n3,0.1\n"))


def test_a_percentage_is_a_share_of_full_command(tmp_path):
    manifest = HEAD + "  command: {file: c.csv, time: t, left: l, right: r, full: 100}\n"
    command = read_recording(write(tmp_path, manifest, c="t,l,r\n0,0,0\n1,50,-25\n2,0,0\n")).command
    assert command.unit == "normalized"
    assert (command.left[1], command.right[1]) == (0.5, -0.25)


def test_a_full_number_of_rates_is_refused_with_its_place(tmp_path):
    manifest = HEAD + "  command: {file: c.csv, time: t, left: l, right: r, unit: rpm, full: 100}\n"
    said = refused(write(tmp_path, manifest, c="t,l,r\n0,0,0\n"))
    assert "r.yaml:4:12: channels.command: full belongs to unit normalized" in said


def test_position_in_place_of_time_is_refused(tmp_path):
    t = np.arange(0.0, 20.0, 0.1)
    rows = "x,t,y,h\n" + "".join(f"{q:.1f},{0.01 * q:.4f},0,0\n" for q in t)
    assert "p.csv:2: 199 of 199 steps beat 3 m/s" in refused(write(tmp_path, p=rows))


def test_name_stands_for_its_manifest(tmp_path):
    write(tmp_path, p=ROWS).rename(tmp_path / "drive.recording.yaml")
    assert read_recording(tmp_path / "drive").pose is not None


def test_endless_line_is_refused_without_being_read(tmp_path):
    path = write(tmp_path)
    with (tmp_path / "p.csv").open("wb") as stream:
        stream.write(b"t,x,y,h\n0,0,0,0\n")
        stream.truncate(2_000_000_000)
    assert f"p.csv:3: the line is longer than {LONGEST_LINE} bytes" in refused(path)


def test_truncated_archive_is_refused(tmp_path):
    path = write(tmp_path, POSE.replace("p.csv", "p.csv.gz"))
    (tmp_path / "p.csv.gz").write_bytes(gzip.compress(ROWS.encode())[:-20])
    assert "damaged or cut short" in refused(path)


@pytest.mark.parametrize(
    "text", ["", "[]", "a: [", "a: b: c", "? {a: b}\n: c", "&a [*a]", "\x00", "format: x\nformat: y"]
)
def test_text_that_is_no_manifest_is_refused_with_a_place(tmp_path, text):
    path = tmp_path / "r.yaml"
    path.write_text(text)
    assert "r.yaml:" in refused(path)


def test_command_line_answers_damaged_input_with_one_line_and_exit_2(tmp_path):
    path = write(tmp_path, p=ROWS.replace("0.46", "what", 1))
    answer = CliRunner().invoke(app, ["identify", str(path), "--json", str(tmp_path / "out.json")])
    assert answer.exit_code == 2
    assert answer.stderr.count("\n") == 1
    assert "p.csv:2" in answer.stderr
    assert answer.stdout == ""
    assert not (tmp_path / "out.json").exists()


def test_fuzzed_manifests_and_tables_never_end_in_a_traceback():
    spec = importlib.util.spec_from_file_location("fuzz", ROOT / "benchmarks" / "identify_fuzz.py")
    fuzz = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(fuzz)
    found = fuzz.run(400, seed=1)
    assert found["traceback"] == 0
    assert found["without a place"] == 0
    assert found["read"] + found["refused"] == 400


def test_folder_with_one_manifest_of_any_name_is_that_recording(tmp_path) -> None:
    path = write_recording(every_channel(), tmp_path / "run-a", compress=False)
    path.rename(path.with_name("manifest.yaml"))
    (path.parent / "notes.yaml").write_text("weather: rain\n")
    assert read_recording(path.parent).pose is not None


def test_folder_with_two_manifests_is_refused_and_both_are_named(tmp_path) -> None:
    path = write_recording(every_channel(), tmp_path / "run-a", compress=False)
    text = path.read_text()
    path.unlink()
    for name in ("first.yaml", "second.yaml"):
        (path.parent / name).write_text(text)
    with pytest.raises(InputError, match=r"first\.yaml, second\.yaml: name those"):
        read_recording(path.parent)
