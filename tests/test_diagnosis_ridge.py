"""A fit that stands on the lower of two hills finds the higher one along its own ridge."""

import pytest
from diagnosis_robots import engine_of, recording

from fsm_calib.diagnosis.candidates.polish import polished
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.candidates.ridge import beyond_the_ridge
from fsm_calib.diagnosis.fitting.base import fit_base, noise_names
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

OFFSET = 0.06


@pytest.fixture(scope="module")
def robot():
    """Return engine, base and the polished dead zone of a robot that has one, alike on both wheels."""
    drives = [recording(seed, 30.0, motor_deadband__offset=OFFSET) for seed in (0, 1)]
    engine = engine_of(*drives)
    base = fit_base(engine)
    found = Bank.on(engine, base).best_of(registry()["motor_deadband"])
    return engine, base, polished(engine, found, base, noise_names(engine.simulators))


def offset_of(values):
    return float(values[0, parameter_table().place("motor_deadband.offset")])


def moved(engine, fit, share):
    """Return a fit as it would stand with its dead zone larger by a share, nothing else changed."""
    values = with_values(fit.values, {"motor_deadband.offset": (1.0 + share) * offset_of(fit.values)})
    return engine.fit(values, fit.slots, fit.noise, steps=0)


def test_the_highest_hill_has_none_beside_it(robot):
    engine, _, found = robot
    assert beyond_the_ridge(engine, found.fit, "motor_deadband") is None


@pytest.mark.parametrize("share", [-0.2, 0.25])
def test_a_fit_that_stands_aside_is_led_back(robot, share):
    engine, _, found = robot
    aside = moved(engine, found.fit, share)
    best, before = offset_of(found.fit.values), offset_of(aside.values)
    after = offset_of(beyond_the_ridge(engine, aside, "motor_deadband"))
    assert abs(after - best) < 0.5 * abs(before - best)


def test_the_other_numbers_go_along_as_they_go_together(robot):
    engine, _, found = robot
    aside = moved(engine, found.fit, 0.25)
    values, fit = beyond_the_ridge(engine, aside, "motor_deadband"), aside
    s = next(
        i
        for i, slot in enumerate(fit.slots)
        if slot.place == parameter_table().place("motor_deadband.offset")
    )
    by = offset_of(values) - offset_of(fit.values)
    expected = fit.slot_values() + fit.covariance[:, s] / fit.covariance[s, s] * by
    assert [values[0, slot.place] for slot in fit.slots] == pytest.approx(expected)


def test_an_effect_without_strengths_among_the_free_numbers_has_no_ridge(robot):
    engine, base, _ = robot
    assert beyond_the_ridge(engine, base, "motor_deadband") is None
