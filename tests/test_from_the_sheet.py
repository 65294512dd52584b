"""Effects are sought from the robot as its sheet states it, where the fit of the base robot is bent."""

import pytest
from diagnosis_robots import engine_of, laps

from fsm_calib.diagnosis.candidates.from_the_sheet import is_bent, sought_from_the_sheet
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.world2d.effects import registry

DEAD_ZONE = registry()["motor_deadband"]
OVER_COMPENSATING = {"motor_deadband__offset": -0.5, "gain_left": 0.25, "gain_right": 0.24}


@pytest.fixture(scope="module")
def bent():
    """Return engine and base fit of a robot in laps whose driver lifts every command by half of the full one."""
    engine = engine_of(*(laps(seed, **OVER_COMPENSATING) for seed in (0, 1)))
    return engine, fit_base(engine)


def of(ranking, name):
    return next(r for r in ranking if r.name == name)


def test_a_robot_of_which_nothing_is_missing_is_not_bent():
    assert not is_bent(fit_base(engine_of(laps(0), laps(1))))


def test_a_base_that_lacks_a_strong_effect_is_bent(bent):
    assert is_bent(bent[1])


def test_an_effect_that_is_lost_from_the_bent_base_is_found_from_the_sheet(bent):
    engine, base = bent
    lost = Bank.on(engine, base).rank([DEAD_ZONE], noticed=10.0)
    found = sought_from_the_sheet(engine, base, lost, [DEAD_ZONE], {})
    assert of(lost, "motor_deadband").evidence < 1000.0
    assert of(found, "motor_deadband").evidence > 1500.0
    assert of(found, "motor_deadband").gain == pytest.approx(found[0].fit.score - base.score)


def test_what_the_bent_base_has_better_stays(bent):
    engine, base = bent
    ranking = sought_from_the_sheet(engine, base, [], [DEAD_ZONE], {})
    again = sought_from_the_sheet(engine, base, ranking, [DEAD_ZONE], {})
    assert again[0] is ranking[0]
