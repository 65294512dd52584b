"""How far does a moment stand out from others that fall off as exponentials do?"""

import numpy as np
import pytest

from fsm_calib.diagnosis.candidates.outstanding import LEAST_FALL, MOMENTS, by_chance


def falling(rng, fall, count=60):
    """Return log-likelihoods of moments where nothing happened, falling."""
    return np.sort(rng.exponential(fall, count))[::-1].tolist()


@pytest.mark.parametrize("fall", [4.0, 8.0])
@pytest.mark.parametrize("together", [1, 3])
def test_where_nothing_happened_the_chance_is_uniform(fall, together):
    rng = np.random.default_rng(5)
    found = np.array([by_chance(falling(rng, fall), together) for _ in range(2000)])
    for level in (0.5, 0.1, 0.02):
        assert np.mean(found < level) == pytest.approx(level, abs=3.0 * np.sqrt(level / 2000.0))


def test_what_falls_off_faster_than_an_exact_model_is_not_trusted():
    noise = [2.0 - 1e-4 * i for i in range(MOMENTS)]
    expected = (1.0 + 5.0 / LEAST_FALL / (MOMENTS - 1)) ** -(MOMENTS - 1)
    assert by_chance([7.0, *noise]) == pytest.approx(expected)


def test_one_that_others_equal_is_chance():
    assert by_chance([9.0, 9.0, 8.0, 7.0]) == 1.0


def test_two_that_stand_out_together_are_less_of_a_chance_than_the_lesser_alone():
    others = [6.0, 5.0, 4.5, 4.0, 3.0]
    assert by_chance([20.0, 19.0, *others], 2) < by_chance([19.0, *others])


def test_one_other_moment_tells_no_fall():
    assert by_chance([3.0, 1.0]) == pytest.approx(np.exp(-2.0))
