"""A headless Chromium for tests, where there is one."""

import shutil
import subprocess

import pytest

PROGRAM = next(
    (path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))), None
)
needs_browser = pytest.mark.skipif(
    PROGRAM is None, reason="no Chromium here (Debian: apt-get install chromium)"
)


def page_after_scripts(address: str, tmp_path, budget_ms: int = 5000) -> str:
    """Return the document of a page as it is after its scripts have run for `budget_ms` of its own time."""
    command = [
        PROGRAM, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path / 'profile'}",
        f"--virtual-time-budget={budget_ms}", "--dump-dom", address,
    ]  # fmt: skip
    return subprocess.run(command, capture_output=True, text=True, check=True, timeout=60).stdout
