"""Where a patch lies and when a fault began, once they are named."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_robots import engine_of, recording

from fsm_calib.diagnosis.candidates.place_search import placed
from fsm_calib.diagnosis.candidates.polish import polished
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.fitting.base import fit_base, noise_names
from fsm_calib.diagnosis.fitting.fit import simulate_all
from fsm_calib.diagnosis.verdict.event_times import dated
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

FAULT = {"loss_left": 0.3, "start": 12.3, "duration": 9.0}
PATCH = {"loss": 0.9, "x": 0.15, "y": 0.05, "radius": 0.25}


def named(name, *recordings):
    engine = engine_of(*recordings)
    base = fit_base(engine)
    (ranked,) = Bank.on(engine, base).rank([registry()[name]])
    return engine, polished(engine, ranked, base, noise_names(engine.simulators))


@pytest.fixture(scope="module")
def failed():
    return named(
        "motor_fault", recording(0, **{f"motor_fault__{k}": v for k, v in FAULT.items()}), recording(1)
    )


@pytest.fixture(scope="module")
def slippery():
    numbers = {f"low_friction_patch__{k}": v for k, v in PATCH.items()}
    return named("low_friction_patch", *(recording(seed, **numbers) for seed in (0, 1)))


def moved(engine, fit, run, **numbers):
    """The fit with numbers of an effect put elsewhere, its likelihood told anew."""
    values, table = fit.values.copy(), parameter_table()
    for name, value in numbers.items():
        values[run, table.place(name.replace("__", "."))] = value
    simulated = simulate_all(engine.simulators, values)
    value = engine.log_likelihood(engine.whiteners(fit.noise), simulated)
    return replace(fit, values=values, simulated=simulated, log_likelihood=value)


def numbers_of(fit, ranked, run=0):
    table = parameter_table()
    found = {
        table.names[s.place].split(".")[-1]: (v, c**0.5) for s, v, c in fit.numbers() if s.run in (-1, run)
    }
    return {name: found[name] for name in ranked.hypothesis.names}


def test_a_fault_is_dated_to_a_fraction_of_a_second(failed):
    engine, ranked = failed
    start, sd = numbers_of(dated(engine, ranked.fit, (ranked,)), ranked)["start"]
    assert start == pytest.approx(FAULT["start"], abs=0.5)
    assert abs(start - FAULT["start"]) < 3.0 * sd


def test_an_edge_that_rests_in_a_hollow_is_moved_out_of_it(failed):
    engine, ranked = failed
    late = moved(engine, ranked.fit, ranked.hypothesis.run, motor_fault__start=FAULT["start"] + 1.5)
    again = dated(engine, late, (ranked,))
    assert again.log_likelihood > late.log_likelihood + 5.0
    assert numbers_of(again, ranked)["start"][0] == pytest.approx(FAULT["start"], abs=0.5)


def test_a_fit_without_events_is_not_dated(slippery):
    engine, ranked = slippery
    assert dated(engine, ranked.fit, (ranked,)) is ranked.fit


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_patch_is_found_again_from_beside_it(slippery, seed):
    engine, ranked = slippery
    beside = ranked.fit
    for run in range(len(engine.simulators)):
        beside = moved(engine, beside, run, low_friction_patch__x=0.22, low_friction_patch__y=0.0)
    again = placed(engine, beside, (ranked,), np.random.default_rng(seed))
    found = numbers_of(again, ranked)
    assert np.hypot(found["x"][0] - PATCH["x"], found["y"][0] - PATCH["y"]) < 0.05


def test_the_search_for_a_place_is_never_worse_than_its_start(slippery):
    engine, ranked = slippery
    assert placed(engine, ranked.fit, (ranked,), np.random.default_rng(1)).score >= ranked.fit.score


def test_a_fit_without_places_is_not_searched(failed):
    engine, ranked = failed
    assert placed(engine, ranked.fit, (ranked,), np.random.default_rng(0)) is ranked.fit
