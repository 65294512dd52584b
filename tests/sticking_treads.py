"""Treads that stick, written apart from the simulator: how far a body turns whose wheels turn it through play."""

import numpy as np


def turned(turns, twist):
    """Return the heading [rad], (n + 1,), of a body whose wheels would turn it by `turns` (n,) [rad] in each step."""
    ahead, heading = 0.0, np.zeros(len(turns) + 1)
    for i, turn in enumerate(turns, start=1):
        held = float(np.clip(ahead + turn, -twist, twist))
        heading[i], ahead = heading[i - 1] + ahead + turn - held, held
    return heading
