"""Tyres that resist turning: by their turn slip they do so on the spot, and hardly on a wide arc."""

import numpy as np
import pytest
from diagnosis_robots import recording

from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameters
from fsm_calib.world2d.rollout import Drive, simulate
from fsm_calib.world2d.slots import THETA

SAMPLES = np.arange(0.0, 4.0, 0.05)
CONSIDERED = ("tyre_scrub", "caster_drag", "coulomb_friction")
WITHOUT = [name for name in registry() if name not in CONSIDERED]


def turned(left, right, **scrub):
    """Return by how much [rad] a robot turns under constant commands."""
    vector = parameters({f"tyre_scrub.{name}": value for name, value in scrub.items()})
    return float(simulate(vector, Drive([0.0], [left], [right]), SAMPLES, (0.0, 0.0, 0.0))[-1, THETA])


def kept_back(left, right, **scrub):
    """Return the share of the turning that scrub takes."""
    return 1.0 - turned(left, right, **scrub) / turned(left, right)


def test_a_tread_that_rolls_off_resists_a_spin_and_hardly_a_wide_arc():
    plain, rolling = {"moment": 0.03}, {"moment": 0.03, "roll": 8.0}
    assert kept_back(-0.3, 0.3, **rolling) > 0.8 * kept_back(-0.3, 0.3, **plain)
    assert 0.0 < kept_back(0.5, 0.6, **rolling) < 0.3 * kept_back(0.5, 0.6, **plain)


def test_a_tread_that_rolls_off_resists_most_under_a_wheel_that_stands():
    """A pivot about one wheel turns as fast as a spin by half the command, and that wheel's tread is not renewed."""
    rolling = {"moment": 0.03, "roll": 60.0}
    assert kept_back(0.0, 0.4, **rolling) > 1.5 * kept_back(-0.2, 0.2, **rolling)


def test_a_tread_that_rolls_off_is_named_scrub_and_its_size_is_measured():
    hidden = {"tyre_scrub__moment": 0.05, "tyre_scrub__roll": 10.0}
    found = diagnose([recording(seed, 30.0, **hidden) for seed in (1, 2)], without=WITHOUT)
    (scrub,) = found.verdict.effects
    assert (scrub.name, scrub.closure) == ("tyre_scrub", "rolling tread")
    for name, true in (("moment", 0.05), ("roll", 10.0)):
        assert scrub.parameters[name].value == pytest.approx(true, abs=3.0 * scrub.parameters[name].sd)
