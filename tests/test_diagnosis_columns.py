"""Columns of a body's speed errors: the wheels turn with the body, whatever the robot's proportions."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_robots import bank_of, engine_of, with_encoders

from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.diagnosis.replay.situation import situations_of
from fsm_calib.diagnosis.shapes.features import body_columns
from fsm_calib.world2d.effects import registry

AXLE = 0.3  # m, on the wheels of a robot whose axle is 0.1 m
MAT = {"drag": 0.15, "x": 0.2, "y": 0.1, "half_x": 0.25, "half_y": 0.25}


def on_a_wide_axle(seed, **changes):
    """Return a recording with encoders of a robot with small wheels far apart."""
    drive = with_encoders(seed, axle_length=AXLE, **changes)
    return replace(drive, robot=replace(drive.robot, axle_length=AXLE))


def test_the_wheels_turn_with_a_faster_body_as_simulated_ones_do():
    """Of a robot with motors that are a hundredth faster both say by how much more its wheels turn on its way."""
    engine = engine_of(on_a_wide_axle(0))
    base = fit_base(engine)
    (simulator,), (s,) = engine.simulators, situations_of(engine.simulators, base.values)
    usual = base.values[0]
    faster = with_values(base.values, {n: 1.01 * usual[i] for i, n in enumerate(("gain_left", "gain_right"))})
    before, after = simulator.increments(np.vstack([usual, faster[0]]))
    simulated, column = after - before, body_columns(s, forward=0.01 * s.v[:, None])[:, :, 0]
    wheel_per_way = [np.abs(c[:, 3:]).sum(axis=0) / np.abs(c[:, 0]).sum() for c in (column, simulated)]
    assert wheel_per_way[0] == pytest.approx(wheel_per_way[1], rel=0.25)


def test_a_mat_is_found_under_a_robot_of_other_proportions_whose_wheels_are_measured():
    mat = {f"rough_floor_patch__{name}": value for name, value in MAT.items()}
    bank = bank_of(*(on_a_wide_axle(seed, **mat) for seed in (0, 1)))
    best = max(bank.scanner.drag_areas(registry()["rough_floor_patch"]), key=lambda found: found.promise)
    x, y = (best.changes[f"rough_floor_patch.{name}"] for name in ("x", "y"))
    assert best.promise > 100.0
    assert np.hypot(x - MAT["x"], y - MAT["y"]) < 0.1
