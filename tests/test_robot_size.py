"""Robots of any size: searches over the floor grow with the robot, forces with its mass."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis_robots import recording

from fsm_calib.diagnosis.candidates.scan_markers import TURNED, Jumps, likely_discs
from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.diagnosis.replay.robot_size import SMALL_AXLE, robot_size
from fsm_calib.diagnosis.shapes.features import place_centres, place_pitch
from fsm_calib.world2d.effects import registry

WARTHOG = 1.08  # m, axle
CONSIDERED = "coulomb_friction"
WITHOUT = [name for name in registry() if name != CONSIDERED]


def test_small_robots_are_searched_as_ever_and_large_ones_by_their_axle():
    assert [robot_size(0.5 * axle) for axle in (0.03, 0.1, 0.26, SMALL_AXLE)] == [1.0] * 4
    assert robot_size(0.5 * WARTHOG) == pytest.approx(8.8)
    assert robot_size(0.5 * 0.31) == pytest.approx(1.1)


def on_a_field(half, side=30.0, rows=20000):
    """Return what is asked of a situation: a robot that was everywhere on a field of `side` [m]."""
    x, y = np.random.default_rng(0).uniform(0.0, side, (2, rows))
    return SimpleNamespace(x=x, y=y, v=np.ones(rows), omega=np.zeros(rows), half=half)


def test_a_large_robots_field_has_no_more_places_than_can_be_tried():
    small, large = ([on_a_field(half)] for half in (0.05, 0.5 * WARTHOG))
    assert len(place_centres(small, place_pitch(small))) > 10000
    assert len(place_centres(large, place_pitch(large))) < 600


def test_a_marker_of_a_large_robots_field_is_sought_on_its_own_grid():
    rng = np.random.default_rng(1)
    place = np.cumsum(rng.normal(0.0, 0.3, (400, 3)), axis=0)
    jump, spread = rng.normal(0.0, 0.01, (400, 3)), np.full(3, 0.01)
    found = likely_discs([Jumps(place, jump, spread, jump, spread)], TURNED, size=8.8)
    assert all(disc.radius > 0.5 for disc in found)


@pytest.fixture(scope="module")
def drives():
    return [recording(seed, 25.0, coulomb_friction__friction=0.02) for seed in (0, 1)]


def heavy(drives, mass):
    return [dataclasses.replace(d, robot=dataclasses.replace(d.robot, mass=mass)) for d in drives]


def test_a_force_is_that_of_the_stated_mass_and_is_said_to_be_guessed_without_one(drives):
    usual, told = diagnose(drives, without=WITHOUT), diagnose(heavy(drives, 11.0), without=WITHOUT)
    (light,), (full,) = usual.verdict.effects, told.verdict.effects
    name = next(iter(light.parameters))
    assert full.parameters[name].value == pytest.approx(10.0 * light.parameters[name].value, rel=1e-6)
    assert full.parameters[name].sd == pytest.approx(10.0 * light.parameters[name].sd, rel=1e-6)
    assert any("no mass was stated" in note for note in usual.notes)
    assert not any("no mass was stated" in note for note in told.notes)
