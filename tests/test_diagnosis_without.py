"""What an effect adds is told by the fit without it, gone to its end: the base robot, where nothing else is there."""

import pytest
from diagnosis_robots import engine_of, recording, selector_on

from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.verdict.cross_examined import MUCH, supports_of
from fsm_calib.diagnosis.verdict.selection import Selection
from fsm_calib.world2d.effects import registry


@pytest.mark.parametrize("hidden", [{"motor_deadband__offset": -0.3}, {"tyre_scrub__moment": 0.06}])
def test_without_its_only_effect_a_robot_is_the_base_robot_to_its_noise(hidden):
    engine = engine_of(recording(0, 30.0, **hidden), recording(1, 30.0, **hidden))
    selector = selector_on(fit_base(engine), engine)
    (name,) = (full.split("__")[0] for full in hidden)
    best = Bank.on(engine, selector.base).best_of(registry()[name])
    stuck = selector.without(best.fit, name)
    assert stuck.score < best.fit.score - MUCH
    (support,) = supports_of(engine, Selection((best,), best.fit, ((best,),), (stuck,)), 0.6)
    assert support.without.score == pytest.approx(selector.base.score, abs=3.0)
    assert support.without.noise.vector() == pytest.approx(selector.base.noise.vector(), rel=0.2)
    assert support.added.evidence == pytest.approx(best.evidence, rel=0.05)
