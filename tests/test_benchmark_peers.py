"""The peers of the concealed proof get sound data and a library that knows the catalogue."""

import sys

import numpy as np
import pytest
from recording_samples import ROOT

from fsm_calib.world2d.effects import registry

sys.path.insert(0, str(ROOT / "benchmarks"))

from peers.data import Windows, error_of, local_quadratic
from peers.library import terms
from peers.run import is_right

KEYS = ("v", "w", "x", "y", "theta", "t", "left", "right", "d_left", "d_right", "roll_left", "roll_right")


def test_local_quadratics_are_exact_on_a_parabola():
    t = np.arange(0.0, 3.0, 0.05)
    found = local_quadratic(t, (1.0 + 2.0 * t + 1.5 * t**2)[:, None], np.array([1.0, 1.51]))
    assert found[0, :, 0] == pytest.approx([4.5, 5.0, 3.0])


def test_one_wild_row_hardly_moves_a_local_quadratic():
    t = np.arange(0.0, 3.0, 0.05)
    y = 0.3 * t + 0.001 * np.sin(37.0 * t)
    wild = y.copy()
    wild[30] += 1.0
    at = np.array([1.4])
    assert local_quadratic(t, wild[:, None], at)[0, 0, 0] == pytest.approx(0.42, abs=0.005)


WITHOUT_TERMS = {
    "unequal_motors",
    "wheel_slip",
    "observation_delay",
    "command_point",
    "skid_steer",
    "pwm_steps",
    "speed_controller",
}
"""In the peers' base already, the twin of the command's delay, or of robots that are not in the set."""


def test_library_has_a_term_for_every_effect_that_the_robots_hide():
    state = {key: np.ones(3) for key in KEYS}
    named = {name for name, _, _ in terms(state)} - {"base"}
    assert named <= set(registry())
    assert set(registry()) - named <= WITHOUT_TERMS


def test_errors_are_medians_over_windows():
    windows = Windows(np.arange(3), np.zeros((3, 3)), np.full(3, 2.0))
    predicted = np.array([[0.03, 0.04, 0.1], [0.0, 0.0, -0.2], [1.0, 0.0, 2.0 * np.pi]])
    assert error_of(predicted, windows) == pytest.approx((0.05, 0.1))


@pytest.mark.parametrize(
    ("label", "said", "right"),
    [
        ("floor_tilt", {"floor_tilt"}, True),
        ("command_delay", {"observation_delay"}, True),
        ("floor_tilt", set(), False),
    ],
)
def test_two_delays_count_as_one_name(label, said, right):
    assert is_right(label, said) is right
