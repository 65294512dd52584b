"""Rivals of the effect that leads are sought again from where it has the base robot."""

from dataclasses import replace

import pytest
from diagnosis_robots import engine_of, recording

from fsm_calib.diagnosis.candidates.from_the_leader import sought_again
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.world2d.effects import registry

CATALOGUE = [registry()[name] for name in ("motor_deadband", "motor_gain_curve", "floor_tilt")]


@pytest.fixture(scope="module")
def robot():
    """Return engine, base fit and ranking of a robot with a dead zone."""
    drives = [recording(seed, 30.0, motor_deadband__offset=0.06) for seed in (0, 1)]
    engine = engine_of(*drives)
    base = fit_base(engine)
    return engine, base, Bank.on(engine, base).rank(CATALOGUE)


def of(ranking, name):
    return next(r for r in ranking if r.name == name)


def test_a_rival_that_did_not_find_its_way_finds_it(robot):
    engine, base, ranking = robot
    there = of(ranking, "motor_gain_curve")
    lost = replace(there, fit=base, evidence=-8.0, gain=0.0)
    again = sought_again(engine, base, [lost if r is there else r for r in ranking], CATALOGUE)
    assert there.evidence > 50.0
    assert of(again, "motor_gain_curve").evidence > there.evidence - 10.0


def test_the_ranking_stays_in_order_and_loses_nobody(robot):
    engine, base, ranking = robot
    again = sought_again(engine, base, ranking, CATALOGUE)
    assert again[0].name == "motor_deadband"
    assert [r.evidence for r in again] == sorted((r.evidence for r in again), reverse=True)
    assert all(of(again, r.name).evidence >= r.evidence for r in ranking)


def test_what_is_no_rival_of_the_leader_is_left_as_it_was(robot):
    engine, base, ranking = robot
    assert "floor_tilt" not in registry()["motor_deadband"].rivals
    assert of(sought_again(engine, base, ranking, CATALOGUE), "floor_tilt") is of(ranking, "floor_tilt")
