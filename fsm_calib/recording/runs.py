"""Stretches of rows for which something holds."""

from __future__ import annotations

import numpy as np


def runs_of(holds: np.ndarray) -> list[tuple[int, int]]:
    """Return where each unbroken run of true values begins and where it has ended; `holds` is of shape (n,), bool."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], holds.astype(int), [0]])))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))
