"""The compiled simulation is kept where nobody else can put a file, or nowhere."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from ros_rig import DEADLINE

from fsm_calib.world2d import kernel as kernel_module
from fsm_calib.world2d.kernel import kernel, woven_source
from fsm_calib.world2d.private_folder import is_private, private_folder

pytestmark = pytest.mark.skipif(not hasattr(os, "getuid"), reason="this system has no user ids")
STRANGER = 65534
needs_root = pytest.mark.skipif(
    hasattr(os, "getuid") and os.getuid() != 0, reason="only root can plant another user's file"
)


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("FSM_CALIB_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> str:
    """A woven text that compiles in no time, in place of the simulation."""
    text = "from numba import njit\n@njit(nogil=True, cache=True)\ndef run(x):\n    return x + 1\n"
    monkeypatch.setattr(kernel_module, "woven_source", lambda bare=False: text)
    return text


def fresh() -> object:
    return kernel.__wrapped__()


def kept_file(home: Path) -> Path:
    return next(home.glob("*/kernel.py"))


def test_folder_is_made_for_its_user_alone(home: Path) -> None:
    folder = private_folder("kept")
    assert folder is not None
    assert folder.stat().st_mode & 0o777 == 0o700


def test_folder_that_others_may_enter_is_not_used(home: Path) -> None:
    (home / "kept").mkdir(parents=True)
    (home / "kept").chmod(0o755)
    assert private_folder("kept") is None


def test_folder_is_not_used_where_others_can_exchange_it(home: Path) -> None:
    home.mkdir()
    home.chmod(0o777)
    assert private_folder("kept") is None
    home.chmod(0o1777)  # sticky: others cannot rename what is not theirs
    assert private_folder("kept") is not None


def test_link_in_the_folder_is_not_trusted(home: Path, tmp_path: Path) -> None:
    folder = private_folder("kept")
    assert folder is not None
    (folder / "kernel.py").symlink_to(tmp_path / "elsewhere.py")
    assert private_folder("kept") is None


@needs_root
def test_foreign_folder_or_file_is_not_used(home: Path) -> None:
    folder = private_folder("kept")
    assert folder is not None
    (folder / "kernel.py").touch()
    os.chown(folder / "kernel.py", STRANGER, STRANGER)
    assert private_folder("kept") is None
    (folder / "kernel.py").unlink()
    assert private_folder("kept") == folder
    os.chown(folder, STRANGER, STRANGER)
    assert not is_private(folder)


def test_planted_module_never_runs(home: Path, small: str, tmp_path: Path) -> None:
    assert fresh().run(1) == 2
    seen = tmp_path / "seen"
    planted = kept_file(home)
    planted.write_text(f"open({str(seen)!r}, 'w')\ndef run(x):\n    return 666\n")
    assert fresh().run(1) == 2
    assert not seen.exists()
    assert kept_file(home).read_text() == small


def test_compiled_code_of_another_text_goes_with_it(home: Path, small: str) -> None:
    assert fresh().run(1) == 2
    compiled = set(kept_file(home).parent.glob("__pycache__/*"))
    assert compiled
    kept_file(home).write_text("planted")
    fresh()
    assert not any(file.exists() for file in compiled)


def test_same_text_finds_its_compiled_code(home: Path, small: str) -> None:
    fresh().run(1)
    again = fresh()
    assert again.run(1) == 2
    assert sum(again.run.stats.cache_hits.values()) == 1


def test_code_is_kept_nowhere_else_by_the_users_own_setting(
    home: Path, small: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("numba.config.CACHE_DIR", str(tmp_path / "shared"))
    fresh().run(1)
    assert not (tmp_path / "shared").exists()
    assert list(kept_file(home).parent.glob("__pycache__/*.nbc"))


def test_without_a_private_folder_the_text_runs_from_memory(
    small: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("FSM_CALIB_CACHE", str(tmp_path / "file"))
    assert fresh().run(1) == 2
    assert "FSM_CALIB_CACHE" in caplog.text


@needs_root
def test_module_planted_in_the_shared_temporary_folder_never_runs(tmp_path: Path) -> None:
    """The attack: a user without a writable home, and a stranger who knows the names."""
    import hashlib

    tmp_path.chmod(0o1777)
    seen, source = tmp_path / "seen", woven_source(bare=True)
    digest = hashlib.sha256(source.encode()).hexdigest()
    folder = tmp_path / "fsm_calib-0"
    folder.mkdir()
    os.chown(folder, STRANGER, STRANGER)
    for name in (digest, digest[:20]):
        (folder / f"fsm_calib_kernel_{name}.py").write_text(f"open({str(seen)!r}, 'w')\n")
    (tmp_path / "no_home").touch()
    environment = {**os.environ, "TMPDIR": str(tmp_path), "FSM_CALIB_CACHE": str(tmp_path / "no_home")}
    code = "from fsm_calib.world2d.kernel import kernel; kernel(bare=True)"
    subprocess.run(
        [sys.executable, "-c", code], env=environment, check=True, capture_output=True, timeout=DEADLINE
    )
    assert not seen.exists()
