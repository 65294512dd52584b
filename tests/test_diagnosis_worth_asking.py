"""What is worth asking once nothing hints at it: a push, where one moment stands out from all others."""

import pytest
from diagnosis_robots import engine_of, recording

from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.shapes import score_tests
from fsm_calib.diagnosis.verdict.worth_asking import standing_out, worth_asking
from fsm_calib.world2d.effects import registry

PUSHED = {"external_push__impulse_x": 0.9, "external_push__impulse_y": -0.6, "external_push__start": 12.0}
EFFECTS = [registry()[name] for name in ("external_push", "floor_tilt", "motor_fault")]


def fitted(**changes):
    """Return engine and base robot of two drives, of which the second has `changes`."""
    drives = (recording(0), recording(1, **changes))
    engine = engine_of(*drives)
    return engine, fit_base(engine)


@pytest.mark.parametrize(("changes", "names"), [(PUSHED, {"external_push"}), ({}, set())])
def test_a_moment_stands_out_where_the_robot_was_pushed(changes, names):
    engine, base = fitted(**changes)
    assert standing_out(Bank.on(engine, base), EFFECTS, 14.0) == names


def test_a_push_that_the_score_tests_do_not_notice_is_asked_for(monkeypatch):
    engine, base = fitted(**PUSHED)
    monkeypatch.setattr(score_tests, "ALPHA", 1e-300)
    asked = worth_asking(Bank.on(engine, base), EFFECTS, (), needed=1e-3)
    assert "external_push" in {effect.name for effect in asked}


def test_a_wheel_out_of_round_is_asked_for_though_no_test_and_no_form_knows_a_phase(monkeypatch):
    engine, base = fitted()
    monkeypatch.setattr(score_tests, "ALPHA", 1e-300)
    effects = [registry()[name] for name in ("wheel_eccentricity", "floor_tilt")]
    asked = worth_asking(Bank.on(engine, base), effects, (), needed=14.0)
    assert [effect.name for effect in asked] == ["wheel_eccentricity"]


@pytest.mark.parametrize(
    ("hinted", "names"), [({"misplaced_marker", "floor_tilt"}, ["misplaced_marker"]), ((), [])]
)
def test_a_marker_that_had_something_to_say_before_is_asked_for_though_no_test_sees_its_edge(
    monkeypatch, hinted, names
):
    engine, base = fitted()
    monkeypatch.setattr(score_tests, "ALPHA", 1e-300)
    effects = [registry()[name] for name in ("misplaced_marker", "floor_tilt")]
    asked = worth_asking(Bank.on(engine, base), effects, hinted, needed=14.0)
    assert [effect.name for effect in asked] == names
