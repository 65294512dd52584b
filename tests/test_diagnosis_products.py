"""A score test's products are those of whole columns, and no large array is made for them."""

import numpy as np
import pytest
from diagnosis_robots import engine_of, recording

from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.proof.form_test import Pool
from fsm_calib.diagnosis.replay.situation import situations_of
from fsm_calib.diagnosis.shapes import score_tests
from fsm_calib.diagnosis.shapes.features import Group, feature_groups
from fsm_calib.diagnosis.shapes.score_tests import Blocks, free_part, products_of, residual_of


@pytest.fixture(scope="module")
def robot():
    engine = engine_of(*(recording(seed, 20.0) for seed in (0, 1)))
    base = fit_base(engine)
    return residual_of(engine, base), list(feature_groups(situations_of(engine.simulators, base.values)))


def whole_columns(residual, group):
    """Return a group's projected columns (N, m), made at once: own columns are zero in the other recordings."""
    blocks = [make() for make in group.makers]
    if group.own:
        count = sum(block.shape[2] for block in blocks)
        wide, at = [], 0
        for block in blocks:
            wide.append(np.zeros((*block.shape[:2], count)))
            wide[-1][:, :, at : at + block.shape[2]] = block
            at += block.shape[2]
        blocks = wide
    return free_part(residual, residual.engine.white_columns(residual.whiteners, blocks))


@pytest.mark.parametrize("own", [False, True])
def test_products_are_those_of_whole_columns(robot, own):
    residual, groups = robot
    seconds = Blocks(np.arange(len(residual.psi)) * 7 // len(residual.psi), 7)
    for group in [g for g in groups if g.own is own][:4]:
        x = whole_columns(residual, group)
        found, size = products_of(residual, group, seconds), np.max(np.abs(x.T @ x))
        np.testing.assert_allclose(found.scores, x.T @ residual.psi, atol=1e-9 * size)
        np.testing.assert_allclose(found.gram, x.T @ x, atol=1e-9 * size)
        of_second = [residual.psi[seconds.number == b] @ x[seconds.number == b] for b in range(seconds.count)]
        np.testing.assert_allclose(found.parts, of_second, atol=1e-9 * size)


def test_what_the_fit_can_do_itself_is_no_finding(robot):
    residual, _ = robot
    gains = [lambda block=block: block[:, :, :1] for block in fit_base(residual.engine).columns]
    found = score_tests.test_group(residual, Group("forward", "command level", tuple(gains)))
    assert (found.surprise, found.gain) == (0.0, 0.0)


def test_a_pool_answers_as_one_matrix_does():
    rng = np.random.default_rng(0)
    left, right = rng.normal(size=(50, 2)), rng.normal(size=(50, 3))
    pool, whole = Pool((("load", left), ("speed", right))), np.hstack([left, right])
    weight, rows = rng.uniform(size=50), rng.normal(size=(4, 50))
    assert pool.quantities == ("load", "load", "speed", "speed", "speed")
    np.testing.assert_allclose(pool.products(rows), rows @ whole)
    np.testing.assert_allclose(pool.squares(weight), weight @ whole**2)
    np.testing.assert_array_equal(pool.column(3), whole[:, 3])
    np.testing.assert_array_equal(pool.of(["speed"]).column(0), whole[:, 2])
