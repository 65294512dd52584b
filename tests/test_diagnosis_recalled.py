"""What an answer to fewer recordings had found is asked again with the later ones, and stands if it is likelier."""

from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis_robots import engine_of, recording

from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis
from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.proof.gates import DEFAULT_GATES
from fsm_calib.diagnosis.verdict.recalled import Finding, findings_of, likelier_if_recalled
from fsm_calib.diagnosis.verdict.selection import Selector
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

OTHERS = set(registry()) - {"motor_deadband", "motor_gain_curve", "coulomb_friction"}
DEAD_ZONE = Finding(Hypothesis("motor_deadband", ("offset",)), {"motor_deadband.offset": 0.05})


def selector_for(names, *recordings):
    engine = engine_of(*recordings)
    gates = DEFAULT_GATES
    effects = [registry()[name] for name in names]
    return Selector(
        engine, fit_base(engine), effects, gates.detect, gates.further_share, 2, np.random.default_rng(0)
    )


def test_what_the_search_missed_is_found_where_it_was():
    selector = selector_for(("motor_deadband",), *(recording(s, motor_deadband__offset=0.06) for s in (0, 1)))
    found = likelier_if_recalled(selector, [DEAD_ZONE], ())
    assert [effect.name for effect in found.effects] == ["motor_deadband"]
    place = parameter_table().place("motor_deadband.offset")
    assert found.fit.values[0, place] == pytest.approx(0.06, rel=0.1)


def test_what_later_recordings_do_not_show_is_not_kept():
    selector = selector_for(("motor_deadband",), *(recording(seed) for seed in (0, 1)))
    assert likelier_if_recalled(selector, [DEAD_ZONE], ()) is None


def test_an_answer_that_has_it_is_left_as_it_is():
    selection = SimpleNamespace(effects=(SimpleNamespace(name="motor_deadband"),))
    selector = SimpleNamespace(catalogue=[registry()["motor_deadband"]])
    assert likelier_if_recalled(selector, [DEAD_ZONE], (), selection) is selection


def test_what_happened_once_is_no_finding():
    moment = SimpleNamespace(name="external_push", hypothesis=Hypothesis("external_push", ("impulse_x",), 0))
    assert findings_of([moment], SimpleNamespace(values=None), ["external_push"]) == ()


def test_only_what_is_said_is_recalled_with_its_numbers():
    first = diagnose([recording(0, motor_deadband__offset=0.06)], without=OTHERS)
    model = first.decision.model
    assert findings_of(model.effects, model.fit, []) == ()
    (finding,) = findings_of(model.effects, model.fit, ["motor_deadband"])
    assert finding.hypothesis.effect == "motor_deadband"
    assert finding.numbers["motor_deadband.offset"] == pytest.approx(0.06, rel=0.15)


def test_a_later_answer_takes_it_over():
    drives = [recording(seed, motor_deadband__offset=0.06) for seed in (0, 1)]
    later = diagnose(drives, without=OTHERS, earlier=diagnose(drives[:1], without=OTHERS))
    assert [belief.name for belief in later.decision.named] == ["motor_deadband"]
