r"""How the robot answers when its wheels are driven a little differently: exact columns for shapes without a name.

    column = [increments(u + h f / w) - increments(u)] / h

f [m/s] what a shape adds to each wheel's speed ahead of the motors, held over each interval between events; w [m/s]
rim speed of command 1; u [1] the recorded commands; h [1] small. The roll-out itself carries it through motors,
tyres and body, as it carries a named effect: shapes are not at a disadvantage for being written down to first order.
Effects that shape the command are switched off for this: beyond a limit, more command would change nothing.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fsm_calib.diagnosis.fitting.values import switched_off
from fsm_calib.diagnosis.replay.simulator import Simulator
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table
from fsm_calib.world2d.rollout import Drive

DIFFERENCE = 0.02  # of a shape: small beside the commands, large beside rounding


def driven(simulator: Simulator, values: FloatArray, left: FloatArray, right: FloatArray) -> FloatArray:
    """Return what the increments of one recording change by.

    Parameters
    ----------
    values : parameters (p,). left, right : shapes (n, m) [m/s] of each wheel, one row for each interval that ends at
        an event.

    Returns
    -------
    array, shape (n, 5, m)
    """
    acting = [n for n in parameter_table().active_effects(values) if "shape" in registry()[n].hooks]
    plain = switched_off(values[None], acting)
    drive, p = simulator.drive, simulator.prepared
    begins = np.append(p.time[0], p.time[:-1])
    time = np.unique(np.concatenate([drive.time, begins, p.time[-1:]]))
    held = np.searchsorted(drive.time, time, side="right") - 1
    base = [np.where(held >= 0, u[np.maximum(held, 0)], 0.0) for u in (drive.left, drive.right)]
    interval = np.searchsorted(p.time, time, side="right")
    inside = (interval > 0) & (interval < len(p.time))
    interval = np.where(inside, interval, 0)
    before = replace(simulator, drive=Drive(time, *base)).increments(plain)[0]
    out = np.empty((*before.shape, left.shape[1]))
    for j in range(left.shape[1]):
        more = [
            np.where(inside, f[interval, j], 0.0) * (DIFFERENCE / simulator.full_speed) for f in (left, right)
        ]
        moved = replace(simulator, drive=Drive(time, base[0] + more[0], base[1] + more[1]))
        out[:, :, j] = (moved.increments(plain)[0] - before) / DIFFERENCE
    return out
