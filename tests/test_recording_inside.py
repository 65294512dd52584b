"""A manifest reads what lies in its folder, and nothing of others."""

import os
from pathlib import Path

import pytest
from recording_samples import every_channel

from fsm_calib.errors import InputError
from fsm_calib.recording import read_recording
from fsm_calib.recording.inside import named_file
from fsm_calib.recording.writers import write_recording


@pytest.fixture
def manifest(tmp_path: Path) -> Path:
    return write_recording(every_channel(), tmp_path / "data", compress=False)


def renamed(manifest: Path, file: str) -> Path:
    manifest.write_text(manifest.read_text().replace("pose.csv", file))
    return manifest


def test_file_beside_the_manifest_or_below_it_is_read(manifest: Path) -> None:
    (manifest.parent / "deep").mkdir()
    (manifest.parent / "pose.csv").rename(manifest.parent / "deep" / "pose.csv")
    assert read_recording(renamed(manifest, "deep/../deep/pose.csv")).pose is not None


@pytest.mark.parametrize("name", ["../pose.csv", "deep/../../pose.csv"])
def test_name_that_leads_out_of_the_folder_is_refused_with_its_place(manifest: Path, name: str) -> None:
    (manifest.parent / "pose.csv").rename(manifest.parent.parent / "pose.csv")
    with pytest.raises(InputError, match=r"recording\.yaml:\d+:\d+: .* leads out of the manifest's folder"):
        read_recording(renamed(manifest, name))


def test_link_that_leads_out_of_the_folder_is_refused(manifest: Path) -> None:
    (manifest.parent / "pose.csv").rename(manifest.parent.parent / "pose.csv")
    (manifest.parent / "pose.csv").symlink_to("../pose.csv")
    with pytest.raises(InputError, match="leads out"):
        read_recording(manifest)


def test_folder_that_is_reached_by_a_link_is_a_folder_like_others(manifest: Path, tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(manifest.parent)
    assert read_recording(tmp_path / "link").pose is not None


def test_whole_path_of_a_file_of_ones_own_is_read(manifest: Path, tmp_path: Path) -> None:
    (manifest.parent / "pose.csv").rename(tmp_path / "pose.csv")
    assert read_recording(renamed(manifest, str(tmp_path / "pose.csv"))).pose is not None


@pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() != 0, reason="only root can give a file away")
def test_whole_path_of_another_users_file_is_refused(manifest: Path, tmp_path: Path) -> None:
    (manifest.parent / "pose.csv").rename(tmp_path / "pose.csv")
    os.chown(tmp_path / "pose.csv", 65534, 65534)
    with pytest.raises(InputError, match="belongs to another user"):
        read_recording(renamed(manifest, str(tmp_path / "pose.csv")))


@pytest.mark.parametrize(
    "text",
    ["format: fsm-calib/recording@1\nbag: ../drive.bag\n",
     "format: fsm-calib/recording@1\nrobot: {urdf: ../robot.urdf}\n"
     "channels:\n  pose: {file: pose.csv, time: time, x: x, y: y}\n"],
)  # fmt: skip
def test_bags_and_descriptions_are_held_to_the_same(tmp_path: Path, text: str) -> None:
    path = tmp_path / "recording.yaml"
    path.write_text(text)
    with pytest.raises(InputError, match="leads out"):
        read_recording(path)


@pytest.mark.parametrize("name", ["a\0b", "loop"])
def test_name_that_cannot_be_followed_is_refused(tmp_path: Path, name: str) -> None:
    (tmp_path / "loop").symlink_to("loop")
    with pytest.raises(InputError, match=r"recording\.yaml:1:1"):
        named_file(tmp_path / "recording.yaml", name, "recording.yaml:1:1")
