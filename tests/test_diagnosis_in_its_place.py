"""A rival in the place of one effect of a model is fitted from the robot as it had it alone."""

from diagnosis_robots import bank_of, fitted_number, laps

from fsm_calib.diagnosis.candidates.from_the_sheet import sought_from_the_sheet
from fsm_calib.diagnosis.verdict.in_its_place import on_its_own_ground
from fsm_calib.world2d.effects import registry


def test_a_rival_finds_its_way_from_its_own_ground_where_the_bent_base_loses_it():
    changes = {"motor_deadband__offset": -0.5, "gain_left": 0.25, "gain_right": 0.24}
    bank = bank_of(*(laps(seed, **changes) for seed in (0, 1)))
    scrub = bank.best_of(registry()["tyre_scrub"])
    lost = bank.best_of(registry()["motor_deadband"])
    alone = sought_from_the_sheet(bank.engine, bank.parent, [], [registry()["motor_deadband"]], {})[0]
    found = on_its_own_ground(bank, alone, scrub.fit, "tyre_scrub")
    assert found.evidence > lost.evidence + 500.0
    assert abs(fitted_number(found.fit, "motor_deadband.offset") + 0.5) < 0.05
    assert fitted_number(found.fit, "tyre_scrub.moment") == 0.0
