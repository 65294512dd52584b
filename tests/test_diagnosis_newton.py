"""What makes a fit fast must not change it: promises, bounds, remembered filters, skipped look-ups."""

import numpy as np
import pytest
from diagnosis_robots import engine_of, recording

from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis, declared_starts, hypotheses_of, slots_of
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.candidates.starts import distinct_of
from fsm_calib.diagnosis.fitting.base import base_slots
from fsm_calib.diagnosis.fitting.fit import Engine, simulate_all
from fsm_calib.diagnosis.fitting.newton import clipped, damped_step, normal_equations, promised
from fsm_calib.diagnosis.fitting.slot import Slot
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.diagnosis.likelihood.noise import Noise
from fsm_calib.diagnosis.replay.simulator import nominal_values
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table, parameters
from fsm_calib.world2d.rollout import active_flags, simulate_many

LARGE = 1e9


@pytest.fixture(scope="module")
def engine():
    return engine_of(recording(5, 20.0, motor_deadband__offset=0.05))


@pytest.fixture(scope="module")
def base(engine):
    values = nominal_values(engine.simulators)[None]
    return engine.fit(values, base_slots(engine.simulators, values[0]), Noise(), steps=4, refresh=True)


def test_a_step_promises_what_a_quadratic_score_wins():
    rng = np.random.default_rng(0)
    white, residual = rng.normal(size=(200, 3)), rng.normal(size=200)
    slots = [Slot(i, -LARGE, LARGE, 1e-3) for i in range(3)]
    normal, gradient = normal_equations(white, residual, slots, np.zeros(3), nu=1e12)
    step = damped_step(normal, gradient, 0.0, slots, np.zeros(3))
    won = 0.5 * (residual @ residual - (residual - white @ step) @ (residual - white @ step))
    assert promised(normal, gradient, step) == pytest.approx(won, rel=1e-6)


def test_only_a_step_that_a_bound_stops_is_clipped():
    slots = [Slot(0, 0.0, 1.0, 1e-3), Slot(1, 0.0, 1.0, 1e-3)]
    assert clipped(slots, np.array([0.5, 0.5]), np.array([1.0, 0.6]))
    assert not clipped(slots, np.array([0.5, 1.0]), np.array([0.6, 1.0]))


def test_remembered_filters_and_columns_give_the_same_fit(engine, base):
    changed = base.values.copy()
    changed[0, parameter_table().place("motor_deadband.offset")] = 0.02
    fresh = Engine(engine.simulators)
    for _ in range(2):
        again = engine.fit(changed, base.slots, base.noise, known=base.columns, steps=2)
    alone = fresh.fit(changed, base.slots, base.noise, known=tuple(c.copy() for c in base.columns), steps=2)
    assert again.score == alone.score
    np.testing.assert_array_equal(again.values, alone.values)


def test_a_fit_on_top_of_another_keeps_the_columns_that_it_took_over_only_once(engine, base):
    slots = (*base.slots, *slots_of(Hypothesis("motor_deadband", ("offset",)), 1))
    fit = engine.fit(base.values, slots, base.noise, known=base.columns, steps=1)
    assert fit.jacobians[0] is base.columns
    assert fit.columns[0].shape[2] == len(slots)


def test_columns_are_whitened_in_parts_as_all_at_once(engine, base):
    rng, whiteners = np.random.default_rng(0), engine.whiteners(base.noise)
    columns = [rng.normal(size=(*s.shape, 37)) for s in base.simulated]
    columns[0][:, :, 3:9] = 0.0
    whole = np.vstack([w.columns(c) for w, c in zip(whiteners, columns, strict=True)])
    np.testing.assert_array_equal(engine.white_columns(whiteners, columns), -whole)


def test_more_noises_than_are_remembered_do_no_harm(engine, base):
    simulated = simulate_all(engine.simulators, base.values)
    noises = [Noise(position=0.001 * (i + 1)) for i in range(8)]
    once = [engine.log_likelihood(engine.whiteners(n), simulated) for n in noises]
    assert [engine.log_likelihood(engine.whiteners(n), simulated) for n in noises] == once


def test_a_second_search_keeps_what_it_wants(engine, base):
    effects = [registry()["motor_deadband"], registry()["sensor_yaw"]]
    free, asked = Bank.on(engine, base).rank(effects), Bank.on(engine, base, wanted=40.0).rank(effects)
    assert free[0].name == asked[0].name == "motor_deadband"
    assert asked[0].evidence == pytest.approx(free[0].evidence, abs=0.1)


def test_what_no_second_effect_could_reach_is_not_fitted(engine, base):
    assert Bank.on(engine, base, wanted=1e6).rank([registry()["sensor_yaw"]]) == []


def test_what_all_starts_of_a_form_could_win_is_near_what_a_fit_of_it_wins(engine, base):
    prober, form = Bank.on(engine, base).prober, Hypothesis("motor_deadband", ("offset",))
    start = with_values(base.values, {"motor_deadband.offset": 0.05})
    fit = engine.fit(start, (*base.slots, *slots_of(form, 1)), base.noise)
    won = fit.score - base.score
    assert 0.5 * won < prober.reach(prober.probes(form, declared_starts(form))) < 2.0 * won


def test_starts_that_change_nothing_reach_nothing(engine, base):
    assert Bank.on(engine, base).prober.reach([]) == 0.0


def test_starts_whose_changes_are_alike_are_tried_once(engine, base):
    prober, form = Bank.on(engine, base).prober, Hypothesis("sensor_yaw", ("yaw",))
    probes = prober.probes(form, [{"sensor_yaw.yaw": 0.01 * k} for k in (1, 2, 3)])
    assert len(distinct_of(probes)) == 1


def test_starts_of_a_form_are_fewer_in_a_second_search(engine, base):
    effect = registry()["gear_backlash"]
    first = Bank.on(engine, base)
    first.rank([effect])
    for form in hypotheses_of(effect, len(engine.simulators)):
        assert 0 < len(first.distinct[form]) < len(declared_starts(form))


def test_flags_tell_the_active_effects():
    table = parameter_table()
    rows = [parameters({}), parameters({"floor_tilt.slope_y": 0.02, "sensor_yaw.yaw": 0.1})]
    flags = active_flags(np.array(rows))
    for row, on in zip(rows, flags, strict=True):
        named = tuple(name for name, flag in zip(registry(), on, strict=True) if flag)
        assert set(named) == set(table.active_effects(row))


def test_a_path_changes_nothing_where_no_effect_asks_for_it(engine):
    simulator = engine.simulators[0]
    values = parameters({"motor_deadband.offset": 0.05})[None]
    start = simulator.prepared.reference[0]
    with_path = simulate_many(values, simulator.drive, simulator.grid, start, simulator.track)
    np.testing.assert_array_equal(with_path, simulate_many(values, simulator.drive, simulator.grid, start))
