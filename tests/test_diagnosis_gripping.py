"""A grip of the whole floor that stands in for a slippery spot gives way to it; one of a slippery floor stays."""

from dataclasses import replace

import numpy as np
from diagnosis_robots import engine_of, fitted_number, recording, selector_on

from fsm_calib.diagnosis.candidates.free_number import found_free
from fsm_calib.diagnosis.candidates.tyre_grip import with_free_grip
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.verdict.gripping import GRIP, likelier_if_gripping

SPOT = {"loss": 0.75, "x": 0.15, "y": 0.05, "radius": 0.2}
DRY = {"coulomb_friction__friction": 0.02}


def grown_on_a_free_grip(**robot):
    """Return what selects among a spot and dry friction, and the dry friction that it found on tyres of free grip."""
    engine = engine_of(*(recording(seed, **DRY, **robot) for seed in (0, 1)))
    base = with_free_grip(engine, fit_base(engine))
    selector = selector_on(base, engine, "coulomb_friction", "low_friction_patch")
    alone = replace(selector, catalogue=[e for e in selector.catalogue if e.name == "coulomb_friction"])
    return selector, alone.grown(alone.first_ranked()[1])


def test_a_spot_that_a_free_grip_has_taken_is_found_again():
    spot = {f"low_friction_patch__{name}": value for name, value in SPOT.items()}
    selector, grown = likelier_if_gripping(*grown_on_a_free_grip(**spot))
    assert {e.name for e in grown.effects} == {"coulomb_friction", "low_friction_patch"}
    assert not found_free(selector.base, GRIP)
    x, y = (fitted_number(grown.fit, f"low_friction_patch.{name}") for name in ("x", "y"))
    assert np.hypot(x - SPOT["x"], y - SPOT["y"]) < 0.2


def test_tyres_on_a_slippery_floor_keep_their_grip():
    given = grown_on_a_free_grip(friction=0.3)
    assert likelier_if_gripping(*given) == given


def test_a_model_without_room_for_more_is_left_as_it_is():
    selector, grown = grown_on_a_free_grip(friction=0.3)
    full = replace(selector, most=1)
    assert likelier_if_gripping(full, grown) == (full, grown)
