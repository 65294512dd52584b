"""Wheel primitives: one push of one wheel, one straight drive; each ends with the wheels at zero and at
rest.
"""

from __future__ import annotations

from fsm_calib.actions.bench import Bench
from fsm_calib.types import WheelCommand

CLOCKWISE, COUNTERCLOCKWISE = "clockwise", "counterclockwise"


def run_wheels(bench: Bench, command: WheelCommand, duration: float, settle: float) -> None:
    """Apply `command` for `duration` [s], stop, and wait for `settle` [s]."""
    bench.robot.run(command, duration)
    bench.robot.wait(settle)


def push(bench: Bench, way: str, command: float, *, reverse: bool = False) -> None:
    """Turn with one wheel for one quantum (paper, section 3.2).

    The left wheel does it, forward for clockwise and backward for counter-clockwise: the robot pivots about
    the right wheel's contact and a sweep back ends where it began, whatever the number of sweeps.
    """
    turn = bench.settings.turn
    signed = command if (way == CLOCKWISE) is not reverse else -command
    run_wheels(bench, WheelCommand(signed, 0.0), turn.quantum, turn.settle)


def drive(bench: Bench, duration: float, ratio: float, *, backward: bool = False) -> None:
    """Drive straight for `duration` [s] with right command = `ratio` x left command."""
    settings = bench.settings.drive
    left = bench.notebook.drive_command or settings.command
    signed = -left if backward else left
    run_wheels(bench, WheelCommand(signed, signed * ratio), duration, settings.settle)
