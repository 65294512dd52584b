r"""How sure is a name? It must add something, beat its rivals, and be the law that it says.

    P(name) = P(added > 0) / (1 + c + sum_r (1 - p_r) / p_r) P(shape)        r: rivals that are beaten, and twins
    log odds of shape = SURE - DOUBT [log(1 + i left / SLIGHT) + patchy] - ANOTHER [max(replaced, 0) + max(moved, 0)]
                        - jolted

added, p_r : from the gaps in evidence over nothing and over rival r, each tempered by its own spread from second to
second (`proof/gap.py`), that over a rival also by a hundredth of what the name explains (EXACT: no equation is exact
to less) and by what is left that could do the name's job (`Support.outdoes`); c [1] : the odds that a moment stands
out so far by chance, even ones that a law does whose evidence lies in a handful of seconds (`Support.by_chance`);
left, replaced, moved [1] : shares of what the name explains that un-named forms explain beside it, or better in its
place, and that is another law in each drive; patchy [1] : how well it could mend what is inexact in stronger effects
(`verdict/support.py`); jolted [1] : an event comes where the robot is jolted most (`candidates/jolts.py`). A right
name whose equation is another than ours and a wrong neighbour differ in these shares, not in sizes. The numbers were
set on opened development robots (`benchmarks/concealed`, `benchmarks/engine` with the mass behind the axle,
`benchmarks/foreign` seed 1), right names against names given when the true one had been taken out of the catalogue;
DOUBT and SLIGHT of uneven evidence on sets whose keys had been opened (`benchmarks/foreign` seeds 7, 8, 10 to 12 and
16, one set of `benchmarks/concealed`). No robot was among them that was sealed at the time. docs/constants.md lists
them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from fsm_calib.diagnosis.candidates.ranked import Ranked
from fsm_calib.diagnosis.proof.gap import TOLD_APART
from fsm_calib.diagnosis.verdict.support import SLIGHT, Support

SURE = 3.2  # log odds of a name that leaves nothing
DOUBT = (
    1.4  # log odds for each e-fold by which what is left, or how unevenly the evidence lies, passes SLIGHT
)
ANOTHER = (
    4.0  # log odds a share by which it is another law: in each drive, or one without a name that does better
)

LARGEST_LOG_ODDS = 30.0
TINY = 1e-12


@dataclass(frozen=True, eq=False)
class Belief:
    """An effect and how sure its name is: the probability that one of `among`, itself first, is the right name."""

    effect: Ranked
    probability: float
    among: tuple[str, ...]

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.effect.name


def belief_of(support: Support) -> Belief:
    """Return how sure an effect's name is, and which names the data cannot tell from it."""
    beaten = [(r.name, support.outdoes(r)) for r in support.rivals]
    near = [name for name, p in beaten if p < TOLD_APART]
    against = sum((1.0 - p) / p for _, p in beaten if p >= TOLD_APART)
    equalled = [support.beats(twin.gap) for twin in support.twins]
    against += sum((1.0 - p) / max(p, TINY) for p in equalled) + support.by_chance
    probability = support.alone.probability * shape_probability(support) / (1.0 + against)
    return Belief(support.effect, probability, (support.name, *near))


def shape_probability(support: Support) -> float:
    """Return the probability that an effect is the law that its name says, not one that resembles it."""
    log_odds = (
        SURE
        - DOUBT * (math.log1p(support.left * support.interchangeable / SLIGHT) + support.patchy)
        - ANOTHER * (max(support.replaced, 0.0) + max(support.moved, 0.0))
        - support.jolted
    )
    return 1.0 / (1.0 + math.exp(-max(min(log_odds, LARGEST_LOG_ODDS), -LARGEST_LOG_ODDS)))
