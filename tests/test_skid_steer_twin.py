"""Wheels that seem farther apart by less than their tyres' contact is wide do not skid."""

import pytest

from fsm_calib.world2d.effects.skid_steer import EFFECT, may_be_a_wide_contact

TWIN_TYRES = {"stretch": 0.118, "axle_length": 0.227, "tyre_scrub.spin": 0.073}


@pytest.mark.parametrize(
    ("changed", "is_twin"),
    [
        ({}, True),
        ({"stretch": -0.118}, True),
        ({"stretch": 0.8}, False),
        ({"axle_length": 1.08}, False),
        ({"tyre_scrub.spin": 0.0}, False),
    ],
)
def test_a_stretch_within_the_contact_is_the_tyres(changed, is_twin):
    assert may_be_a_wide_contact({**TWIN_TYRES, **changed}) is is_twin


def test_treads_that_wind_up_or_drift_are_none_of_a_tyres():
    assert [closure.name for closure in EFFECT.closures if closure.has_twin] == ["full"]
