"""The closure that fits an effect alone need not fit it in company: it is asked again when another has joined."""

import numpy as np
import pytest
from diagnosis_robots import engine_of, recording

from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.verdict.selection import Selector
from fsm_calib.diagnosis.verdict.swapped import swapped
from fsm_calib.world2d.effects import registry

NAMES = ("motor_asymmetric_lag", "lateral_slip")


@pytest.fixture(scope="module")
def limited():
    """Return a selector and its bank for a robot with an acceleration limit and a side slip."""
    numbers = {"motor_asymmetric_lag__ramp_up": 0.6, "lateral_slip__compliance": 0.015}
    engine = engine_of(*(recording(seed, **numbers) for seed in (0, 1)))
    base = fit_base(engine)
    effects = [registry()[name] for name in NAMES]
    return Selector(engine, base, effects, 14.0, 0.02, 4, np.random.default_rng(0)), Bank.on(engine, base)


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
