"""A place effect of one file outside the package is searched and named as the package's own; so are times."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from diagnosis_robots import decided, engine_of, judged, recording

from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.candidates.scan import scan_of
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.world2d.effects import add_effects, registry
from fsm_calib.world2d.effects.outside import VARIABLE

STICKY = Path(__file__).parent / "effects_outside" / "sticky_spot.py"
PLACES = ("sticky_spot", "rough_floor_patch")


@pytest.fixture(scope="module")
def with_sticky_spot():
    patch = pytest.MonkeyPatch()
    patch.setenv(VARIABLE, "")
    add_effects([STICKY])
    yield
    patch.undo()
    add_effects(())


def best_of(name, numbers):
    """Return what trying out promises most for an effect that declares nothing to act on, on two drives."""
    hidden = {f"{name}__{parameter}": value for parameter, value in numbers.items()}
    engine = engine_of(*(recording(0, **hidden), recording(1)))
    effect = replace(registry()[name], acts_on="")
    return scan_of(effect)(Bank.on(engine, fit_base(engine)).scanner, effect)[0]


@pytest.mark.slow
def test_a_sticky_spot_of_a_file_is_named_beside_the_rough_patch(with_sticky_spot):
    truth = {"pull": 1.6, "x": 0.1, "y": 0.05, "radius": 0.18}
    hidden = {f"sticky_spot__{name}": value for name, value in truth.items()}
    decision = decided([recording(seed, 28.0, **hidden) for seed in (0, 1)], PLACES)
    assert decision.outcome == "explained"
    assert [effect.name for effect in decision.model.effects] == ["sticky_spot"]
    second = next(ranked for ranked in decision.ranking if ranked.name != "sticky_spot")
    assert decision.ranking[0].evidence > second.evidence + 100.0


@pytest.mark.slow
def test_a_rough_patch_keeps_its_name_beside_the_sticky_spot(with_sticky_spot):
    truth = {"drag": 0.9, "x": 0.1, "y": 0.05, "half_x": 0.18, "half_y": 0.18, "roundness": 1.0}
    decision = judged(PLACES, **{f"rough_floor_patch__{name}": value for name, value in truth.items()})
    assert [effect.name for effect in decision.model.effects] == ["rough_floor_patch"]


def test_a_moment_is_found_by_trying_it_out():
    best = best_of("external_push", {"impulse_x": 0.5, "impulse_turn": 0.05, "start": 15.2})
    assert best.run == 0
    assert best.changes["external_push.start"] == pytest.approx(15.2, abs=0.4)
    assert best.chance < 1e-3


def test_a_span_is_found_by_trying_it_out():
    best = best_of("motor_fault", {"loss_left": 0.2, "start": 12.0, "duration": 9.0})
    begin, length = (best.changes[f"motor_fault.{name}"] for name in ("start", "duration"))
    assert best.run == 0
    assert np.abs([begin - 12.0, begin + length - 21.0]).max() < 1.0
