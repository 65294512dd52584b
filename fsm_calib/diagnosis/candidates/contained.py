"""A form that has all numbers of another explains at least as much; where it does not, its fit was stuck.

Dry friction has a rugged likelihood where encoders are exact: of a robot with stiff seals (Box2D 3/4) friction alike
in both wheels had 1,600 units of log-likelihood, friction of loaded gears, of which it is a part, 688; so the gears'
losses were taken for motors that brake faster than they speed up (0.81, wrong). Such a form begins once more where the
smaller one has ended, its further numbers at their null values.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis, is_event
from fsm_calib.diagnosis.candidates.ranked import Ranked
from fsm_calib.diagnosis.candidates.starts import Start
from fsm_calib.world2d.effects import registry

STUCK = 1.0  # log-likelihood units below a form that it has all numbers of


def stuck_above(begun: Sequence[Ranked]) -> Iterator[tuple[Hypothesis, Start]]:
    """Yield the forms of an effect that have won less than one that they contain, each with where that one has ended.

    Events are left: what a second moment adds is told by a scan, not by its derivatives.
    """
    best: dict[Hypothesis, Ranked] = {}
    for ranked in sorted(begun, key=lambda r: r.gain):
        best[ranked.hypothesis] = ranked
    for form, ranked in best.items():
        if is_event(registry()[form.effect]):
            continue
        within = [r for smaller, r in best.items() if _contains(form, smaller)]
        top = max(within, key=lambda r: r.gain, default=ranked)
        if top.gain > ranked.gain + STUCK:
            yield form, Start(top.fit.values, top.gain)


def _contains(larger: Hypothesis, smaller: Hypothesis) -> bool:
    """Return whether a form has all numbers of another, and holds nothing that the other does not."""
    return set(smaller.names) < set(larger.names) and larger.held == smaller.held
