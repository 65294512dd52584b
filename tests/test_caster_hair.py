"""A caster around which hair winds up: its drag grows with its way, and it is found by its sizes."""

import numpy as np
import pytest
from diagnosis_robots import engine_of, fitted_number, recording, robot

from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.rollout import Drive, simulate

DRAG, WOUND = 0.4, 1.5  # N, m
HAIR = {"caster_drag__drag": DRAG, "caster_drag__wound": WOUND}
STEADY = {"caster_drag__drag": DRAG}
ALIKE = {"gain_left": 0.6, "gain_right": 0.6}


def straight(**changes):
    """Return way [m] and speed [m/s] of a robot that drives straight ahead for 20 s."""
    grid = np.arange(0.0, 20.0, 0.01)
    states = simulate(robot(**ALIKE, **changes), Drive(np.array([0.0]), [0.4], [0.4]), grid, (0.0, 0.0, 0.0))
    return states[:, 0], states[:, 3]


def test_a_clean_caster_does_not_drag_and_after_many_times_its_way_it_drags_as_a_steady_one_does():
    speeds = [straight(**caster)[1] for caster in ({}, HAIR, STEADY)]
    early, late = ([float(speed[row]) for speed in speeds] for row in (100, -1))
    assert early[1] == pytest.approx(early[0] - 0.14 * (early[0] - early[2]), abs=0.01 * early[0])
    assert late[1] == pytest.approx(late[2], abs=0.06 * (late[0] - late[2]))


def test_the_drag_after_its_way_is_the_share_that_its_equation_says():
    """At an even pace what brakes the robot is in proportion to the speed it lacks."""
    way, speed = straight(**HAIR)
    free, dragged = (straight(**caster)[1][-1] for caster in ({}, STEADY))
    share = (free - speed[300:]) / (free - dragged)
    assert share == pytest.approx(1.0 - np.exp(-way[300:] / WOUND), abs=0.05)


def test_it_is_found_with_its_drag_and_way():
    engine = engine_of(*(recording(seed, **HAIR) for seed in (0, 1)))
    best = Bank.on(engine, fit_base(engine)).best_of(registry()["caster_drag"])
    assert best.hypothesis.closure == "winding up"
    found = [fitted_number(best.fit, f"caster_drag.{n}") for n in ("drag", "wound")]
    assert found == pytest.approx([DRAG, WOUND], rel=0.15)
