"""The likelihood's filter is the inverse root of the noise's covariance, and noise levels come back."""

import numpy as np
import pytest
from diagnosis_robots import HEADING_NOISE, POSITION_NOISE, engine_of, recording

from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.fitting.fit import jacobian
from fsm_calib.diagnosis.fitting.slot import with_slots
from fsm_calib.diagnosis.likelihood.noise import Noise
from fsm_calib.diagnosis.likelihood.robust import Whitener, log_density, robust_weights
from fsm_calib.diagnosis.replay.prepared import prepare
from fsm_calib.diagnosis.replay.simulator import nominal_values
from fsm_calib.errors import DataError


@pytest.fixture(scope="module")
def engine():
    return engine_of(*(recording(seed) for seed in (0, 1)))


@pytest.fixture(scope="module")
def base(engine):
    return fit_base(engine)


def test_base_fit_finds_the_gains_within_their_spread(base, engine):
    for side, truth in (("left", 0.66), ("right", 0.61)):
        j = ("left", "right").index(side)
        assert abs(base.slot_values()[j] - truth) < 4.0 * np.sqrt(base.covariance[j, j]) + 1e-3


def test_noise_of_the_tracker_comes_back(base):
    assert base.noise.position == pytest.approx(POSITION_NOISE, rel=0.15)
    assert base.noise.heading == pytest.approx(HEADING_NOISE, rel=0.15)


def test_innovations_of_the_fitted_base_are_white(base, engine):
    white = engine.residual(engine.whiteners(base.noise), base.simulated)
    assert white.std() == pytest.approx(1.0, abs=0.08)
    assert abs(np.corrcoef(white[3:], white[:-3])[0, 1]) < 0.08


def test_whitening_is_linear_in_the_increments(engine):
    simulator = engine.simulators[0]
    whitener = Whitener.at(simulator.prepared, Noise())
    increments = simulator.increments(nominal_values(engine.simulators)[None])[0]
    change = 1e-3 * np.random.default_rng(0).normal(size=increments.shape)
    change[:, 3:] = 0.0
    column = whitener.columns(change[:, :, None])[:, 0]
    np.testing.assert_allclose(
        whitener.residual(increments + change) - whitener.residual(increments), column, atol=1e-9
    )


def test_gradient_agrees_with_central_differences_of_the_likelihood(base, engine):
    whiteners = engine.whiteners(base.noise)
    raw = jacobian(engine.simulators, base.values, base.slots, base.simulated)
    residual = engine.residual(whiteners, base.simulated)
    gradient = engine.white_columns(whiteners, raw).T @ (robust_weights(residual, engine.nu) * residual)
    numbers = base.slot_values()
    for j, slot in enumerate(base.slots[:5]):
        values = []
        for sign in (1.0, -1.0):
            moved = numbers.copy()
            moved[j] += 4.0 * sign * slot.step
            there = with_slots(base.values, base.slots, moved)
            simulated = [s.increments(v[None])[0] for s, v in zip(engine.simulators, there, strict=True)]
            values.append(engine.log_likelihood(whiteners, simulated))
        slope = (values[0] - values[1]) / (8.0 * slot.step)
        spread = np.sqrt(base.covariance[j, j])
        assert gradient[j] * spread == pytest.approx(slope * spread, abs=0.1)


def test_t_density_integrates_to_one():
    x = np.linspace(-400.0, 400.0, 400_001)
    assert np.trapezoid(np.exp(log_density(x, np.zeros_like(x), 8.0)), x) == pytest.approx(1.0, abs=1e-6)


def test_too_few_poses_are_refused():
    with pytest.raises(DataError, match="usable poses"):
        prepare(recording(0).window(0.0, 1.0))
