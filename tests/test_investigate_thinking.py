"""What an investigation thinks between two drives."""

from types import SimpleNamespace

import numpy as np

from fsm_calib.actions.investigate_settings import InvestigateSettings
from fsm_calib.actions.investigating import Findings
from fsm_calib.diagnosis.design.area import Area
from fsm_calib.diagnosis.design.belief import Belief, Hypothesis
from fsm_calib.diagnosis.likelihood.noise import Noise
from fsm_calib.recording.recording import RobotFacts
from fsm_calib.runner.investigation.thinking import Mind


def sure_of(*names):
    only = Hypothesis(names, 1.0, np.zeros(1), (), np.zeros((0, 0)), np.zeros(0))
    return Belief((only,), 0, np.zeros(1), Noise())


def judged(monkeypatch, *beliefs):
    """Return whether the answer is sure after judgements of these beliefs, each of them sure by itself."""
    mind, told = Mind(Area(), RobotFacts(), 0), iter(beliefs)
    monkeypatch.setattr(mind, "_believed", lambda bench: next(told))
    monkeypatch.setattr(mind, "_is_sure", lambda belief, wanted: True)
    bench = SimpleNamespace(asked=InvestigateSettings(), findings=Findings())
    return [mind.judge_answer(bench).evidence["sure"] for _ in beliefs][-1]


def test_same_names_in_another_order_confirm_an_answer(monkeypatch):
    one, other = sure_of("caster_drag", "motor_deadband"), sure_of("motor_deadband", "caster_drag")
    assert judged(monkeypatch, one, other)


def test_other_names_begin_the_confirmation_again(monkeypatch):
    assert not judged(monkeypatch, sure_of("caster_drag"), sure_of("motor_deadband"))


def answered(*names, among=(), **shares):
    """Return a mind whose diagnosis says `names` with 0.95 and whose model has effects with these shares."""
    effects = [SimpleNamespace(name=name, confidence=0.95) for name in names]
    supports = [SimpleNamespace(name=name, share=share) for name, share in shares.items()]
    verdict = SimpleNamespace(verdict="explained", effects=effects, ambiguous=among)
    mind = Mind(Area(), RobotFacts(), 0)
    mind.diagnosis = SimpleNamespace(
        verdict=verdict, decision=SimpleNamespace(model=SimpleNamespace(supports=supports))
    )
    return mind


BOTH = sure_of("motor_deadband", "floor_tilt")


def test_what_is_small_beside_a_sure_name_does_not_keep_an_answer_open():
    assert answered("motor_deadband", motor_deadband=0.97, floor_tilt=0.03)._is_sure(BOTH, 0.9)


def test_what_is_large_and_has_no_sure_name_keeps_it_open():
    assert not answered("motor_deadband", motor_deadband=0.8, floor_tilt=0.2)._is_sure(BOTH, 0.9)


def test_what_happened_once_does_not_keep_it_open():
    pushed = sure_of("motor_deadband", "external_push")
    assert answered("motor_deadband", motor_deadband=0.8, external_push=0.2)._is_sure(pushed, 0.9)


def test_names_that_are_not_the_likeliest_explanation_keep_it_open():
    assert not answered("caster_drag", caster_drag=1.0)._is_sure(BOTH, 0.9)


def test_a_set_that_cannot_be_told_apart_keeps_it_open():
    among = (("motor_deadband", "caster_drag"),)
    assert not answered("motor_deadband", among=among, motor_deadband=1.0)._is_sure(
        sure_of("motor_deadband"), 0.9
    )


def test_an_explanation_without_a_name_that_is_said_keeps_it_open():
    assert not answered(motor_deadband=1.0)._is_sure(sure_of("motor_deadband"), 0.9)
