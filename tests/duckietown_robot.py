"""A Duckiebot of Duckietown's own nodes, for tests: its wheel driver and kinematics, behind Debian's master.

``FSM_CALIB_DUCKIETOWN`` names a folder with checkouts of dt-duckiebot-interface, dt-car-interface and dt-ros-commons
(branch daffy). They are GPL: nothing of them is here.
"""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
import yaml
from ros_rig import NO_ROS, debian_master, until

from fsm_calib.robots.ros1.calls import Caller

PYTHON = "/usr/bin/python3"
"""Debian's own, which has rospy."""
VARIABLE = "FSM_CALIB_DUCKIETOWN"
NODES = {
    "wheels_driver_node": "dt-duckiebot-interface/packages/wheels_driver/src/wheels_driver_node.py",
    "kinematics_node": "dt-car-interface/packages/dagu_car/src/kinematics_node.py",
}
LIBRARIES = (
    "dt-ros-commons/packages/duckietown/include",
    "dt-duckiebot-interface/packages/wheels_driver/include",
)
MESSAGES = "dt-ros-commons/packages/duckietown_msgs"
DEFAULTS = {"gain": 1.0, "trim": 0.0, "baseline": 0.1, "radius": 0.0318, "k": 27.0, "limit": 1.0}
"""Kinematics of a robot from the factory, as the node's default.yaml has them."""
CALIBRATION = "config/calibrations/kinematics/duckie.yaml"
"""Where the kinematics node saves, below the card's folder."""


def checkouts() -> Path:
    """Return the folder of the checkouts; skip the test where something is missing."""
    if VARIABLE not in os.environ:
        pytest.skip(f"{VARIABLE} names no folder with Duckietown's checkouts (docs/robot.md)")
    folder = Path(os.environ[VARIABLE])
    missing = [path for path in (*NODES.values(), *LIBRARIES, MESSAGES) if not (folder / path).exists()]
    if missing:
        pytest.fail(f"{VARIABLE}={folder} has no {missing[0]}: check out branch daffy")
    packages = "import rospy, std_srvs.srv, humanfriendly"
    if shutil.which("rosmaster") is None or subprocess.run([PYTHON, "-c", packages], check=False).returncode:
        pytest.skip(f"{NO_ROS}; with them python3-rospy python3-std-srvs python3-humanfriendly")
    return folder


def generate_messages(source: Path, target: Path) -> None:
    """Write Duckietown's messages and services as Python; those that need other packages are left out."""
    standard = target / "definitions"
    standard.mkdir(parents=True)
    (standard / "Header.msg").write_text("uint32 seq\ntime stamp\nstring frame_id\n")
    package = target / "duckietown_msgs"
    for kind, script in (("msg", "genmsg_py.py"), ("srv", "gensrv_py.py")):
        command = [PYTHON, f"/usr/lib/genpy/{script}", "-p", "duckietown_msgs", "-o", str(package / kind)]
        search = [f"-Iduckietown_msgs:{source / 'msg'}", f"-Istd_msgs:{standard}"]
        files = sorted(str(path) for path in (source / kind).glob(f"*.{kind}"))
        subprocess.run([*command, *search, *files], capture_output=True, check=False)
        subprocess.run([*command, "--initpy"], check=True)
    (package / "__init__.py").touch()


@dataclass(eq=False)
class DuckietownRobot:
    """Duckietown's nodes, and what their motor board was told."""

    master: str
    card: Path
    environment: dict[str, str]
    folder: Path
    pwm: list[tuple[str, int]] = field(default_factory=list)
    """(``left`` or ``right``, PWM with its sign) in the order in which the driver set them."""
    turned: Callable[[str, int], None] = lambda side, pwm: None
    """Is told each of them."""

    def __post_init__(self) -> None:
        """Open the motor board's port."""
        self._board = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._board.bind(("127.0.0.1", 0))
        self._running: dict[str, subprocess.Popen[bytes]] = {}
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        while True:
            try:
                side, pwm = self._board.recv(100).decode().split()
            except (OSError, ValueError):
                return
            self.pwm.append((side, int(pwm)))
            self.turned(side, int(pwm))

    @property
    def saved(self) -> dict[str, Any]:
        """What the robot's card holds of the kinematics."""
        return dict(yaml.safe_load((self.card / CALIBRATION).read_text()))

    def parameter(self, name: str) -> float:
        """Return a parameter of the kinematics node, as the master knows it."""
        return float(self.caller.call("getParam", "/test", f"/duckie/kinematics_node/{name}"))

    @property
    def caller(self) -> Caller:
        """The master."""
        return Caller(self.master, "the ROS master")

    def start(self, name: str) -> None:
        """Start one of the nodes, and wait until it offers what it is there for."""
        launcher = Path(__file__).with_name("duckietown_node.py")
        port = self._board.getsockname()[1]
        script = str(self.folder / NODES[name])
        self._running[name] = subprocess.Popen(
            [PYTHON, str(launcher), script, str(self.card), str(port), "__ns:=/duckie", f"__name:={name}"],
            env=self.environment,
            stdout=(self.card / f"{name}.log").open("wb"),
            stderr=subprocess.STDOUT,
        )
        until(lambda: self._offers(name), f"{name} is up; see {self.card / name}.log")

    def _offers(self, name: str) -> bool:
        """Tell whether a node has made its last service or subscription."""
        if self._running[name].poll() is not None:
            pytest.fail((self.card / f"{name}.log").read_text())
        _, heard, _ = self.caller.call("getSystemState", "/test")
        last = {"wheels_driver_node": "emergency_stop", "kinematics_node": "car_cmd"}[name]
        return any(topic == f"/duckie/{name}/{last}" for topic, _ in heard)

    def end(self, name: str) -> None:
        """End one of the nodes."""
        process = self._running.pop(name)
        process.terminate()
        process.wait()

    def close(self) -> None:
        """End all of it."""
        for name in list(self._running):
            self.end(name)
        self._board.close()


@contextmanager
def duckietown_robot(folder: Path, scratch: Path) -> Iterator[DuckietownRobot]:
    """Duckietown's nodes as on a robot from the factory."""
    generate_messages(folder / MESSAGES, scratch / "generated")
    card = scratch / "card"
    (card / CALIBRATION).parent.mkdir(parents=True)
    libraries = [str(scratch / "generated"), *(str(folder / path) for path in LIBRARIES)]
    with debian_master() as url:
        environment = {
            **os.environ,
            "PYTHONPATH": os.pathsep.join(libraries),
            "ROS_MASTER_URI": url,
            "ROS_HOSTNAME": "127.0.0.1",
            "DT_DIAGNOSTICS": "0",
        }
        robot = DuckietownRobot(url, card, environment, folder)
        for name, value in (DEFAULTS | {"v_max": 1.0, "omega_max": 8.0}).items():
            robot.caller.call("setParam", "/test", f"/duckie/kinematics_node/{name}", value)
        try:
            for name in NODES:
                robot.start(name)
            yield robot
        finally:
            robot.close()
