"""How hard was it pushed? A simulation tells, also of a robot that does not move until its friction gives way."""

import numpy as np
import pytest
from diagnosis_robots import engine_of, recording

from fsm_calib.diagnosis.candidates.pushed import Moment, Pushed, best_apart_from
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.replay.passage import Passages
from fsm_calib.diagnosis.replay.simulator import scale_of
from fsm_calib.diagnosis.replay.situation import situations_of
from fsm_calib.world2d.effects import registry

BEGIN = 12.0  # s


def asked(run, length, hidden):
    """Return the push that a simulation finds at BEGIN in one of two drives, of which the second has `hidden`."""
    changes = {f"external_push__{name}": value for name, value in hidden.items()}
    drives = (recording(0), recording(1, external_push__start=BEGIN, **changes))
    engine = engine_of(*drives)
    base = fit_base(engine)
    scanner = Bank.on(engine, base).scanner
    situation = situations_of(engine.simulators, base.values)[run]
    passages = Passages.of(engine.simulators[run], base.values[run], base.simulated[run])
    scale = scale_of(engine.simulators[0])
    return Moment(
        registry()["external_push"], passages, scanner.residual, situation, run, BEGIN, length, scale
    ).push()


@pytest.mark.parametrize(
    ("hidden", "length"),
    [
        ({"impulse_x": 1.2, "impulse_y": -0.8, "impulse_turn": 0.05}, 0.25),
        ({"impulse_x": 6.0, "impulse_y": 3.0, "impulse_turn": 0.1, "duration": 1.5}, 1.5),
    ],
)
def test_a_push_is_found_as_large_as_it_was(hidden, length):
    found = asked(1, length, hidden)
    true = np.array([hidden["impulse_x"], hidden["impulse_y"]])
    told = np.array([found.changes["external_push.impulse_x"], found.changes["external_push.impulse_y"]])
    assert np.linalg.norm(told - true) < 0.5 * np.linalg.norm(true)
    assert found.won > 20.0
    assert ("external_push.duration" in found.changes) == ("duration" in hidden)


def test_where_nobody_pushed_nothing_is_won():
    assert asked(0, 0.25, {"impulse_x": 1.2}).won < 10.0


def pushed(run, start, won):
    return Pushed(run, start, 0.25, {}, won)


def test_the_best_other_moment_is_apart_in_time_and_not_the_best_of_another_recording():
    here, beside, later = pushed(0, 5.0, 90.0), pushed(0, 5.5, 80.0), pushed(0, 9.0, 20.0)
    best, same, second = pushed(1, 4.0, 70.0), pushed(1, 4.5, 60.0), pushed(1, 8.0, 30.0)
    assert best_apart_from(here, [here, beside, later, best, same, second]) == 30.0
    assert best_apart_from(here, [here, beside, later, best, same]) == 20.0
    assert best_apart_from(here, [here, beside]) == 0.0
