"""What the fuzz campaign feeds, by kind: sound files, how they are damaged, and who reads them."""

from __future__ import annotations

import gzip
import random
import re
import struct
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

import cv2
import numpy as np
from campaign_door import through
from damaged_input import drive
from identify_fuzz import NASTY, damage, files
from rosbags.rosbag2 import StoragePlugin

sys.path.append(str(Path(__file__).parent.parent / "tests"))
from wild_bags import turtlebot

from fsm_calib.calibration_files import read_kinematics
from fsm_calib.commands.camera_options import parse_board
from fsm_calib.diagnosis.identify.identify import identify
from fsm_calib.journal import Journal, read_checkpoint
from fsm_calib.perception.camera_files import (
    read_extrinsics,
    read_intrinsics,
    read_projection,
    write_intrinsics,
)
from fsm_calib.perception.chessboard import inspect_board
from fsm_calib.perception.photos import read_photo
from fsm_calib.perception.tags import find_tags, tag_cells
from fsm_calib.perception.undistort import undistorted
from fsm_calib.recording import TwistTrack, WheelPair, read_recording, writers
from fsm_calib.recording.robot_files import read_robot_file
from fsm_calib.recording.tag_poses import read_tag_map
from fsm_calib.scenario.load import load_scenario
from fsm_calib.scenario.world import physics_of, world_of
from fsm_calib.study.load import load_study
from fsm_calib.types import BoardSpec, CameraModel
from fsm_calib.watch.follow import Follower

ROOT = Path(__file__).parent.parent
Files = dict[str, bytes]
WORDS = (b"\x00" * 4, b"\xff" * 4, b"\xff" * 8, struct.pack("<d", float("nan")), struct.pack("<d", float("inf")),
         struct.pack("<d", 1e300), struct.pack("<I", 1 << 31), struct.pack("<Q", 1 << 62), b"\x1b[2J", b"[" * 3000)  # fmt: skip
NUMBERS = ("1e300", "-1e300", "1e-300", "0", "-1", ".inf", ".nan", "9" * 399, "true", "''", "[]", "{}", "2001-99-99", "0b",
           "!!int a", "&a [*a]", "\"\\e[2J\"", "<script>", "0o9", "1e400", "[[[]]]", "? ", "<<: 1")  # fmt: skip

NUMBER = re.compile(r"-?\d+(\.\d*)?([eE][-+]?\d+)?")
EXTREMES = ("1e300", "-1e300", "1e-300", "0", "-0.0", "-1", "0.5", "1e9", "-1e9", "1e19", "nan", "-inf", ".inf", "1e400", "9" * 30,
            "1_0", "0x1f", "true", "''")  # fmt: skip
"""What a number is exchanged for where the text around it stays sound, so that it reaches what computes with it."""


@dataclass(frozen=True)
class Kind:
    """One kind of input: its sound files, how they are damaged, and what reads them in a folder."""

    sound: Callable[[], Files]
    damaged: Callable[[Files, random.Random], Files]
    read: Callable[[Path], object]
    turn: int = 75
    """Cases before the next kind has its turn: fewer of what takes longer to read."""


def damaged_text(contents: Files, rng: random.Random) -> Files:
    """Return files of text with one to three faults: of the text, of a value, or of its bytes."""
    result = dict(contents)
    for _ in range(rng.choice((1, 1, 2, 3))):
        name = rng.choice(sorted(result))
        text = result[name].decode("utf-8", "replace")
        numbers, chance = list(NUMBER.finditer(text)), rng.random()
        if numbers and chance < 0.3:
            place = rng.choice(numbers)
            text = text[: place.start()] + rng.choice(EXTREMES) + text[place.end() :]
        elif chance < 0.6:
            lines = text.split("\n")
            number = rng.randrange(len(lines))
            head, colon, _ = lines[number].partition(":")
            lines[number] = f"{head}{colon} {rng.choice(NUMBERS)}"
            text = "\n".join(lines)
        else:
            text = damage(text or " ", rng)
        result[name] = text.encode("utf-8", "surrogatepass")
        if rng.random() < 0.1:
            result[name] = damaged_bytes(result[name], rng)
    return result


def damaged_binary(contents: Files, rng: random.Random) -> Files:
    """Return files with one to four faults of their bytes."""
    result = dict(contents)
    for _ in range(rng.choice((1, 1, 2, 4))):
        name = rng.choice(sorted(result))
        result[name] = damaged_bytes(result[name], rng)
    return result


def damaged_bytes(data: bytes, rng: random.Random) -> bytes:
    """Return bytes cut, flipped, doubled, overwritten, or with a nasty word in their midst."""
    i, j = sorted((rng.randrange(len(data) + 1), rng.randrange(len(data) + 1)))
    j = min(j, i + 200)
    kind, word = rng.randrange(6), rng.choice(WORDS)
    if kind == 0:
        return data[:i]
    if kind == 1 and data:
        i = min(i, len(data) - 1)
        return data[:i] + bytes([data[i] ^ 1 << rng.randrange(8)]) + data[i + 1 :]
    if kind == 2:
        return data[:i] + data[j:]
    if kind == 3:
        return data[:i] + word + data[i + len(word) :]
    return data[:i] + (word if kind == 4 else data[i:j]) + data[i:]


def damaged_archive(contents: Files, rng: random.Random) -> Files:
    """Return files damaged before they are packed, or their archives' bytes afterwards."""
    packed = {name: data for name, data in contents.items() if name.endswith(".gz")}
    if rng.random() < 0.5:
        plain = {name: gzip.decompress(data) for name, data in packed.items()}
        broken = {name: gzip.compress(data, 1) for name, data in damaged_text(plain, rng).items()}
        return contents | broken
    return contents | damaged_binary(packed, rng)


def of_files(*names: str) -> Callable[[], Files]:
    """Return who gives the repository's files of these names."""
    return lambda: {Path(name).name: (ROOT / name).read_bytes() for name in names[:1]}


def recording_files() -> Files:
    contents = {name: text.encode() for name, text in files(random.Random(0)).items()}
    return contents | {"pose.csv.gz": gzip.compress(contents["pose.csv.gz"])}


def fitted_files() -> Files:
    """Return a sound drive of 12 s with poses and commands, as text."""
    with tempfile.TemporaryDirectory() as folder:
        writers.write_recording(drive().window(0.0, 12.0), Path(folder), compress=False)
        return {path.name: path.read_bytes() for path in Path(folder).iterdir()}


def damaged_cells(contents: Files, rng: random.Random) -> Files:
    """Return tables with some numbers replaced, whole columns scaled, or rows exchanged: still tables."""
    result = dict(contents)
    name = rng.choice([name for name in sorted(result) if name.endswith(".csv")])
    lines = result[name].decode().strip().split("\n")
    column = rng.randrange(lines[0].count(",") + 1)
    kind, scale = rng.randrange(4), rng.choice((0.0, -1.0, 1e-9, 57.3, 1e6, 1e12))
    first, rows = rng.randrange(1, len(lines)), rng.choice((1, 3, 40, len(lines)))
    for number in range(first if kind else 1, min(first + rows, len(lines)) if kind else len(lines)):
        cells = lines[number].split(",")
        value = float(cells[column])
        cells[column] = repr((value * scale, value + scale, scale, rng.gauss(0.0, 1.0) * scale)[kind])
        lines[number] = ",".join(cells)
    result[name] = ("\n".join(lines) + "\n").encode()
    return damaged_text(result, rng) if rng.random() < 0.2 else result


def bag_files(
    name: str, *, own: bool = True, storage: StoragePlugin = StoragePlugin.MCAP
) -> Callable[[], Files]:
    """Return who writes a small bag, of our own channels or of Duckietown's topics alone."""

    def write() -> Files:
        every = writers._messages
        topics = (
            every if own else lambda *given: [row for row in every(*given) if "/fsm_calib/" not in row[1]]
        )
        plugin = mock.patch.object(writers, "StoragePlugin", SimpleNamespace(MCAP=storage))
        with tempfile.TemporaryDirectory() as folder, plugin, mock.patch.object(writers, "_messages", topics):
            path = writers.write_bag(drive().window(0.0, 3.0), Path(folder) / name)
            written = [path] if path.is_file() else sorted(path.iterdir())
            return {file.name: file.read_bytes() for file in written}

    return write


def turtlebot_files(storage: str) -> Callable[[], Files]:
    """Return who writes another robot's bag: velocities, stamped poses, joint states."""

    def write() -> Files:
        sound = drive().window(0.0, 4.0)
        twist = TwistTrack(sound.pose.time, np.full(sound.pose.time.size, 0.2), np.cos(sound.pose.time))
        wheels = WheelPair(sound.pose.time, sound.pose.time * 6.0, sound.pose.time * 6.0)
        robot = replace(sound, command=None, twist=twist, wheel_angle=wheels)
        with tempfile.TemporaryDirectory() as folder:
            path = turtlebot(robot, storage).write(Path(folder) / "drive")
            written = [path] if path.is_file() else sorted(path.iterdir())
            return {file.name: file.read_bytes() for file in written}

    return write


def follow(folder: Path) -> object:
    """Read a run's directory as the page that watches it does."""
    run = Follower(folder)
    return run.read(), run.pictures(), run.area(), run.result()


def identified(path: Path) -> object:
    """Read a recording and fit it as the command does."""
    with np.errstate(all="ignore"):
        return identify([read_recording(path)])


def read_bag_in(folder: Path) -> object:
    """Read whatever bag is in a folder, with its folder where it has one."""
    files = list(folder.iterdir())
    return read_recording(folder if len(files) > 1 else files[0])


def without_metadata(bag: Callable[[], Files]) -> Callable[[], Files]:
    """Return who writes the same bag as a file without its folder."""
    return lambda: {name: data for name, data in bag().items() if name != "metadata.yaml"}


def one_of(damaged: Callable[[Files, random.Random], Files]) -> Callable[[Files, random.Random], Files]:
    """Return how one file of several forms is damaged: a form that is sound has nothing to tell."""

    def harmed(contents: Files, rng: random.Random) -> Files:
        name = rng.choice(sorted(contents))
        return damaged({name: contents[name]}, rng)

    return harmed


def camera_files() -> Files:
    camera = CameraModel(
        np.array([[300.0, 0, 320], [0, 300, 240], [0, 0, 1]]), np.array([-0.3, 0.1, 0, 0, 0]), 640, 480
    )
    with tempfile.TemporaryDirectory() as folder:
        content = write_intrinsics(Path(folder) / "robot.yaml", camera, "robot").read_bytes()
    return {"robot.yaml": content}


def read_camera(folder: Path) -> object:
    path = folder / "robot.yaml"
    camera = read_intrinsics(path)
    read_projection(path)
    return (
        undistorted(np.zeros((12, 16), dtype=np.uint8), camera)
        if camera.width < 2000 > camera.height
        else None
    )


def picture(kind: str) -> Callable[[], Files]:
    """Return who draws a tag or a small chessboard as an image file."""

    def draw() -> Files:
        image = np.full((120, 160), 220, dtype=np.uint8)
        if kind == "tag":
            cells = np.kron(np.asarray(tag_cells(300), dtype=np.uint8) * 255, np.ones((8, 8), dtype=np.uint8))
            image[10 : 10 + cells.shape[0], 10 : 10 + cells.shape[1]] = cells
        else:
            image[10:110, 10:150] = np.kron(np.indices((5, 7)).sum(axis=0) % 2, np.ones((20, 20))) * 255
        return {f"photo{end}": bytes(cv2.imencode(end, image)[1]) for end in (".png", ".jpg", ".pgm", ".bmp")}

    return draw


def look_for_tags(folder: Path) -> object:
    return [find_tags(read_photo(path)) for path in sorted(folder.iterdir())]


def look_for_boards(folder: Path) -> object:
    return [inspect_board(read_photo(path), BoardSpec(6, 4)) for path in sorted(folder.iterdir())]


def journal_files() -> Files:
    with tempfile.TemporaryDirectory() as folder:
        journal = Journal(Path(folder))
        for number in range(6):
            journal.append({"seq": number, "commands": [[0.1 * number, 0.3, -0.2]], "pose": [0.1, 0.2, 0.3]})
            journal.checkpoint({"sequence": number, "bench": {"quiet": 0.5}})
        journal.close()
        return {path.name: path.read_bytes() for path in Path(folder).iterdir()}


def resume(folder: Path) -> object:
    """Read a checkpoint; what is taken up must be what was written."""
    state = read_checkpoint(folder)
    if state is not None and state not in _WRITTEN:
        raise AssertionError("a changed checkpoint was taken up")
    return state


def _written() -> list[dict]:
    states = []
    with tempfile.TemporaryDirectory() as folder:
        for name, content in journal_files().items():
            (Path(folder) / name).write_bytes(content)
        states.append(read_checkpoint(Path(folder)))
    return states


_WRITTEN = _written()
KINEMATICS = b"baseline: 0.1\ncalibration_time: 2024-01-01\ngain: 1.0\nk: 27.0\nlimit: 1.0\nomega_max: 8.0\nradius: 0.0318\ntrim: 0.01\nv_max: 1.0\n"
EXTRINSICS = b"homography: [-0.001, -0.0002, 0.4, 0.001, -0.0001, -0.3, -0.0001, -0.008, 1.0]\n"
TAGS = b"tags:\n  300: {x: 0.0, y: 0.0, theta: 0.0}\n  301: {x: 1.0, y: 0.5, theta: 1.57}\nmount: {forward: 0.06, height: 0.1, pitch: 0.3}\n"
URDF = b"""<robot name="cart"><link name="base_link"><inertial><mass value="2.0"/><inertia izz="0.01"/></inertial></link>
<link name="wheel_left_link"><collision><geometry><cylinder radius="0.033" length="0.018"/></geometry></collision>
<inertial><mass value="0.03"/><inertia izz="1e-5"/></inertial></link>
<joint name="wheel_left_joint" type="continuous"><parent link="base_link"/><child link="wheel_left_link"/>
<origin xyz="0.0 0.08 0.023" rpy="-1.57 0 0"/></joint>
<link name="wheel_right_link"><collision><geometry><cylinder radius="0.033" length="0.018"/></geometry></collision></link>
<joint name="wheel_right_joint" type="continuous"><parent link="base_link"/><child link="wheel_right_link"/>
<origin xyz="0.0 -0.08 0.023"/></joint></robot>
"""
SDF = b"""<sdf version="1.6"><model name="m"><link name="left_wheel"><pose>0 0.25 0 0 0 0</pose><inertial><mass>2</mass>
</inertial><collision><geometry><cylinder><radius>0.1</radius></cylinder></geometry></collision></link>
<link name="right_wheel"><pose>0 -0.25 0 0 0 0</pose></link>
<plugin><wheel_separation>0.52</wheel_separation><wheel_diameter>0.21</wheel_diameter></plugin></model></sdf>
"""
BAGS = 20
"""Cases in a turn of a kind whose inputs take some ms."""
KINDS: dict[str, Kind] = {
    "scenario": Kind(of_files("scenarios/full_calibration.yaml"), damaged_text, lambda f: world_of(load_scenario(f / "full_calibration.yaml"))),
    "world": Kind(of_files("scenarios/wheels_only.yaml"), damaged_text, lambda f: physics_of(f / "wheels_only.yaml")),
    "study": Kind(of_files("scenarios/study.yaml"), damaged_text, lambda f: load_study(f / "study.yaml")),
    "manifest and CSV": Kind(recording_files, damaged_text, lambda f: read_recording(f / "recording.yaml")),
    "fitted recording": Kind(fitted_files, damaged_cells, lambda f: identified(f / "recording.yaml"), turn=1),
    "gz": Kind(recording_files, damaged_archive, lambda f: read_recording(f / "recording.yaml")),
    "ROS 1 bag": Kind(bag_files("drive.bag"), damaged_binary, read_bag_in, turn=BAGS),
    "Duckietown bag": Kind(bag_files("drive.bag", own=False), damaged_binary, read_bag_in, turn=BAGS),
    "MCAP": Kind(bag_files("drive"), damaged_binary, read_bag_in, turn=BAGS),
    "MCAP alone": Kind(without_metadata(bag_files("drive")), damaged_binary, read_bag_in, turn=BAGS),
    "SQLite bag": Kind(bag_files("drive", storage=StoragePlugin.SQLITE3), damaged_binary, read_bag_in, turn=BAGS),
    "tag map": Kind(lambda: {"tags.yaml": TAGS}, damaged_text, lambda f: read_tag_map(f / "tags.yaml")),
    "kinematics": Kind(lambda: {"robot.yaml": KINEMATICS}, damaged_text, lambda f: read_kinematics(f / "robot.yaml")),
    "intrinsics": Kind(camera_files, damaged_text, read_camera),
    "extrinsics": Kind(lambda: {"robot.yaml": EXTRINSICS}, damaged_text, lambda f: read_extrinsics(f / "robot.yaml")),
    "tag image": Kind(picture("tag"), one_of(damaged_binary), look_for_tags, turn=BAGS),
    "board image": Kind(picture("board"), one_of(damaged_binary), look_for_boards, turn=BAGS),
    "board option": Kind(lambda: {"word": b"9x6"}, damaged_text, lambda f: parse_board([(f / "word").read_text("utf-8", "replace")], 0.025), turn=BAGS),
    "journal": Kind(journal_files, damaged_binary, resume),
    "watched run": Kind(journal_files, damaged_text, follow),
    "URDF": Kind(lambda: {"robot.urdf": URDF}, damaged_text, lambda f: read_robot_file(f / "robot.urdf")),
    "SDF": Kind(lambda: {"robot.sdf": SDF}, damaged_text, lambda f: read_robot_file(f / "robot.sdf")),
    "TurtleBot, ROS 1": Kind(turtlebot_files("ros1"), damaged_binary, read_bag_in, turn=BAGS),
    "TurtleBot, MCAP": Kind(turtlebot_files("mcap"), damaged_binary, read_bag_in, turn=BAGS),
    "TurtleBot, MCAP alone": Kind(without_metadata(turtlebot_files("mcap")), damaged_binary, read_bag_in, turn=BAGS),
}  # fmt: skip
IDENTIFY = ("identify", "--json", "{out}/result.json")
COMMANDS: dict[str, tuple[str, ...]] = {
    "scenario": ("validate", "{folder}/full_calibration.yaml"),
    "study": ("validate", "{folder}/study.yaml"),
    "manifest and CSV": (*IDENTIFY, "{folder}/recording.yaml"),
    "fitted recording": (*IDENTIFY, "{folder}/recording.yaml"),
    "gz": (*IDENTIFY, "{folder}/recording.yaml"),
    "Duckietown bag": (*IDENTIFY, "{folder}/drive.bag"),
    "SQLite bag": (*IDENTIFY, "{folder}"),
    "TurtleBot, MCAP": (*IDENTIFY, "{folder}"),
    "TurtleBot, ROS 1": ("recording", "init", "{folder}/drive.bag", "--out", "{out}/recording.yaml"),
    "intrinsics": ("calibrate-camera", "--compare", "{folder}/robot.yaml", "{folder}/robot.yaml", "--json", "{out}/result.json"),
    "tag image": ("focus", "{folder}"),
    "board image": ("calibrate-camera", "{folder}", "--board", "7x4", "--square", "0.02", "--json", "{out}/result.json"),
}  # fmt: skip
"""Commands that are given damaged input of a kind, as their users would give it."""
DOORS = {
    f"{name}, {words[0]}": replace(KINDS[name], read=through(*words), turn=1)
    for name, words in COMMANDS.items()
}
"""The kinds that are read through a command, each answer some tenths of a second."""
__all__ = ["DOORS", "KINDS", "NASTY", "Files", "Kind"]
