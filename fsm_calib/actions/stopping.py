"""Stop the wheels and wait until the robot stands."""

from __future__ import annotations

from fsm_calib.actions.bench import Bench
from fsm_calib.outcome import Outcome
from fsm_calib.types import STOP


def stop_wheels(bench: Bench) -> Outcome:
    """Command zero to both wheels and wait for the settling time."""
    bench.robot.command(STOP)
    bench.robot.wait(bench.settings.drive.settle)
    return Outcome("wheels_stopped", sentence="The wheels are at zero.")
