"""A program that drives under the guard's eyes, for tests that kill it: ``python guarded_program.py ADDRESS [hang]``.

It writes the guard's process number and then drives until it is stopped; with ``hang`` it then computes for ever.
"""

from __future__ import annotations

import json
import signal
import sys

from fsm_calib.errors import RobotLost
from fsm_calib.robots.address import parse_address
from fsm_calib.robots.guard.setup import GuardSetup
from fsm_calib.robots.ros1.robot import Ros1Robot
from fsm_calib.types import WheelCommand


def main(address: str, hangs: bool) -> None:
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a background job ignores it
    robot = Ros1Robot(GuardSetup(parse_address(address), fence=1000.0), lambda body: None)
    try:
        robot.command(WheelCommand(0.3, 0.3))
        print(json.dumps({"guard": robot.guard.pid}), flush=True)
        while hangs:
            pass
        while True:
            robot.wait(1.0)
    except RobotLost as lost:
        print(json.dumps({"lost": type(lost).__name__, "problem": lost.problem}), flush=True)
    finally:
        robot.close()


if __name__ == "__main__":
    main(sys.argv[1], "hang" in sys.argv)
