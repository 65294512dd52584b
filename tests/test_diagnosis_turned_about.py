"""An effect of a wheel's angle is a law of that angle where its opposite does harm."""

from dataclasses import replace

import pytest
from diagnosis_robots import engine_of, recording
from test_diagnosis_support import support

from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.proof.gap import Gap, gap_between
from fsm_calib.diagnosis.verdict.posterior import belief_of
from fsm_calib.diagnosis.verdict.turned_about import turned_about
from fsm_calib.world2d.effects import registry

NAME = "wheel_eccentricity"


def test_the_opposite_of_an_uneven_wheel_misses_three_times_what_the_wheel_explains() -> None:
    engine = engine_of(*(recording(seed, **{f"{NAME}__right": 0.03}) for seed in (0, 1)))
    base = fit_base(engine)
    whole = Bank.on(engine, base).best_of(registry()[NAME]).fit
    less = engine.fit(base.values, base.slots, whole.noise)
    turned = turned_about(engine, less, whole, NAME)
    explained = 2.0 * (whole.score - less.score)
    assert turned is not None
    assert turned.evidence == pytest.approx(3.0 * explained, rel=0.4)  # (2 A)^2 - A^2, outliers weigh less
    assert turned.evidence > gap_between(engine, whole, less).evidence


def test_an_effect_without_a_phase_has_no_opposite() -> None:
    assert turned_about(None, None, None, "motor_deadband") is None  # type: ignore[arg-type]


@pytest.mark.parametrize(("evidence", "said"), [(-30.0, False), (3000.0, True)])
def test_what_does_as_well_turned_about_is_not_said(evidence: float, said: bool) -> None:
    told = replace(support(), turned=Gap(evidence, 30.0, 60))
    assert (belief_of(told).probability > 0.5) == said
    assert belief_of(told).probability <= belief_of(support()).probability
