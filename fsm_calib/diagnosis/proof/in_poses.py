"""Do the poses show it? A mismatch without a name counts only where the robot's path differs, too.

Encoders are finer than any tracker: they see a wheel follow its tyre a few milliseconds late while the path is that of
the base robot to within its noise. With a name such a finding can be modelled; without one it would only be alarm. So
the encoders are left out, the base robot is fitted again, and what is left in the poses is asked the two questions
that reveal a mismatch: does it depend on anything (`score_tests`), does a form without a name explain it
(`form_test`)? Assumes that whole poses are measured: where headings alone are, encoders are all that tells the way,
and recordings without encoders have been judged by their poses already.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fsm_calib.diagnosis.candidates.whole_base import fit_whole_base
from fsm_calib.diagnosis.fitting.base import have_encoders
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.proof.form_test import Remainder
from fsm_calib.diagnosis.proof.gates import Gates
from fsm_calib.diagnosis.replay.simulator import Simulator
from fsm_calib.diagnosis.replay.situation import situations_of
from fsm_calib.diagnosis.shapes.features import feature_groups
from fsm_calib.diagnosis.shapes.score_tests import left_over, surprising
from fsm_calib.world2d.effects import Effect

OF_POSES = np.array([True, True, True, False, False])  # forward, lateral, turn; not the wheels


def shown_in_poses(simulators: Sequence[Simulator], gates: Gates, effects: Sequence[Effect] = ()) -> bool:
    """Return whether poses alone differ from a base robot re-fitted to them; True where they cannot be asked alone.

    effects : what a number of the base robot that is set free must not stand in for. They are asked only where the
    robot with all such numbers free, which explains the most, leaves nothing.
    """
    if not have_encoders(simulators) or not all(s.prepared.poses.placed for s in simulators):
        return True
    engine = Engine(tuple(without_encoders(s) for s in simulators))
    return any(_leaves_something(engine, fit_whole_base(engine, asked), gates) for asked in ((), effects))


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
