"""Closures that extend smaller ones are asked for where one of these wins, and begin where its fit has ended."""

from dataclasses import replace

import pytest
from diagnosis_robots import engine_of, fitted_number, with_encoders

from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.errors import UnknownNameError
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.effects.closure import Closure
from fsm_calib.world2d.effects.declaration import check_declaration

NAME, BOTH = "wheel_eccentricity", "both wheels oval"
OVAL = {"left": 0.04, "right": 0.03, "phase_left": 0.5, "phase_right": 3.0, "lobes": 2.0}


def ranked(**numbers):
    """Return the best form of an eccentric wheel on two drives of a robot with encoders."""
    robot = {f"{NAME}__{name}": value for name, value in numbers.items()}
    engine = engine_of(*(with_encoders(seed, **robot) for seed in (0, 1)))
    return Bank.on(engine, fit_base(engine)).best_of(registry()[NAME])


def test_both_wheels_oval_are_found_with_both_shares():
    best = ranked(**OVAL)
    assert best.hypothesis.closure == BOTH
    found = [fitted_number(best.fit, f"{NAME}.{side}") for side in ("left", "right")]
    assert found == pytest.approx([OVAL["left"], OVAL["right"]], rel=0.1)


def test_one_wheel_oval_keeps_its_smaller_closure():
    assert ranked(left=0.04, phase_left=0.5, lobes=2.0).hypothesis.closure == "left wheel oval"


def test_a_round_robot_is_not_asked_for_it(monkeypatch):
    asked = []
    begun = Bank._begun
    monkeypatch.setattr(
        Bank, "_begun", lambda self, form, *a: asked.append(form.closure) or begun(self, form, *a)
    )
    ranked()
    assert "left wheel oval" in asked
    assert BOTH not in asked


def test_a_closure_that_extends_none_of_its_effect_is_refused_with_the_nearest():
    effect = registry()[NAME]
    wrong = Closure("more", ("left",), "more of it", extends=("left wheel ovale",))
    with pytest.raises(UnknownNameError, match="left wheel oval"):
        check_declaration(replace(effect, closures=(*effect.closures, wrong)))
