"""What speaks for each effect of a model and against it is told with the answer, also of those that are not said."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import pytest
from test_diagnosis_belief import support

from fsm_calib.commands.verdict_lines import summary_lines
from fsm_calib.diagnosis.proof.gap import Gap
from fsm_calib.diagnosis.verdict.argument import Argument, arguments_of
from fsm_calib.diagnosis.verdict.support import RivalGap, Support


def rivalled(name: str, evidence: float) -> Support:
    rivals = (RivalGap("caster_drag", Gap(88.0, 30.0, 60), None),)  # type: ignore[arg-type]
    alone = support(name, added=evidence, spread=20.0, share=0.8, moved=0.1, beside=40.0, instead=-300.0)
    return replace(alone, rivals=rivals)


def model() -> SimpleNamespace:
    supports = (rivalled("motor_deadband", 400.0), rivalled("tyre_scrub", 100.0))
    return SimpleNamespace(
        supports=supports, beliefs=tuple(SimpleNamespace(probability=p) for p in (0.9, 0.3))
    )


def plain(effects: list[dict], arguments: tuple[Argument, ...]) -> dict:
    located = {"channels": [], "regime": "", "where": None}
    return {
        "verdict": "explained",
        "reason": "r",
        "effects": effects,
        "ambiguous": [],
        "located": located,
        "family": None,
        "fit": {"holdout": None, "train": None, "horizon_s": 2.0},
        "rivals": [],
        "smallest_seen": {},
        "next_manoeuvre": "n",
        "seconds": 0.0,
        "seconds_by_part": {},
        "model": [argument.as_json() for argument in arguments],
    }


def test_each_effect_of_the_model_has_the_numbers_of_its_support():
    first, second = arguments_of(model())
    assert (first.name, first.closure, first.confidence) == ("motor_deadband", "both alike", 0.9)
    assert (first.evidence, first.spread, first.share, first.moved) == (400.0, 20.0, 0.8, 0.1)
    assert first.left == pytest.approx(40.0 / 400.0)
    assert second.left == pytest.approx(40.0 / 100.0)
    assert first.stands_in == pytest.approx(1.0 - 300.0 / 400.0)


def test_rivals_are_told_with_what_they_lack_and_how_sure_that_is():
    assert arguments_of(model())[0].as_json()["rivals"] == [
        {"name": "caster_drag", "evidence_gap": 88.0, "spread": 30.0}
    ]


def test_what_was_not_asked_is_null():
    argument = arguments_of(model())[0]
    values = {name: getattr(argument, name) for name in Argument.__slots__} | {"moved": math.nan}
    assert Argument(**values).as_json()["moved"] is None


def test_the_lines_tell_what_was_fitted_and_is_too_unsure_for_a_name():
    said = [{"name": "motor_deadband", "confidence": 0.9, "sentence": "s"}]
    text = "\n".join(summary_lines(plain(said, arguments_of(model()))))
    assert "too unsure for a name: tyre_scrub (0.30)" in text
    assert "motor_deadband (0.90)" not in text


def test_a_model_all_said_has_no_such_line():
    said = [{"name": n, "confidence": 0.9, "sentence": "s"} for n in ("motor_deadband", "tyre_scrub")]
    assert "too unsure" not in "\n".join(summary_lines(plain(said, arguments_of(model()))))
