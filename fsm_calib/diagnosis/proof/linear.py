"""A model linearised where it was fitted: what more columns would win is least squares with robust weights."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fsm_calib.diagnosis.likelihood.robust import SWEEPS, log_kernel, robust_weights
from fsm_calib.types import FloatArray


@dataclass(frozen=True, eq=False)
class Linear:
    """A linearised model: residual (N,), columns (N, m), and priors of the first ones: (offset, spread), 0 for none."""

    residual: FloatArray
    columns: FloatArray
    offset: FloatArray
    spread: FloatArray
    nu: float

    def with_columns(self, columns: FloatArray) -> Linear:
        """Return the model with more free columns, (N,) or (N, k)."""
        more = np.zeros(columns.shape[1] if columns.ndim > 1 else 1)
        return replace(
            self,
            columns=np.column_stack([self.columns, columns]),
            offset=np.append(self.offset, more),
            spread=np.append(self.spread, more),
        )

    def solved(self) -> tuple[FloatArray, FloatArray, float]:
        """Return residual, distance from the priors' centres, and score (log-likelihood up to a constant, priors
        included) at the best numbers.
        """
        scale = np.maximum(np.linalg.norm(self.columns, axis=0), 1e-12)
        x, has_prior = self.columns / scale, self.spread > 0.0
        weight = np.where(has_prior, 1.0 / np.where(has_prior, self.spread, 1.0) ** 2, 0.0)
        numbers = np.zeros(x.shape[1])
        for _ in range(SWEEPS):
            weighted = x * robust_weights(self.residual - x @ numbers, self.nu)[:, None]
            normal = weighted.T @ x + np.diag(weight / scale**2 + 1e-9)
            numbers = np.linalg.solve(normal, weighted.T @ self.residual - weight * self.offset / scale)
        left = self.residual - x @ numbers
        off = self.offset + numbers / scale
        return left, off, float(log_kernel(left, self.nu) - 0.5 * np.sum(weight * off * off))
