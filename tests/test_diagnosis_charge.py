"""A battery that is as full in one drive as it is not in another: motors faster by a factor, and no drift."""

from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis_robots import GAIN_LEFT, GAIN_RIGHT, engine_of, judged, recording

from fsm_calib.diagnosis.candidates.charge import charges_told
from fsm_calib.diagnosis.candidates.whole_base import fit_whole_base
from fsm_calib.diagnosis.design.belief_of import belief_of
from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.diagnosis.proof.transfer import on_new_recording
from fsm_calib.diagnosis.replay.prepared import prepare
from fsm_calib.diagnosis.replay.simulator import make_simulator
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

SIDES = ("left", "right")
DRIFTS = ("battery_sag", "motor_warmup")
RIVALS = (
    *DRIFTS,
    "motor_deadband",
    "motor_gain_curve",
    "command_saturation",
    "coulomb_friction",
    "clock_drift",
)
WITHOUT = [name for name in registry() if name not in RIVALS]
CHARGE, GAINS = (
    parameter_table().place("charge"),
    [parameter_table().place(f"gain_{s}") for s in ("left", "right")],
)


def charged(seed, share, **changes):
    """Return a drive of a robot whose battery has this share of its first voltage."""
    return recording(seed, gain_left=GAIN_LEFT * share, gain_right=GAIN_RIGHT * share, **changes)


def based(*recordings, rivals=DRIFTS):
    engine = engine_of(*recordings)
    return engine, fit_whole_base(engine, [registry()[name] for name in rivals])


def test_a_drive_with_an_emptier_battery_has_a_charge_of_its_own():
    _, fit = based(charged(0, 1.0), charged(1, 0.93), charged(2, 1.04))
    found = {s.run: (value, variance**0.5) for s, value, variance in fit.numbers() if s.place == CHARGE}
    assert found[1][0] == pytest.approx(0.93, abs=4.0 * found[1][1])
    assert found[2][0] == pytest.approx(1.04, abs=4.0 * found[2][1])
    assert fit.values[0, GAINS] == pytest.approx([GAIN_LEFT, GAIN_RIGHT], rel=0.01)


def test_drives_that_are_alike_share_one_gain():
    _, fit = based(charged(0, 1.0), charged(1, 1.0))
    assert CHARGE not in [slot.place for slot in fit.slots]


def test_one_drive_alone_has_no_charge():
    _, fit = based(charged(0, 0.9))
    assert CHARGE not in [slot.place for slot in fit.slots]


def test_a_battery_that_sags_is_no_charge():
    _, fit = based(*(recording(seed, battery_sag__per_charge=0.006) for seed in (0, 1)))
    assert CHARGE not in [slot.place for slot in fit.slots]


def test_a_charge_stands_for_a_simulation_too():
    values = parameter_table().null
    values[CHARGE] = 0.9
    weaker = parameter_table().null
    weaker[GAINS] *= 0.9
    simulator = make_simulator(prepare(recording(0)))
    full, plain = (simulator.increments(v[None])[0] for v in (values, weaker))
    assert full == pytest.approx(plain, abs=1e-9)


def test_a_recording_that_took_no_part_is_predicted_with_the_mean_charge():
    _, fit = based(charged(0, 1.0), charged(1, 0.9))
    alone = engine_of(charged(3, 0.95))
    assert on_new_recording(alone, fit)[0, CHARGE] == pytest.approx(0.95, abs=0.01)


def test_a_match_tells_by_how_much_the_drives_differ():
    found = diagnose([charged(0, 1.0), charged(1, 0.93)], without=WITHOUT)
    assert found.decision.outcome == "match"
    assert any("in recording 2 both motors were 7.0 +- " in note and "slower" in note for note in found.notes)
    assert found.verdict.base["charge_2"].value == pytest.approx(0.93, abs=0.01)


def test_a_charge_of_less_than_a_hundredth_is_not_told():
    numbers = [(SimpleNamespace(place=CHARGE, run=1), 0.993, 1e-8)]
    assert charges_told(SimpleNamespace(numbers=lambda: numbers)) == []


def test_a_dead_zone_is_named_beside_two_charges():
    drives = [charged(seed, share, motor_deadband__offset=0.06) for seed, share in ((0, 1.0), (1, 0.93))]
    found = diagnose(drives, without=WITHOUT)
    assert [belief.name for belief in found.decision.named] == ["motor_deadband"]


def test_the_next_drive_is_designed_for_a_robot_without_a_charge_of_its_own():
    drives = [charged(0, 1.0), charged(1, 0.93), charged(2, 1.04)]
    belief = belief_of(diagnose(drives, without=WITHOUT).decision)
    assert all(len(set(h.places)) == len(h.places) for h in belief.hypotheses)
    assert np.all(np.isfinite(belief.hypotheses[0].covariance))


def test_motors_that_grow_stronger_as_they_are_driven_have_no_battery_that_charges():
    """Grease that thins: a cell whose voltage rose with the charge drawn from it would do as well for a while."""
    warm = {
        "motor_warmup__change_left": 0.08,
        "motor_warmup__change_right": 0.08,
        "motor_warmup__effort": 30.0,
    }
    decision = judged(("battery_sag", "motor_warmup"), **warm)
    assert [belief.name for belief in decision.named] == ["motor_warmup"]
    assert [r.name for r in decision.ranking if r.evidence > 0.0] == ["motor_warmup"]


def test_hot_windings_of_motors_that_brake_themselves_are_no_battery():
    both = {
        f"motor_warmup__{what}_{side}": value
        for what, value in (("winding", 0.5), ("change", -0.08))
        for side in SIDES
    }
    decision = judged(("battery_sag", "motor_warmup"), motor_warmup__effort=10.0, **both)
    assert [belief.name for belief in decision.named] == ["motor_warmup"]
    assert decision.model.effects[0].hypothesis.closure == "both windings, speeds too"
