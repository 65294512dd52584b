"""A caster whose two ways resist by themselves: what it does, and that no scrubbing tyre is needed beside it."""

import numpy as np
import pytest
from diagnosis_robots import engine_of, judged, recording, robot, selector_on

from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.verdict.selection import Selection
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.rollout import Drive, simulate

DRAG, ARM = 0.2, 0.075  # N, m
BUILT = {"caster_drag__drag": DRAG, "caster_drag__arm": ARM, "caster_drag__crossed": 1.0}
NAMES = ("caster_drag", "tyre_scrub", "coulomb_friction")


def rate_on_an_arc(**changes):
    """Return the steady yaw rate [rad/s] on a wide arc."""
    grid = np.arange(0.0, 3.0, 0.01)
    arc = Drive(np.array([0.0]), [0.4], [0.7])
    return simulate(robot(gain_left=0.6, gain_right=0.6, **changes), arc, grid, (0.0, 0.0, 0.0))[-1, 5]


def test_on_a_wide_arc_it_resists_as_a_moment_of_drag_times_arm():
    halfway = {"caster_drag__drag": DRAG, "caster_drag__arm": 0.4 * ARM}
    moment = rate_on_an_arc(tyre_scrub__moment=DRAG * ARM, tyre_scrub__rate=0.0, **halfway)
    assert rate_on_an_arc(**BUILT) == pytest.approx(moment, rel=0.02)


def test_on_a_wide_arc_it_resists_turning_more_than_one_that_drags_against_its_velocity():
    one_way = {**BUILT, "caster_drag__crossed": 0.0}
    free = rate_on_an_arc()
    assert free - rate_on_an_arc(**BUILT) > 2.0 * (free - rate_on_an_arc(**one_way)) > 0.0


def test_it_is_named_without_a_scrubbing_tyre_beside_it():
    decision = judged(NAMES, **BUILT)
    assert [b.name for b in decision.named] == ["caster_drag"]
    assert decision.model.effects[0].hypothesis.closure == "crossed ways"


def selected(closure, **true):
    """Return a selector and a selection of scrubbing tyres beside a caster of one closure."""
    engine = engine_of(*(recording(seed, **true) for seed in (6, 7)))
    selector = selector_on(fit_base(engine), engine)
    scrub = Bank.on(engine, selector.base).best_of(registry()["tyre_scrub"])
    beside = Bank.on(engine, scrub.fit)
    plans = [
        (form, starts) for form, starts in beside.plans(registry()["caster_drag"]) if form.closure == closure
    ]
    caster = max(
        (beside.fit(form, start) for form, starts in plans for start in starts), key=lambda r: r.evidence
    )
    rankings = ((scrub,), (caster,))
    return selector, selector.weighed(Selection((scrub, caster), caster.fit, rankings), 14.0)


def test_scrubbing_tyres_beside_a_caster_of_another_equation_are_spared():
    selector, both = selected("drag and arm", **BUILT)
    assert {e.name for e in both.effects} == {"tyre_scrub", "caster_drag"}
    assert [e.name for e in selector.spared(both).effects] == ["caster_drag"]


def test_scrubbing_tyres_that_a_caster_cannot_stand_for_stay():
    true = {"tyre_scrub__moment": 0.02, "caster_drag__drag": DRAG, "caster_drag__arm": ARM}
    selector, both = selected("drag and arm", **true)
    assert selector.spared(both) is both
