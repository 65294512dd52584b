"""A robot may be pushed several times in one drive: each push acts at its own time, with its own impulse."""

import numpy as np
import pytest

from fsm_calib.errors import InputError
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.effects.numbered import is_later, numbered, starts_in
from fsm_calib.world2d.parameters import parameters
from fsm_calib.world2d.rollout import Drive, simulate

REST = Drive(np.array([0.0]), np.array([0.0]), np.array([0.0]))
GRID = np.arange(0.0, 12.0, 0.01)
FREE = {"gain_left": 0.6, "gain_right": 0.6, "tau_forward": 1.5, "tau_turn": 1.5}


def path(**pushes):
    """Return the path of a robot at rest that is pushed, shape (n, 3)."""
    values = parameters({**FREE, **{f"external_push.{name}": value for name, value in pushes.items()}})
    return simulate(values, REST, GRID, (0.0, 0.0, 0.0))[:, :3]


def test_a_second_push_does_what_it_does_alone():
    first, second = {"impulse_x": 0.3, "start": 2.0}, {"impulse_x_2": -0.2, "start_2": 8.0}
    both, alone, other = path(**first, **second), path(**first), path(**second)
    np.testing.assert_allclose(both[:, 0], alone[:, 0] + other[:, 0], atol=1e-5)
    assert np.abs(other[GRID < 8.0]).max() == 0.0
    assert np.abs(other[-1, 0]) > 0.01


def test_each_push_lasts_as_long_as_it_says():
    held = path(impulse_x_3=0.3, start_3=2.0, duration_3=3.0)
    np.testing.assert_allclose(held, path(impulse_x=0.3, start=2.0, duration=3.0), atol=1e-12)


def test_every_number_of_a_later_push_is_declared_as_the_first_one_is():
    effect = registry()["external_push"]
    for name in effect.closure("held").frees:
        first, last = effect.parameter(name), effect.parameter(numbered(name, 5))
        assert (last.unit, last.low, last.high, last.strength) == (
            first.unit,
            first.low,
            first.high,
            first.strength,
        )
        assert last.difference_step == first.difference_step
        assert last.typical == last.null


def test_the_closure_of_three_pushes_frees_three_of_each_number():
    frees = registry()["external_push"].closure("three pushes").frees
    assert starts_in(frees) == ["start", "start_2", "start_3"]
    assert len(frees) == 15
    assert not any(is_later(name) for name in frees[:5])


def test_there_is_no_sixth_push():
    with pytest.raises(InputError, match="impulse_x_6"):
        parameters({"external_push.impulse_x_6": 1.0})
