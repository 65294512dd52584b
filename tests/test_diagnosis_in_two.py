"""One effect that stands in for two of its neighbours gives way to both; growth goes on where one went."""

from dataclasses import replace

import pytest
from diagnosis_robots import engine_of, fitted_number, recording, selector_on

from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.verdict.in_two import likelier_in_two
from fsm_calib.diagnosis.verdict.selection import Selection
from fsm_calib.world2d.effects import registry

NEIGHBOURS = ("caster_drag", "tyre_scrub", "coulomb_friction")


def selector_of(**changes):
    engine = engine_of(*(recording(seed, **changes) for seed in (0, 1)))
    return selector_on(fit_base(engine), engine, *NEIGHBOURS)


def alone(selector, name):
    """Return the selection of one effect, beside what else was found in its round."""
    found = [Bank.on(selector.engine, selector.base).best_of(registry()[n]) for n in NEIGHBOURS]
    first = next(r for r in found if r.name == name)
    return Selection((first,), first.fit, ((first, *(r for r in found if r is not first)),), (selector.base,))


@pytest.fixture(scope="module")
def two():
    return selector_of(tyre_scrub__moment=0.012, coulomb_friction__rolling=0.06)


def test_a_caster_gives_way_to_scrub_and_rolling_resistance(two):
    caster = alone(two, "caster_drag")
    assert len(caster.effects[0].hypothesis.names) > 1  # a caster of one number is no sum of two
    found = likelier_in_two(two, caster)
    assert {e.name for e in found.effects} == {"tyre_scrub", "coulomb_friction"}
    assert found.fit.score > caster.fit.score
    assert fitted_number(found.fit, "tyre_scrub.moment") == pytest.approx(0.012, rel=0.1)


def test_what_is_one_stays_one():
    drags = selector_of(caster_drag__drag=0.25, caster_drag__kick=0.2)
    caster = alone(drags, "caster_drag")
    assert likelier_in_two(drags, caster) is caster


@pytest.mark.parametrize(("evidence", "joins"), [(20.0, True), (10.0, False)])
def test_where_one_went_what_had_evidence_beside_it_is_asked(two, evidence, joins):
    scrub = alone(two, "tyre_scrub")
    friction = next(r for r in scrub.rankings[0] if r.name == "coulomb_friction")
    seen = (scrub.effects[0], replace(friction, evidence=evidence))
    # the second round's winner took the first's place
    after = replace(scrub, rankings=(*scrub.rankings, seen))
    assert ("coulomb_friction" in {e.name for e in two._grown_on(after).effects}) is joins
