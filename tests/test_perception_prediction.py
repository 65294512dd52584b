"""The predicted error of a camera: what 95 of 100 draws from its covariance stay within, over the image."""

import numpy as np
import pytest

from fsm_calib.perception.fleet_camera import FLEET_DEVIATION, FLEET_MEDIAN
from fsm_calib.perception.prediction import COVERAGE, PredictedError, predicted_error, sensitivity

SIZE = (640, 480)
MOTION = sensitivity(FLEET_MEDIAN, SIZE)
ONE_DIRECTION = np.outer(FLEET_DEVIATION, FLEET_DEVIATION)
MANY_DIRECTIONS = np.diag(FLEET_DEVIATION**2)


def predicted(covariance: np.ndarray) -> PredictedError:
    return predicted_error(MOTION, covariance)


def drawn_errors(covariance: np.ndarray, count: int = 20_000) -> np.ndarray:
    rng = np.random.default_rng(3)
    draws = rng.multivariate_normal(np.zeros(12), covariance, count, check_valid="ignore", method="svd")
    per_grid_point = MOTION.shape[0] / 2
    moments = MOTION.T @ MOTION / per_grid_point
    return np.sqrt(np.einsum("ni,ij,nj->n", draws, moments, draws))


@pytest.mark.parametrize("covariance", [ONE_DIRECTION, MANY_DIRECTIONS], ids=["one", "many"])
def test_the_stated_share_of_draws_stays_within_the_predicted_error(covariance: np.ndarray) -> None:
    share = np.mean(drawn_errors(covariance) <= predicted(covariance).rms)
    assert share == pytest.approx(COVERAGE, abs=0.01)


@pytest.mark.parametrize("covariance", [ONE_DIRECTION, MANY_DIRECTIONS], ids=["one", "many"])
def test_the_expected_error_is_the_root_mean_square_of_draws(covariance: np.ndarray) -> None:
    mean_square = np.mean(drawn_errors(covariance) ** 2)
    assert predicted(covariance).expected == pytest.approx(np.sqrt(mean_square), rel=0.02)


@pytest.mark.parametrize("covariance", [ONE_DIRECTION, MANY_DIRECTIONS], ids=["one", "many"])
def test_less_than_one_draw_in_a_thousand_is_beyond_twice_the_predicted_error(covariance: np.ndarray) -> None:
    assert np.mean(drawn_errors(covariance) > 2.0 * predicted(covariance).rms) < 1e-3


def test_an_error_along_one_direction_is_predicted_by_the_normal_quantile() -> None:
    error = predicted(ONE_DIRECTION)
    assert error.rms / error.expected == pytest.approx(1.96, abs=0.001)


def test_the_prediction_grows_with_the_standard_deviation() -> None:
    assert predicted(4.0 * MANY_DIRECTIONS).rms == pytest.approx(2.0 * predicted(MANY_DIRECTIONS).rms)


def test_nothing_uncertain_predicts_no_error() -> None:
    error = predicted(np.zeros((12, 12)))
    assert (error.rms, error.expected) == (0.0, 0.0)
