r"""How sure is a gap in evidence under models that are all somewhat wrong? By its spread over blocks of a second.

    gap = 2 (log L_a - log L_b) - (k_a - k_b) ln N
    spread^2 = 4 n/(n - 1) sum_j (d_j - mean d)^2          d_j = log L_a - log L_b of block j
    P(a is nearer to the truth than b) = F(gap / sqrt(spread^2 + LOGISTIC^2))

log L [1] of the recordings at each model's own noise, k free numbers, N innovations, n blocks. F is Student's t: the
spread itself is known from n blocks alone, LOGISTIC is known (degrees of freedom by Welch & Satterthwaite), so that few
seconds convince less than many; beyond half a minute F is the normal curve. Under right models the
spread is about 2 sqrt(gap) and the probability that of the odds exp(gap / 2) (LOGISTIC: the normal curve nearest to
the logistic one of these odds); under wrong ones the drives' seconds disagree, and the spread says by how much.
What has a place or a time adds its evidence in few seconds by nature. Its spread is that about the line

    d_j = a + b e_j,    e_j = sum (nu + 1) / 2 log(1 + x^2 / (nu - 2))        x [1] the whitened change that it makes

e_j what second j adds where the change is all there was to see: evidence that comes as the effect acts is no patch.
Source: Vuong, Econometrica 57 (1989) 307; Kishino & Hasegawa, J. Mol. Evol. 29 (1989) 170 (RELL).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import stdtr

from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.likelihood.robust import log_density
from fsm_calib.diagnosis.replay.prepared import Prepared
from fsm_calib.types import FloatArray

TOLD_APART = 0.95  # probability with which a name must beat a rival that is not to stand beside it in a set
BLOCK = 1.0  # s: longer than the memory of the disturbances, shorter than a manoeuvre
LOGISTIC = 3.4  # units of evidence: 2 x 1.7, where a normal curve comes nearest to a logistic one (Johnson & Kotz 1970)


@dataclass(frozen=True, slots=True)
class Gap:
    """Evidence of one model over another, how much it varies from second to second, and of how many that is known."""

    evidence: float
    spread: float
    blocks: int

    @property
    def probability(self) -> float:
        """The probability that the first of the two is nearer to the truth."""
        return self.probability_within(0.0)

    def probability_within(self, inexact: float) -> float:
        """Return that probability where equations are inexact by so much evidence."""
        seen, known = self.spread**2, LOGISTIC**2 + inexact**2
        freedom = max(self.blocks - 1, 1) * ((seen + known) / max(seen, 1e-9)) ** 2
        return float(stdtr(freedom, self.evidence / np.sqrt(seen + known)))


def gap_between(engine: Engine, first: Fit, second: Fit) -> Gap:
    """Return the evidence of one fit over another, both of the same recordings."""
    differences = block_sums(engine, first) - block_sums(engine, second)
    return Gap(_evidence(engine, first, second), _spread(differences), len(differences))


def gap_where_it_acts(engine: Engine, whole: Fit, less: Fit) -> Gap:
    """Return the gap to the fit without an effect of a place or a time, with its spread about where that acts."""
    added, acts = block_sums(engine, whole) - block_sums(engine, less), _changes(engine, whole, less)
    vary = min(np.ptp(added), np.ptp(acts)) > 0.0
    together = max(float(np.corrcoef(added, acts)[0, 1]), 0.0) if vary else 0.0
    spread = _spread(added) * float(np.sqrt(max(1.0 - together**2, 0.0)))
    return Gap(_evidence(engine, whole, less), spread, len(added))


def _evidence(engine: Engine, first: Fit, second: Fit) -> float:
    """Return the evidence of one fit over another, by their scores and how many numbers they free."""
    cost = (len(first.slots) - len(second.slots)) * float(np.log(engine.count))
    return 2.0 * (first.score - second.score) - cost


def _changes(engine: Engine, whole: Fit, less: Fit) -> FloatArray:
    """Return what the change between two fits would add in every second of all recordings in a row."""
    changes = []
    for whitener, one, other in zip(
        engine.whiteners(whole.noise), whole.simulated, less.simulated, strict=True
    ):
        squares = (whitener.residual(one) - whitener.residual(other)) ** 2
        adds = 0.5 * (engine.nu + 1.0) * np.log1p(squares / (engine.nu - 2.0))
        changes.append(_of_each_block(whitener.prepared, adds))
    return np.concatenate(changes)


def block_sums(engine: Engine, fit: Fit) -> FloatArray:
    """Return the log-likelihood of a fit in every second of all recordings in a row."""
    sums = []
    for whitener, simulated in zip(engine.whiteners(fit.noise), fit.simulated, strict=True):
        density = log_density(whitener.residual(simulated), whitener.log_scale, engine.nu)
        sums.append(_of_each_block(whitener.prepared, density))
    return np.concatenate(sums)


def _of_each_block(p: Prepared, values: FloatArray) -> FloatArray:
    """Return the sums of what the innovations of a recording have (n,), by second."""
    block = np.floor((p.time - p.time[0]) / BLOCK).astype(int)
    of_each = np.broadcast_to(block[:, None], p.scored.shape)[p.scored]
    return np.asarray(np.bincount(of_each, values, minlength=int(block[-1]) + 1), dtype=float)


def _spread(differences: FloatArray) -> float:
    n = len(differences)
    return 2.0 * float(np.sqrt(n / max(n - 1, 1) * np.sum((differences - differences.mean()) ** 2)))
