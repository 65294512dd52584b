"""A fit goes on as long as it climbs: laps of a driver that lifts every command lie along a curved valley."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_robots import driven, engine_of, fitted_number

from fsm_calib.diagnosis.candidates.hypotheses import hypotheses_of
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.candidates.starts import Start
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.fitting.climb import LAST_STEPS, climbed
from fsm_calib.diagnosis.fitting.valley import Valley, along_the_valley
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

LIFT = -0.77
LAPS = ((1.4, 0.3, 0.3), (0.9, 0.2, 0.45), (1.1, 0.32, 0.27), (0.8, 0.15, 0.5)) * 8


def laps(rng):
    """Return a recording of laps, always forward, of a robot whose driver lifts every command by far too much."""
    lifted = {"gain_left": 0.19, "gain_right": 0.182, "motor_deadband__offset": LIFT}
    return driven(LAPS, rng, [0.004, 0.004, 0.01], **lifted)


@pytest.fixture(scope="module")
def begun():
    """The engine, and a fit of the lift after its first steps from a small one, far from the end of the valley."""
    engine = engine_of(laps(np.random.default_rng(0)))
    base = fit_base(engine)
    both_alike = next(iter(hypotheses_of(registry()["motor_deadband"], 1)))
    small = with_values(base.values, {"motor_deadband.offset": -0.04})
    slots = Bank.on(engine, base).fit(both_alike, Start(base.values, 0.0)).fit.slots
    return engine, engine.fit(small, slots, base.noise, steps=3)


def valley_of(begun):
    engine, fit = begun
    return Valley(engine, engine.whiteners(fit.noise), fit.slots, fit.values)


def test_a_climb_ends_where_the_valley_does(begun):
    engine, fit = begun
    straight = engine.fit(fit.values, fit.slots, fit.noise, steps=LAST_STEPS)
    found = climbed(engine, fit)
    assert fitted_number(straight, "motor_deadband.offset") > -0.3
    assert fitted_number(found, "motor_deadband.offset") == pytest.approx(LIFT, abs=0.08)
    assert fitted_number(found, "gain_left") == pytest.approx(0.19, rel=0.1)
    assert found.score > straight.score + 10.0


def test_the_end_of_a_valley_is_where_a_climb_stays(begun):
    engine, fit = begun
    top = climbed(engine, fit)
    again = engine.fit(along_the_valley(engine, top), top.slots, top.noise, steps=0)
    assert top.score <= again.score < top.score + 0.1


def test_a_fit_that_has_settled_takes_no_steps_along_a_valley(begun, monkeypatch):
    engine, fit = begun
    top = climbed(engine, fit)
    monkeypatch.setattr(
        "fsm_calib.diagnosis.fitting.climb.along_the_valley", lambda *_: pytest.fail("climbed on")
    )
    assert climbed(engine, top).score >= top.score


def test_the_bend_of_a_step_is_the_second_difference_of_what_it_leaves(begun):
    valley, numbers = valley_of(begun), begun[1].slot_values()
    here = valley._at(numbers)
    slope = valley._slope(here)
    straight = valley._step(slope, slope.gradient, 0.1, numbers)
    ahead, behind = (valley._at(numbers + share * straight).residual for share in (0.2, -0.2))
    second = (ahead - 2.0 * here.residual + behind) / 0.2**2
    expected = slope.columns.T @ (slope.weights * second)
    bending = valley._bending(here, slope, straight)
    assert float(bending @ expected) > 0.98 * np.linalg.norm(bending) * np.linalg.norm(expected)
    assert np.linalg.norm(bending) == pytest.approx(np.linalg.norm(expected), rel=0.2)


def test_a_climb_stays_within_the_bounds(begun):
    engine, fit = begun
    place = fit.slots.index(
        next(s for s in fit.slots if s.place == parameter_table().place("motor_deadband.offset"))
    )
    slots = tuple(replace(s, low=-0.3) if i == place else s for i, s in enumerate(fit.slots))
    valley = Valley(engine, engine.whiteners(fit.noise), slots, fit.values)
    assert valley.climb(fit.slot_values())[place] == pytest.approx(-0.3, abs=1e-6)
