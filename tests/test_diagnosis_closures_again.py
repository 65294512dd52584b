"""The closure that fits an effect alone need not fit it in company: it is asked again when another has joined."""

import numpy as np
import pytest
from diagnosis_robots import engine_of, fitted_number, recording, selector_on

from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.verdict.selection import Selector
from fsm_calib.diagnosis.verdict.swapped import swapped
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

NAMES = ("motor_asymmetric_lag", "lateral_slip")


@pytest.fixture(scope="module")
def limited():
    """Return a selector and its bank for a robot with an acceleration limit and a side slip."""
    numbers = {"motor_asymmetric_lag__ramp_up": 0.6, "lateral_slip__compliance": 0.015}
    engine = engine_of(*(recording(seed, **numbers) for seed in (0, 1)))
    base = fit_base(engine)
    return selector_on(base, engine, *NAMES), Bank.on(engine, base)


def test_another_closure_of_an_effect_takes_its_place_where_it_fits_better_in_company(limited):
    selector, bank = limited
    lag = registry()["motor_asymmetric_lag"]
    slow = max(
        (
            bank.fit(form, start)
            for form, starts in bank.plans(lag)
            for start in starts
            if form.closure == "slow to rise"
        ),
        key=lambda r: r.evidence,
    )
    joining = Bank.on(selector.engine, slow.fit).best_of(registry()["lateral_slip"])
    effects, fit = swapped(selector, (slow, joining), joining.fit, [(slow,)])
    assert [e.name for e in effects] == list(NAMES)
    assert effects[0].hypothesis.closure == "limited up"
    assert fit.score > joining.fit.score


def test_the_closure_that_fits_best_stays(limited):
    selector, bank = limited
    best = bank.best_of(registry()["motor_asymmetric_lag"])
    joining = Bank.on(selector.engine, best.fit).best_of(registry()["lateral_slip"])
    effects, fit = swapped(selector, (best, joining), joining.fit, [(best,)])
    assert (effects, fit) == ((best, joining), joining.fit)


@pytest.fixture(scope="module")
def softly_limited():
    """Return a selector for a robot whose soft limit has a sharp knee (n = 8), and the fit that found it."""
    numbers = {"limit": 0.35, "soft": 1.0, "knee": 0.5}
    engine = engine_of(
        *(recording(seed, **{f"command_saturation__{k}": v for k, v in numbers.items()}) for seed in (0, 1))
    )
    base = fit_base(engine)
    selector = Selector(engine, base, [], 14.0, 0.02, 4, np.random.default_rng(0))
    return selector, Bank.on(engine, base).best_of(registry()["command_saturation"])


def test_a_soft_limit_is_found_with_its_own_knee(softly_limited):
    _, found = softly_limited
    knee = fitted_number(found.fit, "command_saturation.knee")
    assert found.hypothesis.closure == "soft limit, own knee"
    assert knee == pytest.approx(0.5, abs=0.1)


def test_an_effect_that_is_taken_out_leaves_none_of_its_numbers_to_the_closure_that_is_asked_next(
    softly_limited,
):
    selector, found = softly_limited
    own = list(parameter_table().of_effect("command_saturation"))
    less = selector.without(found.fit, "command_saturation")
    np.testing.assert_array_equal(less.values[:, own], selector.base.values[:, own])
