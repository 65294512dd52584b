"""Child processes of the campaign of runs: forked from one that has everything imported, so that each starts at once."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

LONGEST_CHILD = 300.0  # s of wall time


class Hang(Exception):
    """A child did not end."""


@dataclass
class Child:
    """A child process, where what it says goes, and its exit code once it has ended (negative: the signal)."""

    number: int
    log: Path
    code: int | None = None

    def is_running(self) -> bool:
        """Tell whether it has not ended, and keep its code when it has."""
        if self.code is None:
            ended, status = os.waitpid(self.number, os.WNOHANG)
            if ended:
                self.code = os.waitstatus_to_exitcode(status)
        return self.code is None

    def send(self, number: int) -> bool:
        """Send a signal; False where it had ended."""
        if not self.is_running():
            return False
        os.kill(self.number, number)
        return True

    def wait(self, seconds: float = LONGEST_CHILD) -> Child:
        """Wait for its end.

        Raises
        ------
        Hang
            It took longer than `seconds`; it is killed.
        """
        until = time.monotonic() + seconds
        while self.is_running():
            if time.monotonic() > until:
                self.send(signal.SIGKILL)
                os.waitpid(self.number, 0)
                raise Hang(f"no end after {seconds:.0f} s")
            time.sleep(0.005)
        return self

    def stderr(self) -> str:
        """Return what it said on standard error."""
        return (self.log / "stderr").read_text("utf-8", "replace")


def command(arguments: list[str], before: Callable[[], None] = lambda: None) -> Callable[[], int]:
    """Return what runs `fsm-calib ARGUMENTS` in a child, after `before` there, and returns the exit code."""

    def run() -> int:
        from fsm_calib.cli import main

        before()
        sys.argv = ["fsm-calib", *arguments]
        try:
            main()
        except SystemExit as end:
            return end.code if isinstance(end.code, int) else int(end.code is not None)
        return 0

    return run


def started(work: Callable[[], int], log: Path) -> Child:
    """Start a child that does `work` and ends with the code that it returns; what it says goes to `log`."""
    log.mkdir(parents=True, exist_ok=True)
    number = os.fork()
    if number:
        return Child(number, log)
    code = 70
    try:
        for name, descriptor in (("stdout", 1), ("stderr", 2)):
            os.dup2(os.open(log / name, os.O_CREAT | os.O_TRUNC | os.O_WRONLY, 0o600), descriptor)
        signal.signal(signal.SIGINT, signal.default_int_handler)
        code = work()
    except BaseException:
        traceback.print_exc()
    finally:
        with contextlib.suppress(OSError, ValueError):
            sys.stdout.flush()
        with contextlib.suppress(OSError, ValueError):
            sys.stderr.flush()
        os._exit(code)
