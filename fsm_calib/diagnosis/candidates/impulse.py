r"""Which impulse brings about what was seen after a moment? Found by simulation, as a push is not linear.

    J <- J + argmin_s |w (r(J) - C s)|^2        C_i = (f(J + d_i) - f(J)) / |d_i|,  r(J) = r(0) - f(J)

J [N s, N s, N m s] the impulse in two directions and about the vertical; f(J) what it changes in the whitened
increments of the seconds in which it shows, in one recording or in all of them, r their residual, w the robust weights;
d_i a nudge along each of the three, of a size that moves a robot. A robot that stands, or that is pushed sideways, does
not move until dry friction or its tyres give way, and the motors of one robot hold it a hundred times as stiffly as
those of another: a rule for the first guess misses by as much. Source: Gauss-Newton with secants, halved while it makes
things worse.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fsm_calib.diagnosis.candidates.scan_pushes import fitted
from fsm_calib.diagnosis.likelihood.robust import log_kernel
from fsm_calib.types import FloatArray

ROUNDS = 3  # of Gauss-Newton: what is left of a push is fitted in full anyway
HALVINGS = 2
NUDGE = 0.2  # of the impulse so far, the size of the next nudges


@dataclass(frozen=True, eq=False)
class Impulse:
    """The search for an impulse.

    changed : takes impulses (3,), returns what each changes (n, m), whitened; white : (n,) the whitened innovations;
    nu : of their Student's t; nudge : (3,) impulses that move a robot; high : (3,) the largest that are looked for.
    """

    changed: Callable[[list[FloatArray]], FloatArray]
    white: FloatArray
    nu: float
    nudge: FloatArray
    high: FloatArray

    def most_won(self, rounds: int = ROUNDS) -> tuple[FloatArray, float]:
        """Return the impulse (3,) that wins most after some rounds, and the log-likelihood that it wins."""
        impulse: FloatArray = np.zeros(3)
        done: FloatArray = np.zeros(len(self.white))
        won, nudge = 0.0, self.nudge
        for _ in range(rounds):
            ahead = self.changed([impulse + d for d in np.diag(nudge)]) - done[:, None]
            step = fitted(ahead / nudge, self.white - done, self.nu)[1]
            better = self._uphill(impulse, step, won)
            if better is None:
                break
            impulse, done, won = better
            nudge = np.maximum(NUDGE * np.abs(impulse), NUDGE * self.nudge)
        return impulse, won

    def _uphill(
        self, impulse: FloatArray, step: FloatArray, won: float
    ) -> tuple[FloatArray, FloatArray, float] | None:
        """Return the impulse after a step, what it changes and wins; None where no part of the step wins more."""
        tried = [np.clip(impulse + 0.5**k * step, -self.high, self.high) for k in range(HALVINGS + 1)]
        changed = self.changed(tried)
        wins = self.wins(changed)
        best = int(np.argmax(wins))
        return (tried[best], changed[:, best], float(wins[best])) if wins[best] > won else None

    def wins(self, changed: FloatArray) -> FloatArray:
        """Return the log-likelihood (m,) that changes (n, m) win as they stand."""
        before = log_kernel(self.white, self.nu)
        return np.array([log_kernel(self.white - column, self.nu) - before for column in changed.T])
