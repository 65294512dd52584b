"""What speaks for a named effect and against it, given everything else that the model has."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from fsm_calib.diagnosis.candidates.hypotheses import is_event
from fsm_calib.diagnosis.candidates.ranked import EXACT, Ranked
from fsm_calib.diagnosis.fitting.fit import Fit
from fsm_calib.diagnosis.proof.form_test import Contest
from fsm_calib.diagnosis.proof.gap import Gap
from fsm_calib.diagnosis.proof.one_law import OneLaw
from fsm_calib.diagnosis.shapes.score_tests import ALPHA
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

SLIGHT = 0.06  # of a name's evidence: less that is left, or its spread from second to second, hardly speaks


@dataclass(frozen=True, slots=True)
class RivalGap:
    """Another name in an effect's place: how much evidence it lacks, and the fit with it."""

    name: str
    gap: Gap
    fit: Fit


@dataclass(frozen=True, slots=True)
class Twin:
    """What is no effect of the catalogue and could stand in an effect's place, in words; how much evidence it lacks."""

    what: str
    gap: Gap


@dataclass(frozen=True, eq=False)
class Support:
    """What is known about one effect of a model.

    effect : as it stands in the model; without : the model without it, re-fitted; added : evidence over that;
    share : of what all effects of the model add, 0 to 1; rivals : names fitted in its place, nearest first;
    law : is it one in all drives; forms : un-named forms in its place, and beside the whole model; others : what the
    other effects add that not every robot has; jolted : log odds against an event where the robot is jolted most;
    turned : what the model with the effect turned about lacks against that without it (`turned_about`).
    """

    effect: Ranked
    without: Fit
    added: Gap
    share: float
    rivals: tuple[RivalGap, ...]
    law: OneLaw
    forms: Contest
    others: float = 0.0
    jolted: float = 0.0
    turned: Gap | None = None

    @property
    def name(self) -> str:
        """The effect's name."""
        return self.effect.name

    @property
    def alone(self) -> Gap:
        """What the effect adds, and how much of that what is inexact elsewhere may bring about.

        Of a law that is its spread from second to second. A moment's evidence lies in one second by nature: how far it
        stands out from other moments is asked (`by_chance`). And no equation of the others is exact to less than a
        hundredth of what they explain (EXACT), which may all show at one time, when a gear's play is first taken up.
        """
        if not is_event(registry()[self.name]):
            return self.added
        spread = 0.0 if self.effect.hypothesis.chance > 0.0 else self.added.spread
        return replace(self.added, spread=math.hypot(spread, EXACT * self.others))

    def beats(self, other: Gap, left: float = 0.0) -> float:
        """Return the probability that the effect is nearer to the truth than what lacks so much evidence beside it.

        No equation is exact to less than a hundredth of what it explains (EXACT). left : evidence that is left beside
        the model and may be what the other lacks.
        """
        return other.probability_within(math.hypot(EXACT * max(self.added.evidence, 0.0), left))

    def outdoes(self, rival: RivalGap) -> float:
        """Return the probability that the effect is nearer to the truth than a rival in its place.

        What is left and could do the effect's own job may be what the rival lacks, so that a gap has to stand out from
        it, too: of two drives of a real robot that turns too little a dead zone lacks 88 +- 30 of the 851 units that a
        scrubbing tyre adds, which leaves 61 such ones; of two others all alternatives lack more than a dead zone.
        """
        return self.beats(rival.gap, max(self.forms.beside, 0.0) * self.interchangeable)

    @property
    def by_chance(self) -> float:
        """The odds that chance has it: how many effects would stand out so far at some moment where nothing happened.

        Each name that a robot may have is a priori as likely as a moment that is none, so that this is the odds
        against an event. A law that does not stand out (`is_sparse`) is even odds.
        """
        return 1.0 if self.is_sparse else self.effect.hypothesis.chance * len(registry())

    @property
    def is_sparse(self) -> bool:
        """Whether it is a law whose evidence does not stand out from its own spread (ALPHA).

        A handful of seconds has it all, as something else would have that acts in them; but for what keeps time with
        the wheels' turning (a strip of tape on a real robot's wheel: 65 +- 26 units), which is asked turned about.
        """
        sought = is_event(registry()[self.name]) or self._keeps_time
        return not sought and 1.0 - self.added.probability > ALPHA

    @property
    def _keeps_time(self) -> bool:
        """Whether it keeps time with the wheels' turning."""
        return "wheel_angle" in registry()[self.name].reads

    @property
    def left(self) -> float:
        """What un-named forms beside the whole model explain, as a share of what the effect adds."""
        return max(self.forms.beside, 0.0) / max(self.added.evidence, 1.0)

    @property
    def replaced(self) -> float:
        """How much better forms do in the effect's place than the effect, as a share of it; what they add to it is
        no argument.
        """
        return (self.forms.instead - max(self.forms.beside, 0.0)) / max(self.added.evidence, 1.0)

    @property
    def interchangeable(self) -> float:
        """How much of the effect's own job the forms that explain what is left could do, 0 to 1.

        What is left is held against a name as far as the forms that explain it could stand for the name: a remainder
        of another kind says that something is missing, not that this name is wrong. An event is no job, and whatever is
        missing may show most in one second: there it counts as far as other moments may show as much (`by_chance`), or
        until the event has twice what the others' equations leave (`alone`).
        """
        evidence = max(self.added.evidence, 1.0)
        if is_event(registry()[self.name]):
            return min(2.0 * self.alone.spread / evidence + self.by_chance, 1.0)
        return min(max(1.0 + self.forms.stand_in / evidence, 0.0), 1.0)

    @property
    def patchy(self) -> float:
        """How well it could be a patch on what is inexact in the other effects, 0 to infinity.

        (1 - share) log(1 + spread / added / SLIGHT): the others' part of the evidence, and how unevenly its own lies
        over the drives' seconds (`alone`). Physics that every robot has needs no such excuse, and what keeps time with
        the wheels' turning mends nothing else.
        """
        if registry()[self.name].universal or self._keeps_time:
            return 0.0
        uneven = self.alone.spread / max(self.added.evidence, 1.0)
        return (1.0 - self.share) * math.log1p(uneven / SLIGHT)

    @property
    def twins(self) -> tuple[Twin, ...]:
        """What is no effect of the catalogue and could stand in its place.

        What does the very same with these numbers (`Closure.has_twin`), in any recording, lacks nothing; of a moment
        a jump of the measured poses is asked. An event is held against forms in its place: a law that always holds and
        is none of the catalogue's, as every robot has some, is likelier than something that came once. And what does
        as well turned about is no law of an angle: it shakes the robot, whenever.
        """
        forms, blocks = self.forms, self.added.blocks
        found = [Twin("a jump of the measured poses", Gap(-forms.jump, 0.0, blocks))]
        if is_event(registry()[self.name]):
            lacks = max(forms.beside, 0.0) - forms.instead
            found.append(Twin(law_of(forms.instead_quantities), Gap(lacks, self.alone.spread, blocks)))
        if self.turned is not None:
            found.append(Twin("whatever shakes the robot", self.turned))
        if self._has_exact_twin:
            found.append(Twin("what is no effect of the catalogue", Gap(0.0, 0.0, blocks)))
        return tuple(twin for twin in found if math.isfinite(twin.gap.evidence))

    @property
    def _has_exact_twin(self) -> bool:
        with_twins = {c.name: c.has_twin for c in registry()[self.name].closures if c.has_twin}
        has_twin = with_twins.get(self.effect.hypothesis.closure) if with_twins else None
        if has_twin is None:
            return False
        table, own = parameter_table(), self.effect.hypothesis.names
        known = [dict(zip(table.names, row, strict=True)) for row in self.effect.fit.values.tolist()]
        return any(has_twin({**full, **{n: full[f"{self.name}.{n}"] for n in own}}) for full in known)

    @property
    def moved(self) -> float:
        """The share of the effect that is another one in each drive, 0 where that cannot be asked."""
        return self.law.moved if math.isfinite(self.law.moved) else 0.0


def law_of(quantities: Sequence[str]) -> str:
    """Return in words a law without a name that depends on some quantities."""
    return f"a plain dependence on {' and '.join(quantities)}" if quantities else "a law without a name"
