"""A mat that was hardly left looks like the robot's own friction: it is believed in until a drive tells."""

import numpy as np
import pytest
from diagnosis_robots import decided, engine_of, recording

from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.design.belief_of import belief_of
from fsm_calib.diagnosis.design.floor_here import MARGIN, floor_instead, prior_of, visited
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.world2d.dynamics import AXLE
from fsm_calib.world2d.effects import registry

ROUGH, FRICTION = registry()["rough_floor_patch"], registry()["coulomb_friction"]
DRAG = 0.5  # N
NUMBERS = {"drag": DRAG, "x": 0.1, "y": -0.1, "half_x": 0.6, "half_y": 0.6, "spread": 1.0}
MAT = {f"rough_floor_patch__{name}": value for name, value in NUMBERS.items()}


def fitted(**changes):
    """Return engine, base robot and the evidence of dry friction, of a robot that was driven for 10 s."""
    engine = engine_of(recording(3, 10.0, **changes))
    base = fit_base(engine)
    return engine, base, Bank.on(engine, base).best_of(FRICTION).evidence


@pytest.fixture(scope="module")
def on_a_mat():
    return fitted(**MAT)


def test_a_mat_that_was_not_left_explains_what_friction_does(on_a_mat):
    engine, base, added = on_a_mat
    here = max(floor_instead(engine, base, added, [ROUGH]), key=lambda here: here.evidence)
    assert added > 50.0
    assert here.evidence > 0.75 * added
    assert here.found.hypothesis.names == ("drag",)
    assert here.found.fit.slot_values()[-1] == pytest.approx(DRAG, abs=0.1)


def test_a_robot_with_friction_of_its_own_may_have_stood_on_one_by_the_prior_alone():
    engine, base, added = fitted(coulomb_friction__friction=0.012)
    for here in floor_instead(engine, base, added, [ROUGH]):
        assert here.evidence < added + 5.0
        assert here.prior < -1.0


def test_a_belief_in_friction_holds_the_floor_that_was_driven_on():
    decision = decided([recording(3, 10.0, **MAT)], ["coulomb_friction", "rough_floor_patch"])
    assert [b.name for b in decision.named] == ["coulomb_friction"]
    assert {("coulomb_friction",), ("rough_floor_patch",)} <= {
        h.names for h in belief_of(decision).hypotheses
    }


def test_what_was_visited_reaches_to_both_ends_of_the_axle(on_a_mat):
    engine, base, _ = on_a_mat
    poses, area = engine.simulators[0].prepared.poses, visited(engine, base)
    reach = 0.5 * base.values[0, AXLE] + MARGIN
    assert area.x + area.half_x == pytest.approx(poses.x.max() + reach)
    assert area.y - area.half_y == pytest.approx(poses.y.min() - reach)


def test_a_place_of_typical_size_is_believed_in_with_odds_of_e_to_minus_two():
    typical = [ROUGH.parameter(name).typical for name in ("half_x", "half_y")]
    assert prior_of(ROUGH, *typical) == pytest.approx(-2.0)
    assert prior_of(ROUGH, 10.0, 10.0) < -50.0


def test_what_was_driven_all_over_a_room_is_not_asked_of_a_mat(monkeypatch, on_a_mat):
    engine, base, added = on_a_mat
    far = engine_of(recording(3, 10.0))
    poses = far.simulators[0].prepared.poses
    monkeypatch.setitem(poses.__dict__, "x", np.linspace(-4.0, 4.0, len(poses.x)))
    assert list(floor_instead(engine, base, added, [ROUGH]))
    assert list(floor_instead(far, base, added, [ROUGH])) == []
