"""Which candidates of a scan are worth a fit? The most promising ones that are not the same one twice."""

from __future__ import annotations

import math

import numpy as np

from fsm_calib.types import FloatArray


def apart(promise: FloatArray, position: FloatArray, keep: int, distance: float) -> list[int]:
    """Return the places of the most promising candidates, best first, each far from all before it.

    promise : (m,); position : (m, d), of place or time; keep : at most so many; distance : which two kept ones exceed.
    """
    kept: list[int] = []
    for i in np.argsort(-promise).tolist():
        if len(kept) == keep:
            break
        if all(math.dist(position[i], position[k]) > distance for k in kept):
            kept.append(i)
    return kept
