"""How large a robot is beside those for whom the searches over the floor were made."""

from __future__ import annotations

from fsm_calib.world2d.slots import SMALL_AXLE

STEP_AXLE = 0.1  # m: each more counts for a whole small robot (Husky 0.56: 3.6, Warthog 1.08: 8.8)


def robot_size(half_axle: float) -> float:
    """Return by how much [1] distances on the floor grow for a robot of half axle length `half_axle` [m]; 1 for small
    ones.

    Patches that matter to a large robot are larger, and it drives over more floor: with a small robot's pitch, a
    Warthog's ten minutes have 6000 places to be tried.
    """
    return max(1.0, 1.0 + (2.0 * half_axle - SMALL_AXLE) / STEP_AXLE)
