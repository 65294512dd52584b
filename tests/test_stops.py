"""A command that is stopped, or whose parent is gone, says so and leaves nothing half done."""

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from processes import is_alive, worker_of_killed
from ros_rig import DEADLINE, until

from fsm_calib.errors import InputError
from fsm_calib.runner.hold import held
from fsm_calib.stops import Interrupted, on_stop_signals
from fsm_calib.study.orphans import ORPHANED, watch

STOPPED_AT_WORK = """
import os, signal, time
from fsm_calib import cli

signal.signal({number}, signal.SIG_DFL)  # a background job ignores it


def slow():
    os.kill(os.getpid(), {number})
    time.sleep(60)


cli.app = slow
cli.main()
"""


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP])
def test_a_command_that_is_stopped_before_its_work_says_so(number: signal.Signals) -> None:
    code = STOPPED_AT_WORK.format(number=int(number))
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=DEADLINE, check=False
    )
    assert done.returncode == 1
    assert f"fsm-calib: stopped by {number.name} before the end." in done.stderr
    assert "--resume" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_signal_that_was_ignored_stays_ignored() -> None:
    with on_stop_signals(Interrupted):
        ours = signal.getsignal(signal.SIGHUP)
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        with on_stop_signals(Interrupted):
            assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
            assert signal.getsignal(signal.SIGTERM) is not ours
        assert signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGHUP, before)


def test_handlers_are_given_back_after_the_block() -> None:
    before = signal.getsignal(signal.SIGTERM)
    with pytest.raises(Interrupted, match="SIGTERM"), on_stop_signals(Interrupted):
        os.kill(os.getpid(), signal.SIGTERM)
    assert signal.getsignal(signal.SIGTERM) is before


def test_another_thread_changes_no_handler() -> None:
    before, seen = signal.getsignal(signal.SIGTERM), []

    def inside() -> None:
        with on_stop_signals(Interrupted):
            seen.append(signal.getsignal(signal.SIGTERM))

    thread = threading.Thread(target=inside)
    thread.start()
    thread.join()
    assert seen == [before]


def test_a_worker_ends_when_its_parent_is_another_one() -> None:
    parents, waited, ended = iter([7, 7, 1]), [], []
    watch(7, parent_now=lambda: next(parents), end=ended.append, wait=waited.append)
    assert ended == [ORPHANED]
    assert len(waited) == 2


def test_a_worker_of_a_killed_command_ends_at_once(tmp_path: Path) -> None:
    worker = (
        "import os, time; from fsm_calib.study.orphans import end_with; end_with(int({}))\n"
        "open({!r}, 'w').close(); time.sleep(600)"
    )
    mark = tmp_path / "watching"
    code = (
        "import os, subprocess, sys, time\n"
        f"code = {worker!r}.format(os.getpid(), {str(mark)!r})\n"
        "child = subprocess.Popen([sys.executable, '-c', code])\n"
        f"while not os.path.exists({str(mark)!r}): time.sleep(0.01)\n"
        "print(child.pid, flush=True)\n"
        "time.sleep(60)\n"
    )
    pid = worker_of_killed(code)
    until(lambda: not is_alive(pid), "the worker of a killed command ends")


def test_a_second_run_in_a_directory_is_refused_while_the_first_is_at_work(tmp_path: Path) -> None:
    with held(tmp_path), pytest.raises(InputError, match="another run is at work"), held(tmp_path):
        pass
    with held(tmp_path):
        pass
