"""How sure a name is, and whether a pair needs both of its effects."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_robots import recording

from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis
from fsm_calib.diagnosis.candidates.ranking import Bank, Ranked, polished
from fsm_calib.diagnosis.fitting.base import fit_base, noise_names
from fsm_calib.diagnosis.fitting.fit import Engine
from fsm_calib.diagnosis.proof.crossval import held_out_gains
from fsm_calib.diagnosis.proof.form_test import Contest
from fsm_calib.diagnosis.proof.gates import DEFAULT_GATES, Adequacy
from fsm_calib.diagnosis.proof.necessity import survivor
from fsm_calib.diagnosis.replay.prepared import prepare
from fsm_calib.diagnosis.replay.simulator import make_simulator
from fsm_calib.diagnosis.verdict.model import Model
from fsm_calib.diagnosis.verdict.posterior import GENERAL_DOUBT, confidence, joint_confidence, sureness
from fsm_calib.world2d.effects import registry


def ranked(name, evidence):
    return Ranked(Hypothesis(name, ()), None, evidence, 0.5 * evidence)


def model(instead=-100.0, beside=-100.0):
    contest = Contest(instead, (), beside, (), 100.0)
    return Model((), None, Adequacy(1.0, 0.0, 0.0, ""), (), (), contest)


def sure(pool, **numbers):
    return confidence(pool[0].name, pool[0].evidence, pool, model(**numbers), DEFAULT_GATES)


def test_a_name_without_rivals_keeps_the_general_doubt():
    assert sure([ranked("floor_tilt", 400.0)]) == pytest.approx(1.0 - GENERAL_DOUBT, abs=1e-6)


def test_a_rival_of_the_same_evidence_halves_it():
    pair = [ranked("command_delay", 90.0), ranked("observation_delay", 90.0)]
    assert sure(pair) == pytest.approx(0.5 * (1.0 - GENERAL_DOUBT), rel=1e-3)
    both = joint_confidence([r.name for r in pair], pair, model(), DEFAULT_GATES)
    assert both == pytest.approx(1.0 - GENERAL_DOUBT, rel=1e-3)


def test_forms_without_a_name_have_even_odds_at_their_gate():
    at_the_gate = sure([ranked("floor_tilt", 400.0)], beside=DEFAULT_GATES.form_beside)
    assert at_the_gate == pytest.approx(0.5 * (1.0 - GENERAL_DOUBT), rel=1e-3)


def test_confidence_falls_as_forms_come_near():
    names = [ranked("floor_tilt", 400.0)]
    assert sure(names, instead=-20.0) > sure(names, instead=-4.0) > sure(names, instead=2.0)


def test_a_single_name_is_as_sure_as_its_set():
    delays = [ranked("command_delay", 90.0), ranked("observation_delay", 88.0), ranked("clock_drift", 20.0)]
    said = replace(model(), effects=(delays[0],))
    both = joint_confidence(["command_delay", "observation_delay"], delays, said, DEFAULT_GATES)
    assert sureness(said, delays, DEFAULT_GATES) == pytest.approx(both)


def test_a_pair_has_no_rivals_among_single_effects_but_forms():
    pair = (ranked("command_delay", 90.0), ranked("floor_tilt", 60.0))
    single = [ranked("command_delay", 90.0), ranked("gear_backlash", 89.0)]
    alone, beside_forms = (replace(model(beside=b), effects=pair) for b in (-100.0, 9.0))
    assert sureness(alone, single, DEFAULT_GATES) == pytest.approx(1.0 - GENERAL_DOUBT, rel=1e-3)
    assert sureness(beside_forms, single, DEFAULT_GATES) < DEFAULT_GATES.least_confidence


@pytest.fixture(scope="module")
def tilted():
    changes = {"floor_tilt__slope_x": 0.03, "floor_tilt__slope_y": -0.02}
    engine = Engine(tuple(make_simulator(prepare(recording(seed, **changes))) for seed in (0, 1)))
    base = fit_base(engine)
    (first,) = Bank.on(engine, base).rank([registry()["floor_tilt"]])
    first = polished(engine, first, base, noise_names(engine.simulators))
    (second,) = Bank.on(engine, first.fit).rank([registry()["command_delay"]])
    return engine, base, first, second


def test_a_second_effect_that_is_not_missed_is_taken_out_again(tilted):
    engine, base, first, second = tilted
    left = survivor(engine, (first, second), second.fit, base, DEFAULT_GATES.second)
    assert left is not None
    assert left.name == "floor_tilt"
    assert left.fit.score == pytest.approx(first.fit.score, abs=2.0)


def test_a_pair_that_wins_enough_stays(tilted):
    engine, base, first, second = tilted
    better = replace(second.fit, log_likelihood=second.fit.log_likelihood + 100.0)
    assert survivor(engine, (first, second), better, base, DEFAULT_GATES.second) is None


def test_a_right_effect_predicts_each_recording_from_the_other(tilted):
    engine, base, first, _ = tilted
    gains = held_out_gains(engine, base, first.fit)
    assert len(gains) == 2
    assert min(gains) > 10.0
    assert np.sum(gains) < 1.2 * (first.fit.score - base.score)
