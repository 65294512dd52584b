"""Simulators that are not ours take the commands of a recording and are described by the base robot."""

import sys
from pathlib import Path

import numpy as np
import pytest
from diagnosis_robots import engine_of

from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.own_simulator import path_of
from fsm_calib.world2d.parameters import parameter_table

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))


@pytest.mark.parametrize("engine", ["mujoco", "pybullet"])
def test_its_robot_is_found_from_what_it_drives(engine, monkeypatch):
    pytest.importorskip(engine, reason=f"{engine} is not installed: python3 -m pip install {engine}")
    import against_simulators as pairs

    monkeypatch.setattr(pairs, "DURATION", 15.0)
    simulate, robot = pairs.engine_of(engine), pairs.Robot(axle=0.104)
    drive = pairs.recorded(robot, simulate, [5], "mixed")
    path = path_of(pairs.called(robot, simulate), drive)
    assert path[-1, 0] >= drive.pose.time[-1]
    fit = fit_base(engine_of(drive))
    found = {parameter_table().names[slot.place]: value for slot, value, _ in fit.numbers()}
    full = robot.no_load * robot.radius
    assert found["gain_left"] == pytest.approx(full, rel=0.08)
    assert found["axle_length"] == pytest.approx(robot.axle, rel=0.05)
    assert np.abs(path[:, 3]).max() > 0.5
