"""Do the poses show it? A mismatch without a name counts only where the robot's path differs, too.

Encoders are finer than any tracker: they see a wheel follow its tyre a few milliseconds late while the path is that of
the base robot to within its noise. With a name such a finding can be modelled; without one it would only be alarm. So
the encoders are left out, the base robot is fitted again, and what is left in the poses is asked the two questions
that reveal a mismatch: does it depend on anything (`score_tests`), does a form without a name explain it
(`form_test`)? A name, too, is believed only where the poses do not deny it: encoders whose stamps come late look like
a play of 2 deg (67 units), which poses that would see it at once find 140 units less likely than none. And where they
speak for the strongest name by themselves it stands, whatever else is in its model.
Assumes that whole poses are measured: where headings alone are, encoders are all that tells the way, and recordings
without encoders have been judged by their poses already.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fsm_calib.diagnosis.candidates.whole_base import fit_whole_base
from fsm_calib.diagnosis.fitting.base import have_encoders
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.fitting.values import taken_over
from fsm_calib.diagnosis.proof.form_test import Remainder
from fsm_calib.diagnosis.proof.gates import Gates
from fsm_calib.diagnosis.replay.simulator import Simulator
from fsm_calib.diagnosis.replay.situation import situations_of
from fsm_calib.diagnosis.shapes.features import feature_groups
from fsm_calib.diagnosis.shapes.score_tests import left_over, surprising
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import Effect

OF_POSES = np.array([True, True, True, False, False])  # forward, lateral, turn; not the wheels


@dataclass(frozen=True)
class InPoses:
    """What the poses of some recordings say alone; where they cannot be asked alone they agree with all."""

    simulators: Sequence[Simulator]
    gates: Gates

    @cached_property
    def _can_be_asked(self) -> bool:
        return have_encoders(self.simulators) and all(s.prepared.poses.placed for s in self.simulators)

    @cached_property
    def _engine(self) -> Engine:
        return Engine(tuple(without_encoders(s) for s in self.simulators))

    @cached_property
    def _base(self) -> Fit:
        """The robot with all numbers free that recordings may ask for: it explains the most."""
        return fit_whole_base(self._engine, ())

    def show(self, effects: Sequence[Effect] = ()) -> bool:
        """Return whether poses alone differ from a base robot re-fitted to them.

        effects : what a number of the base robot that is set free must not stand in for. They are asked only where
        the robot with all such numbers free leaves nothing.
        """
        if not self._can_be_asked:
            return True
        engine = self._engine
        return _leaves_something(engine, self._base, self.gates) or _leaves_something(
            engine, fit_whole_base(engine, effects), self.gates
        )

    def deny(self, fit: Fit, effect: str) -> bool:
        """Return whether poses alone speak against an effect of the size that encoders and poses gave it.

        As strongly as a name must be shown: a base robot that is re-fitted beside the effect is less likely by
        `Gates.detect`, whether the re-fit starts from the robot that poses alone see or from the one that encoders and
        poses see (a grip that had stood in for a slippery spot does not find back from a slide). Poses too coarse to
        see an effect do not deny it.
        """
        if not self._can_be_asked:
            return False
        base = self._base
        starts = (taken_over(base.values, effect, fit.values), fit.values)
        return all(self._gain(start) < -self.gates.detect for start in starts)

    def affirm(self, fit: Fit, effect: str) -> bool:
        """Return whether poses alone speak for an effect of the size that encoders and poses gave it.

        As strongly as a name must be shown: a base robot that is re-fitted beside the effect alone is likelier by
        `Gates.detect`. No form without a name need show it: an oval wheel that poses do not see turn is none of them.
        """
        return (
            self._can_be_asked
            and self._gain(taken_over(self._base.values, effect, fit.values)) > self.gates.detect
        )

    def _gain(self, start: FloatArray) -> float:
        """Return the log-likelihood of poses that a base robot wins which is re-fitted from parameters (R, p)."""
        base = self._base
        return self._engine.fit(start, base.slots, base.noise).log_likelihood - base.log_likelihood


def _leaves_something(engine: Engine, base: Fit, gates: Gates) -> bool:
    """Return whether what a base robot leaves depends on anything."""
    if Remainder.of(engine, base).beside_of(())[0] > gates.detect:
        return True
    groups = feature_groups(situations_of(engine.simulators, base.values))
    return bool(surprising(left_over(engine, base, groups)))


def without_encoders(simulator: Simulator) -> Simulator:
    """Return the replay of a recording whose wheel angles nobody has read."""
    prepared = simulator.prepared
    return replace(simulator, prepared=replace(prepared, seen=prepared.seen & OF_POSES))
