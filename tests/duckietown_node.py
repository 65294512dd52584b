"""Starts one of Duckietown's own nodes without a robot: ``/usr/bin/python3 duckietown_node.py NODE.py CARD PORT ...``.

What only a Duckiebot has is stood in for: the motor board sends each motor's PWM to a port of this machine, the robot's
card (``/data``) is a folder, and PyYAML reads a file without being told how, as Noetic's does. The node's code is
Duckietown's, run as its launch file does: ``__ns:=/duckie __name:=NAME`` follow.
"""

import builtins
import enum
import functools
import os
import runpy
import socket
import sys
import types
from unittest import mock

import yaml

CARD = "/data/"
"""Where a Duckiebot's files are."""


class MotorDirection(enum.Enum):
    RELEASE, FORWARD, BACKWARD = 0, 1, -1


def motor_board(port):
    """Return a stand-in of ``hat_driver`` that sends ``NAME PWM``, negative backwards, to a port."""
    link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

    class Motor:
        def __init__(self, name):
            self.name = name

        def set(self, direction, pwm=0):
            link.sendto(f"{self.name} {direction.value * (pwm or 0)}".encode(), ("127.0.0.1", port))

    class Board:
        def get_motor(self, number, name):
            return Motor(name)

    module = types.ModuleType("hat_driver")
    module.MotorDirection, module.from_env = MotorDirection, lambda: Board
    return module


def redirected(function, card):
    """Return a function of a path that finds the robot's files below `card`."""

    @functools.wraps(function)
    def call(path, *arguments, **named):
        if isinstance(path, str) and path.startswith(CARD):
            path = os.path.join(card, path[len(CARD) :])
        return function(path, *arguments, **named)

    return call


def main(node, card, port):
    sys.modules["hat_driver"] = motor_board(port)
    for name in ("dt_robot_utils", "hardware_test_wheels"):
        sys.modules[name] = mock.MagicMock()
    for module, names in ((builtins, ["open"]), (os, ["makedirs"]), (os.path, ["isfile", "exists", "isdir"])):
        for name in names:
            setattr(module, name, redirected(getattr(module, name), card))
    yaml.load = functools.partial(yaml.load, Loader=yaml.SafeLoader)
    runpy.run_path(node, run_name="__main__")


if __name__ == "__main__":
    script, card, port = sys.argv[1:4]
    sys.argv = [script, *sys.argv[4:]]
    main(script, card, int(port))
