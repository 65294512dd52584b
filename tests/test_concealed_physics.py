"""The concealed generator's own laws, against what mechanics says of them."""

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "benchmarks"))

from concealed.physics import STATE, Physics, simulate

OMEGA, SPEED = STATE.index("omega"), STATE.index("vx")


def driven(times, left, right, **changes):
    physics = Physics()._replace(**changes)
    _, states = simulate(physics, np.array(times), np.array(left), np.array(right), np.zeros(3), 2.0, None)
    return states


@pytest.mark.parametrize("behind", [0.01, 0.02])
def test_a_mass_behind_the_axle_turns_into_the_curve(behind):
    """I domega/dt = M - m c_x v omega about the axle's middle: a load behind it helps to turn."""
    arc = ([0.0], [0.3], [0.5])
    plain = driven(*arc)[-1, OMEGA]
    assert driven(*arc, com_x=-behind)[-1, OMEGA] > plain * (1.0 + 2.0 * behind)
    assert driven(*arc, com_x=behind)[-1, OMEGA] < plain * (1.0 - 2.0 * behind)


@pytest.mark.parametrize("pair", [(-0.3, -0.3), (0.3, -0.3), (-0.2, -0.4)])
def test_a_swivelling_caster_takes_energy_out(pair):
    """Its friction opposes the pivot's motion whichever way its wheel points: the motors' work shrinks the speed."""
    drive = ([0.0], [pair[0]], [pair[1]])
    plain, dragged = driven(*drive), driven(*drive, caster_drag=0.3, caster_scrub=0.3)
    energy = [1.1 * s[:, SPEED] ** 2 + 0.0065 * s[:, OMEGA] ** 2 for s in (plain, dragged)]
    assert np.all(energy[1] <= energy[0] + 1e-9)
