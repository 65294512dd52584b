"""Compile ahead of use: the compiled program is kept, so that later processes only load it."""

from __future__ import annotations

import numpy as np
import pymunk

from fsm_calib.world2d.body import RobotBody
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import null_parameters, typical_parameters
from fsm_calib.world2d.rollout import Drive, simulate

GRID = 0.1
"""Time between the samples of a roll-out that is only to be compiled [s]."""


def compile_world() -> None:
    """Compile the step of a simulated robot and the roll-out, without effects and with all of them."""
    drive, samples = Drive(np.zeros(1), np.ones(1), np.ones(1)), np.arange(0.0, 1.0, GRID)
    hooked = next(effect for effect in registry().values() if "step" in effect.hooks)
    RobotBody(pymunk.Space(), null_parameters())
    for parameters in (null_parameters(), typical_parameters(hooked)):
        simulate(parameters, drive, samples, (0.0, 0.0, 0.0))
