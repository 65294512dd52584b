"""What tests of processes ask of the operating system."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path


def worker_of_killed(code: str) -> int:
    """Run Python code that prints the number of a worker process first, kill it then, and return that number."""
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as command:
        assert command.stdout is not None
        pid = int(command.stdout.readline())
        command.kill()
    return pid


def is_alive(pid: int) -> bool:
    """Tell whether a process is there and no zombie that nobody has collected."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False
