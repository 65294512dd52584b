"""What tests of robots share: masters (the small one; Debian's where it is installed), waiting on a condition."""

from __future__ import annotations

import shutil
import socket
import subprocess
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest

from fsm_calib.errors import LinkLost
from fsm_calib.robots.ros1.calls import Caller
from fsm_calib.robots.ros1.master import Master

DEADLINE = 240.0
"""Longest wait for something that must happen [s]: far beyond what a starved machine needs."""
NO_ROS = "Debian's ros-core is not installed (apt-get install ros-core python3-rosbag python3-sensor-msgs)"


def until(condition: Callable[[], object], what: str, deadline: float = DEADLINE) -> None:
    """Return as soon as `condition` holds; fail when it does not in time."""
    end, pause = time.monotonic() + deadline, threading.Event()
    while not condition():
        if time.monotonic() > end:
            pytest.fail(f"not within {deadline:g} s: {what}")
        pause.wait(0.005)


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as server:
        return int(server.getsockname()[1])


@contextmanager
def small_master() -> Iterator[str]:
    master = Master()
    try:
        yield master.url
    finally:
        master.close()


@contextmanager
def debian_master() -> Iterator[str]:
    if shutil.which("rosmaster") is None:
        pytest.skip(NO_ROS)
    port = free_port()
    process = subprocess.Popen(
        ["rosmaster", "--core", "-p", str(port)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    url = f"http://127.0.0.1:{port}/"
    try:
        until(lambda: answers(url), "the master answers")
        yield url
    finally:
        process.kill()
        process.wait()


MASTERS = {"small": small_master, "debian": debian_master}


def answers(url: str) -> bool:
    try:
        Caller(url, "the ROS master").call("getPid", "/test")
    except LinkLost:
        return False
    return True
