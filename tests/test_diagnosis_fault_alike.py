"""A motor that loses the same in every drive, for a while of its own in each, is told by all of them together."""

import numpy as np
import pytest
from diagnosis_robots import engine_of, recording

from fsm_calib.diagnosis.candidates.each_its_own import each_its_own
from fsm_calib.diagnosis.candidates.fault_search import FaultSearch
from fsm_calib.diagnosis.candidates.plausible import is_plausible
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.candidates.scanned import scanned
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.fitting.slot import ALL_RUNS
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

SPANS = ((10.0, 8.0), (24.0, 6.0))  # s, begin and length in each of two drives
FAULT = registry()["motor_fault"]


def weakened(*losses):
    """Return a bank on top of the base robot of two drives in which the right motor loses so much."""
    drives = [
        recording(
            run,
            motor_fault__loss_right=loss,
            motor_fault__start=SPANS[run][0],
            motor_fault__duration=SPANS[run][1],
        )
        for run, loss in enumerate(losses)
    ]
    engine = engine_of(*drives)
    return Bank.on(engine, fit_base(engine))


@pytest.fixture(scope="module")
def alike():
    return weakened(0.04, 0.04)


def best_alike(bank):
    """Return the best form that comes alike in both drives, fitted."""
    forms = [plan for plan in scanned(bank.prober, bank.scanner, FAULT) if plan[0].run == ALL_RUNS]
    return max((bank.fit(form, starts[0]) for form, starts in forms), key=lambda ranked: ranked.evidence)


def test_spans_by_one_loss_are_found_in_both_drives(alike):
    found = FaultSearch(FAULT, alike.parent, alike.scanner.residual).candidates(3)
    best = max((c for c in found if c.each), key=lambda candidate: candidate.promise)
    assert best.changes["motor_fault.loss_right"] == pytest.approx(0.04, abs=0.015)
    for own, (start, duration) in zip(best.each, SPANS, strict=True):
        assert own["motor_fault.start"] == pytest.approx(start, abs=1.5)
        assert own["motor_fault.duration"] == pytest.approx(duration, abs=2.0)
    assert best.promise > max(candidate.promise for candidate in found if not candidate.each)


def test_one_loss_for_both_drives_is_fitted_with_fewer_numbers(alike):
    ranked = best_alike(alike)
    loss = ranked.fit.values[:, parameter_table().place("motor_fault.loss_right")]
    assert loss[0] == loss[1] == pytest.approx(0.04, abs=0.008)
    assert ranked.fit.size == alike.parent.size + 5
    assert is_plausible(ranked, alike.engine.simulators)
    assert each_its_own(alike.engine, ranked) is None


def test_a_motor_that_loses_more_in_one_drive_has_a_loss_of_its_own_in_each():
    bank = weakened(0.06, 0.14)
    own = each_its_own(bank.engine, best_alike(bank))
    assert own is not None
    loss = own.fit.values[:, parameter_table().place("motor_fault.loss_right")]
    np.testing.assert_allclose(loss, [0.06, 0.14], atol=0.015)


def test_a_span_of_one_drive_that_is_no_span_in_the_other_is_no_fault_alike(alike):
    ranked = best_alike(alike)
    place = parameter_table().place("motor_fault.duration")
    ranked.fit.values[1, place], kept = 0.3, ranked.fit.values[1, place]
    try:
        assert not is_plausible(ranked, alike.engine.simulators)
    finally:
        ranked.fit.values[1, place] = kept
