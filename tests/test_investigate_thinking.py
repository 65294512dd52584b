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
