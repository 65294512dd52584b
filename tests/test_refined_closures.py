"""Closures that refine make an effect's equation more exact once it is found, and do not compete for names."""

import pytest
from diagnosis_robots import recording

from fsm_calib.diagnosis.candidates.hypotheses import hypotheses_of
from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.world2d.effects import registry

CONSIDERED = ("tyre_scrub", "caster_drag", "lateral_slip")
WITHOUT = [name for name in registry() if name not in CONSIDERED]


def scrub_of(spin):
    """Return the answer for a robot whose tyres scrub and slip over `spin` [m] of their contact."""
    hidden = {"tyre_scrub__moment": 0.06, "tyre_scrub__spin": spin}
    found = diagnose([recording(seed, 30.0, **hidden) for seed in (1, 2)], without=WITHOUT)
    return {e.name: e for e in found.verdict.effects}["tyre_scrub"]


def test_no_closure_that_refines_or_extends_or_is_left_to_a_scan_competes_for_a_name_at_first():
    for effect in registry().values():
        tried = {form.closure for form in hypotheses_of(effect, 2)}
        later = {c.name for c in effect.closures if c.refines or c.extends or c.alike}
        first = {closure.name for closure in effect.closures} - later
        assert tried == first


def test_a_contact_that_slips_as_it_spins_is_measured_beside_its_scrub():
    scrub = scrub_of(spin=0.12)
    spin = scrub.parameters["spin"]
    assert scrub.closure == "spinning contact"
    assert spin.value == pytest.approx(0.12, abs=3.0 * spin.sd)
    assert spin.sd < 0.06
    assert "spin" in scrub.sentence


def test_scrub_that_has_no_such_slip_keeps_its_plain_equation():
    scrub = scrub_of(spin=0.0)
    assert scrub.closure in ("usual tread", "own tread")
    assert "spin" not in scrub.parameters
