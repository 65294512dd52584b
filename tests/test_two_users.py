"""Two users share a machine: what one leaves in shared places is neither read nor run by the other's commands."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from ros_rig import DEADLINE
from typer.testing import CliRunner

from fsm_calib.cli import app
from fsm_calib.commands.strangers import READ_UNASKED, refuse_settings_of_others
from fsm_calib.errors import InputError

STRANGER = 65534
needs_root = pytest.mark.skipif(
    not hasattr(os, "getuid") or os.getuid() != 0, reason="only root can plant another user's file"
)
SCENARIO = """
name: shared
seed: 4
robot: {source: nominal, wheel_ratio: 1.05, known: {camera: true}}
plan: [orientation]
output: {frames: 1}
"""
WATCHED = """
import json, os, sys

seen = []

def watch(event, given):
    if event == "open" and isinstance(given[0], str) and os.path.exists(given[0]):
        if os.stat(given[0]).st_uid == STRANGER:
            seen.append(given[0])

sys.addaudithook(watch)
from fsm_calib.cli import main

try:
    main()
finally:
    with open(SEEN, "w") as file:
        json.dump(seen, file)
"""


def planted(path: Path, text: str = "") -> Path:
    """A file of the other user."""
    path.parent.mkdir(exist_ok=True)
    path.write_text(text)
    os.chown(path, STRANGER, STRANGER)
    return path


@needs_root
@pytest.mark.parametrize("name", READ_UNASKED)
def test_no_command_begins_where_another_user_has_put_settings_of_libraries(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    planted(tmp_path / name)
    monkeypatch.chdir(tmp_path)
    result = CliRunner().invoke(app, ["schema"])
    assert result.exit_code == 2
    assert f"{name}: another user can write this file" in result.stderr


@needs_root
def test_a_link_to_settings_of_another_user_is_refused(tmp_path: Path) -> None:
    (tmp_path / "matplotlibrc").symlink_to(planted(tmp_path / "elsewhere" / "settings"))
    with pytest.raises(InputError, match="another user"):
        refuse_settings_of_others(tmp_path)


@needs_root
def test_another_users_link_to_our_settings_is_refused(tmp_path: Path) -> None:
    (tmp_path / "settings").touch()
    (tmp_path / "matplotlibrc").symlink_to(tmp_path / "settings")
    os.lchown(tmp_path / "matplotlibrc", STRANGER, STRANGER)
    with pytest.raises(InputError, match="another user"):
        refuse_settings_of_others(tmp_path)


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="this system has no user ids")
def test_settings_that_everybody_can_write_are_refused(tmp_path: Path) -> None:
    (tmp_path / "matplotlibrc").touch()
    (tmp_path / "matplotlibrc").chmod(0o666)
    with pytest.raises(InputError, match="another user"):
        refuse_settings_of_others(tmp_path)


def test_settings_of_our_own_and_a_link_to_nowhere_are_no_reason_to_refuse(tmp_path: Path) -> None:
    (tmp_path / "matplotlibrc").touch(mode=0o644)
    (tmp_path / ".numba_config.yaml").symlink_to(tmp_path / "nowhere")
    refuse_settings_of_others(tmp_path)


def test_a_working_directory_cannot_name_a_folder_of_compiled_code_later_on() -> None:
    """What the environment says counts before what the file says, and the file may come after the start."""
    assert "NUMBA_CACHE_DIR" in os.environ


@needs_root
def test_a_run_in_a_shared_directory_opens_nothing_that_another_user_left_there(tmp_path: Path) -> None:
    shared, own, seen = tmp_path / "shared", tmp_path / "own", tmp_path / "seen.json"
    for folder in (shared, own):
        folder.mkdir()
    shared.chmod(0o1777)
    raising = "raise SystemExit('planted code runs')\n"
    for name in ("numpy", "yaml", "fsm_calib", "sitecustomize", "numba", "typing"):
        planted(shared / f"{name}.py", raising)
    planted(shared / "fsm_calib-0" / "fsm_calib_kernel.py", raising)
    planted(shared / "numba_cache" / "kernel.run-1.py311.nbi", "no index")
    (own / "scenario.yaml").write_text(SCENARIO)
    (own / "command").write_text(f"STRANGER, SEEN = {STRANGER}, {str(seen)!r}\n{WATCHED}")
    subprocess.run(
        [sys.executable, str(own / "command"), "run", str(own / "scenario.yaml"), "--out", str(own / "out")],
        cwd=shared,
        env={**os.environ, "TMPDIR": str(shared)},
        check=True,
        capture_output=True,
        timeout=DEADLINE,
    )
    assert (own / "out" / "report.html").exists()
    assert json.loads(seen.read_text()) == []
