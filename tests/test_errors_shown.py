"""What a user reads when something is wrong: a line or two that a terminal only shows; never a traceback."""

import errno
import resource
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
from recording_samples import every_channel
from typer.testing import CliRunner

from fsm_calib import cli
from fsm_calib.calibration_files import read_kinematics
from fsm_calib.cli import app
from fsm_calib.diagnosis.identify.identify import identify
from fsm_calib.errors import (
    LONGEST_SENTENCE,
    DataError,
    FsmCalibError,
    InputError,
    ManyErrors,
    UnknownNameError,
    shown,
)
from fsm_calib.perception.camera_files import read_extrinsics, read_intrinsics
from fsm_calib.perception.encoded import decode_image
from fsm_calib.perception.photos import read_photo
from fsm_calib.recording import CommandTrack, PoseTrack, Recording, RobotFacts, read_recording
from fsm_calib.recording.writers import write_bag, write_recording

ESCAPE = "\x1b[2J\x1b]0;owned\x07\u202e"
CAMERA = """image_width: 640
image_height: 480
camera_name: c
camera_matrix: {rows: 3, cols: 3, data: [300, 0, 320, 0, 300, 240, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}
"""


@pytest.mark.parametrize(
    "error",
    [
        InputError(f"the key {ESCAPE} is wrong", where=f"{ESCAPE}.yaml", cure=f"Not {ESCAPE}."),
        DataError(f"robot {ESCAPE}", cure=ESCAPE),
        UnknownNameError("effect", ESCAPE, ["a", "b"]),
        ManyErrors([InputError(ESCAPE), InputError("b")]),
    ],
)
def test_control_characters_of_a_file_are_shown_not_obeyed(error: FsmCalibError) -> None:
    assert all(line.isprintable() for line in str(error).split("\n"))
    assert "\\x1b" in str(error)


@pytest.mark.parametrize(
    "error",
    [
        InputError("p" * 50_000, where="w" * 50_000, cure="c" * 50_000),
        DataError("p" * 50_000, cure="c" * 50_000),
        UnknownNameError("effect", "n" * 50_000, ["a", "b"]),
    ],
)
def test_sentence_ends_after_some_lines_of_a_terminal(error: FsmCalibError) -> None:
    assert len(str(error)) <= 1200


def test_one_line_spoofs_no_second_one() -> None:
    assert "\n" not in str(InputError("bad\nfsm-calib: all is well"))


def test_many_errors_are_told_to_a_bound_and_kept_whole() -> None:
    many = ManyErrors(InputError(f"wrong {i}") for i in range(500))
    assert len(many.errors) == 500
    assert str(many).endswith("and 460 more errors")
    assert str(many).startswith("wrong 0.")


def test_place_keeps_its_end_where_it_is_cut() -> None:
    assert str(InputError("bad", where="/long" * 200 + "/file.yaml:3:1")).startswith("/long/long")
    assert "/file.yaml:3:1: bad." in str(InputError("bad", where="/long" * 200 + "/file.yaml:3:1"))


def test_printable_text_of_any_language_stays() -> None:
    assert shown("дорога 日本 é") == "дорога 日本 é"


@pytest.mark.parametrize(
    "text",
    ["homography: 2001-99-99", "a: 0b", "? [1]\n: 2", "homography: !!int a", "homography: !!float ''",
     "homography: " + "[" * 2000, "homography: [" + "9" * 400 + ", 0, 0, 0, 0, 0, 0, 0, 1]", "\x00", "\ufeff- 1",
     "homography: [[1, 2], [3]]", "a: &a [*a]\nhomography: [*a]", "<<: 1"],
)  # fmt: skip
def test_damaged_camera_file_is_refused_with_its_place(tmp_path: Path, text: str) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text(text)
    for read in (read_extrinsics, read_intrinsics):
        with pytest.raises(InputError, match=r"robot\.yaml"):
            read(path)


@pytest.mark.parametrize(
    ("old", "new"),
    [("640", "[640]"), ("640", "1" + "0" * 400), ("640", "true"), ("plumb_bob", "[1]"), ("300, 0, 320", "9" * 400)],
)  # fmt: skip
def test_strange_value_in_a_camera_file_is_refused(tmp_path: Path, old: str, new: str) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text(CAMERA.replace(old, new, 1))
    with pytest.raises(InputError, match=r"robot\.yaml") as told:
        read_intrinsics(path)
    assert len(str(told.value)) < 500


def test_sound_camera_file_is_read(tmp_path: Path) -> None:
    (tmp_path / "robot.yaml").write_text(CAMERA)
    assert read_intrinsics(tmp_path / "robot.yaml").width == 640


def test_kinematics_file_with_endless_digits_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text("gain: 1.0\ntrim: 0.0\nbaseline: 0.1\nradius: 0.03\nlimit: 1.0\nk: " + "9" * 350)
    with pytest.raises(InputError, match=r"robot\.yaml:6"):
        read_kinematics(path)


def bomb() -> bytes:
    """Return the head of a PNG of 60000 x 60000 pixels."""
    import struct
    import zlib

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", 60_000, 60_000, 8, 0, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", head)
        + chunk(b"IDAT", zlib.compress(b"\0" * 99))
        + chunk(b"IEND", b"")
    )


def test_image_larger_than_any_camera_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "bomb.png"
    path.write_bytes(bomb())
    with pytest.raises(InputError, match=r"bomb\.png"):
        read_photo(path)
    assert decode_image(bomb()) is None


def test_png_chunk_that_claims_four_gigabytes_is_refused_before_they_are_reserved() -> None:
    picture = bytearray(cv2.imencode(".png", np.zeros((40, 60), np.uint8))[1].tobytes())
    assert decode_image(bytes(picture)) is not None
    chunk = bytes(picture).index(b"IDAT") - 4
    picture[chunk : chunk + 4] = b"\xff" * 4
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert decode_image(bytes(picture)) is None
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 200_000  # KiB


def drive(**changes: object) -> Recording:
    time = np.arange(0.0, 20.0, 0.1)
    heading = 0.8 * np.sin(time)
    x, y = np.cumsum(0.02 * np.cos(heading)), np.cumsum(0.02 * np.sin(heading))
    sound = {
        "robot": RobotFacts("robot", 0.0318, 0.1, 20.0),
        "command": CommandTrack(time, 0.3 - 0.1 * np.cos(time), 0.3 + 0.1 * np.cos(time)),
        "pose": PoseTrack(time, x, y, heading),
    }
    return Recording(**{**sound, **changes})


def with_pose(number: float) -> Recording:
    x = drive().pose.x.copy()
    x[50] = number
    return drive(pose=PoseTrack(drive().pose.time, x, drive().pose.y, drive().pose.theta))


@pytest.mark.parametrize("number", [np.inf, -np.inf, np.nan, 1e200])
@pytest.mark.parametrize("name", ["bag.bag", "bag"])
def test_bag_with_a_pose_that_is_no_number_is_refused(tmp_path: Path, name: str, number: float) -> None:
    with pytest.raises(InputError, match=r"message 51: pose: x is"):
        read_recording(write_bag(with_pose(number), tmp_path / name))


@pytest.mark.parametrize(
    "head", ["[" * 100_000, "[]", '{"channels": 3}', '{"channels": {"pose": {"kind": "Path"}}}']
)
def test_bag_with_a_damaged_description_is_refused(
    tmp_path: Path, head: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("fsm_calib.recording.writers.json.dumps", lambda *_, **__: head)
    path = write_bag(every_channel(), tmp_path / "bag.bag")
    monkeypatch.undo()
    with pytest.raises(InputError, match="damaged"):
        read_recording(path)


def test_recording_whose_commands_are_empty_is_read_or_refused_with_a_sentence(tmp_path: Path) -> None:
    empty = CommandTrack(np.zeros(0), np.zeros(0), np.zeros(0))
    from fsm_calib.recording.oddities import findings_of

    assert all(finding.channel != "command" for finding in findings_of(drive(command=empty)))


@pytest.mark.parametrize("fact", ["1e300", "1e-300", "-1", ".inf"])
def test_impossible_fact_about_a_robot_is_refused(tmp_path: Path, fact: str) -> None:
    manifest = write_recording(drive(), tmp_path / "r", compress=False)
    manifest.write_text(manifest.read_text().replace("axle_length: 0.1", f"axle_length: {fact}"))
    with pytest.raises(InputError, match=r"recording\.yaml:\d+:\d+: robot\.axle_length"):
        read_recording(manifest)


@pytest.mark.parametrize("recording", [drive(robot=RobotFacts("r", 1e300, 1e300, 1e300)), with_pose(np.inf)])
def test_numbers_without_a_fit_are_refused_with_a_sentence(recording: Recording) -> None:
    with np.errstate(all="ignore"), pytest.raises(DataError):
        identify([recording])


def raising(error: Exception) -> Callable[[], None]:
    def fail(*_: object) -> None:
        raise error

    return fail


@pytest.mark.parametrize(
    ("error", "code", "said"),
    [
        (ZeroDivisionError("by nought\x1b"), 2, "not foreseen"),
        (OSError(errno.ENOSPC, "No space left on device", "out/x.json"), 1, "out/x.json: No space left"),
        (PermissionError(errno.EACCES, "Permission denied", "out"), 2, "out: Permission denied"),
        (MemoryError(), 1, "memory"),
    ],
)
def test_what_nobody_foresaw_becomes_a_sentence(
    error: Exception,
    code: int,
    said: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
) -> None:
    monkeypatch.setattr(cli, "app", raising(error))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with pytest.raises(SystemExit) as ended:
        cli.main()
    told = capsys.readouterr().err
    assert ended.value.code == code
    assert said in told
    assert told.count("\n") == 1
    assert "\x1b" not in told
    if isinstance(error, ZeroDivisionError):
        (log,) = tmp_path.glob("fsm-calib-*.log")
        assert str(log) in told
        assert "Traceback" in log.read_text()


def test_details_are_shown_where_the_user_asks_for_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cli, "app", raising(ZeroDivisionError()))
    monkeypatch.setenv("FSM_CALIB_TRACEBACK", "1")
    with pytest.raises(ZeroDivisionError):
        cli.main()


def test_a_defect_is_not_hidden_from_tests_of_commands(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("fsm_calib.scenario.yaml_source.read_yaml", raising(ZeroDivisionError()))
    assert isinstance(CliRunner().invoke(app, ["validate", str(tmp_path)]).exception, ZeroDivisionError)


def test_escape_sequences_of_a_recording_reach_no_terminal(tmp_path: Path) -> None:
    manifest = write_recording(drive(), tmp_path / "r", compress=False)
    manifest.write_text(manifest.read_text().replace("name: robot", 'name: "\\e[2Jrobot"'))
    result = CliRunner().invoke(app, ["identify", str(manifest)])
    assert result.exit_code == 0
    assert "\x1b" not in result.output
    assert "\\x1b[2Jrobot" in result.output


def test_module_can_be_run_as_a_program() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "fsm_calib.cli", "--help"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0


def test_a_sentence_that_lists_names_without_letters_keeps_its_length():
    error = UnknownNameError("column", "theta", ["t", *("\x9c[" * 900 for _ in range(40))])
    assert len(str(error)) <= LONGEST_SENTENCE
    assert str(error).startswith("unknown column 'theta'. Known: ")
