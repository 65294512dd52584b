"""A wheel that is not round is found though nobody measured its angle and its radius is stated wrong."""

from dataclasses import replace

import pytest
from diagnosis_robots import engine_of, fitted_number, recording, with_encoders

from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

NAME = "wheel_eccentricity"


def best(share, stated, **changes):
    """Return what is found where the sheet says `stated` times the radius and the right wheel is off by `share`."""
    numbers = {"wheel_eccentricity__right": share, **changes}
    drives = [recording(seed, **numbers) for seed in (0, 1)]
    drives = [replace(d, robot=replace(d.robot, wheel_radius=stated * d.robot.wheel_radius)) for d in drives]
    engine = engine_of(*drives)
    return Bank.on(engine, fit_base(engine)).best_of(registry()[NAME])


def number(found, name):
    return fitted_number(found.fit, f"{NAME}.{name}")


@pytest.mark.parametrize("lobes", [1.0, 2.0])
def test_a_radius_that_is_stated_2_per_cent_wrong_hides_no_uneven_wheel(lobes):
    right, wrong = (best(0.1, stated, wheel_eccentricity__lobes=lobes) for stated in (1.0, 0.98))
    assert right.evidence > 100.0
    assert wrong.evidence > 0.7 * right.evidence
    assert number(wrong, "pace") == pytest.approx(0.98)
    assert number(wrong, "right") == pytest.approx(0.1, abs=0.02)


def test_a_round_wheel_has_no_pace_that_makes_it_uneven():
    assert best(0.0, 0.98).evidence < 0.0


def test_a_wheel_whose_angle_is_measured_has_no_pace_to_choose():
    numbers = {f"{NAME}__right": 0.1}
    engine = engine_of(*(with_encoders(seed, **numbers) for seed in (0, 1)))
    bank = Bank.on(engine, fit_base(engine))
    begun = [start for _, starts in bank.plans(registry()[NAME]) for start in starts]
    pace = parameter_table().place(f"{NAME}.pace")
    assert len(begun) > 1
    assert all((start.values[:, pace] == 1.0).all() for start in begun)
    assert number(bank.best_of(registry()[NAME]), "right") == pytest.approx(0.1, abs=0.01)
