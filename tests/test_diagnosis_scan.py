"""Where fits start: declared starts are judged by what they win, and a marker by the jumps at its disc's edge."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_robots import bank_of, engine_of, recording, with_encoders

from fsm_calib.diagnosis.candidates.hypotheses import (
    Hypothesis,
    asked_for,
    declared_starts,
    hypotheses_of,
    starts_move_all,
)
from fsm_calib.diagnosis.candidates.outstanding import RARE
from fsm_calib.diagnosis.candidates.plausible import stands_out
from fsm_calib.diagnosis.candidates.ranked import parameters_of
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.candidates.scan import DEFAULTS, SCANS, scan_of
from fsm_calib.diagnosis.candidates.scan_markers import (
    HEADING,
    SHIFTED,
    TURNED,
    jump_evidence,
    jumps_of,
    likely_discs,
)
from fsm_calib.diagnosis.candidates.scan_slides import Slides
from fsm_calib.diagnosis.candidates.whole_base import fit_whole_base
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.diagnosis.proof.gates import DEFAULT_GATES
from fsm_calib.diagnosis.replay.prepared import prepare
from fsm_calib.diagnosis.shapes.score_tests import project, winnings
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

MARKER = {"turn": 0.12, "x": 0.15, "y": 0.0, "radius": 0.2}


@pytest.fixture(scope="module")
def marked():
    numbers = {f"misplaced_marker__{name}": value for name, value in MARKER.items()}
    return bank_of(*(recording(seed, **numbers) for seed in (0, 1)))


def fitted(bank, name):
    (ranked,) = bank.rank([registry()[name]])
    numbers = ranked.fit.slot_values()[-len(ranked.hypothesis.names) :]
    return dict(zip(ranked.hypothesis.names, numbers, strict=True))


def discs_of(bank, wrong=TURNED):
    pairs = zip(bank.engine.simulators, bank.parent.simulated, strict=True)
    return likely_discs([jumps_of(s.prepared, simulated) for s, simulated in pairs], wrong)


def test_a_mat_is_found_under_a_robot_whose_controller_makes_up_for_what_slows_it_down():
    mat = {"drag": 2.0, "x": 0.2, "y": 0.1, "half_x": 0.3, "half_y": 0.3, "spread": 1.0, "roundness": 1.0}
    stiff = {"speed_controller__hold": 12.0, "tau_forward": 0.05, "tau_turn": 0.05}
    hidden = {**stiff, **{f"rough_floor_patch__{name}": value for name, value in mat.items()}}
    engine = engine_of(*[recording(seed, 40.0, **hidden) for seed in (0, 1)])
    found = fitted(Bank.on(engine, fit_whole_base(engine, [])), "rough_floor_patch")
    assert np.hypot(found["x"] - 0.2, found["y"] - 0.1) < 0.05
    assert found["drag"] == pytest.approx(2.0, rel=0.2)


def test_every_effect_of_a_place_or_a_moment_has_a_scan():
    scanned = [effect for effect in registry().values() if effect.scan]
    assert {scan_of(effect) for effect in scanned} == set(SCANS.values())
    assert all(scan_of(effect) is None for effect in registry().values() if effect not in scanned)


@pytest.mark.parametrize(
    ("where", "when"), [("disc", "always"), ("anywhere", "span"), ("anywhere", "moment")]
)
def test_a_place_or_a_time_that_declares_nothing_to_act_on_is_tried_out(where, when):
    declared = registry()["low_friction_patch" if when == "always" else "motor_fault"]
    assert scan_of(replace(declared, where=where, when=when, acts_on="")) in DEFAULTS.values()


def test_the_chosen_start_wins_no_less_than_any_declared_one():
    bank = bank_of(recording(0, command_saturation__limit=0.45), recording(1, command_saturation__limit=0.45))
    form = Hypothesis("command_saturation", ("limit",))
    choices = declared_starts(form)
    (best,) = bank.prober.best_starts(form, choices, 1)
    declared = [bank.prober.gain(bank.prober.columns(with_values(bank.parent.values, c))) for c in choices]
    assert best.promise >= max(declared) - 1e-6  # columns that pass a filter together are rounded otherwise


def test_a_limit_that_is_seldom_reached_is_found():
    bank = bank_of(recording(0, command_saturation__limit=0.45), recording(1, command_saturation__limit=0.45))
    (ranked,) = bank.rank([registry()["command_saturation"]])
    assert ranked.fit.slot_values()[-1] == pytest.approx(0.45, abs=0.01)


@pytest.mark.parametrize(("noticed", "fitted"), [(14.0, True), (np.inf, False)])
def test_what_promises_nothing_is_fitted_only_beside_what_is_noticed(monkeypatch, noticed, fitted):
    bank, begun = bank_of(recording(0, 40.0, motor_deadband__offset=0.05)), []
    fit = Bank._begun
    monkeypatch.setattr(Bank, "_begun", lambda *a, **k: begun.append(a[1].effect) or fit(*a, **k))
    asked = [registry()[name] for name in ("motor_deadband", "floor_tilt")]
    first, last = bank.rank(asked, noticed=noticed)
    assert (first.name, last.name) == ("motor_deadband", "floor_tilt")
    assert ("floor_tilt" in begun) == fitted
    assert last.gain < 2.0


def test_starts_that_leave_a_number_where_it_is_do_not_judge_a_form():
    forms = {form.closure: form for form in hypotheses_of(registry()["caster_drag"], 1)}
    assert starts_move_all(forms["drag alone"])
    assert not starts_move_all(forms["drag and arm"])  # a caster may sit anywhere


def test_what_a_start_promises_in_one_recording_is_what_it_promises_where_the_others_have_none():
    bank = bank_of(recording(0, motor_deadband__offset=0.02), recording(1))
    prober, size = bank.prober, {"motor_deadband.offset_left": 0.02, "motor_deadband.offset_right": 0.02}
    (promised,) = prober._promised_by_run([with_values(bank.parent.values, size)]).T
    for run in (0, 1):
        column = project(prober.residual, prober.columns(with_values(bank.parent.values, size, run)))[:, 0]
        amplitude = (column @ prober.residual.psi) / (column @ column)
        won = 0.5 * amplitude * abs(amplitude) * (column @ column)
        assert promised[run] == pytest.approx(won, rel=1e-6)


def test_the_jumps_show_where_a_turned_marker_lies(marked):
    best = discs_of(marked)[0]
    assert np.hypot(best.x - MARKER["x"], best.y - MARKER["y"]) < 0.06
    assert best.radius == pytest.approx(MARKER["radius"], abs=0.06)
    assert best.turn == pytest.approx(MARKER["turn"], rel=0.4)


def test_a_turned_marker_is_fitted_from_there(marked):
    found = fitted(marked, "misplaced_marker")
    assert found["turn"] == pytest.approx(MARKER["turn"], rel=0.1)
    assert np.hypot(found["x"] - MARKER["x"], found["y"] - MARKER["y"]) < 0.03


def test_a_shifted_marker_or_the_rest_of_the_map_shifted_back_is_found():
    numbers = {"misplaced_marker__shift_x": 0.03, "misplaced_marker__shift_y": -0.02}
    place = {f"misplaced_marker__{name}": MARKER[name] for name in ("x", "y", "radius")}
    best = discs_of(bank_of(*(recording(seed, 40.0, **numbers, **place) for seed in (0, 1))), SHIFTED)[0]
    sign = np.sign(best.shift_x)
    assert sign * np.array([best.shift_x, best.shift_y]) == pytest.approx((0.03, -0.02), abs=0.01)


def test_headings_that_alone_are_wrong_in_a_place_are_found_and_told_from_a_turned_marker():
    numbers = {f"misplaced_marker__{name}": value for name, value in MARKER.items()}
    bank = bank_of(*(recording(seed, **numbers, misplaced_marker__rigid=0.0) for seed in (0, 1)))
    assert discs_of(bank, HEADING)[0].promise > discs_of(bank, TURNED)[0].promise
    (ranked,) = bank.rank([registry()["misplaced_marker"]])
    assert ranked.hypothesis.closure == "heading alone"
    found = dict(zip(ranked.hypothesis.names, ranked.fit.slot_values()[-4:], strict=True))
    assert found["turn"] == pytest.approx(MARKER["turn"], rel=0.1)
    assert np.hypot(found["x"] - MARKER["x"], found["y"] - MARKER["y"]) < 0.03


def test_a_marker_whose_error_fades_towards_the_next_ones_is_blended():
    blended = {**MARKER, "shift_x": 0.03, "shift_y": -0.02, "radius": 0.3, "fade": 0.12}
    numbers = {f"misplaced_marker__{name}": value for name, value in blended.items()}
    (ranked,) = bank_of(*(recording(seed, **numbers) for seed in (0, 1))).rank(
        [registry()["misplaced_marker"]]
    )
    assert ranked.hypothesis.closure == "blended"
    found = dict(zip(ranked.hypothesis.names, ranked.fit.slot_values()[-7:], strict=True))
    assert found["fade"] == pytest.approx(0.12, abs=0.03)
    assert found["turn"] == pytest.approx(0.12, rel=0.15)
    assert found["shift_x"] == pytest.approx(0.03, abs=0.008)


@pytest.mark.parametrize(("face", "view"), [(0.9, 0.6), (-1.6, 1.2), (2.5, 1.8)])
def test_a_board_that_counts_only_while_the_robot_looks_its_way_is_found_with_its_heading(face, view):
    board = {**MARKER, "shift_x": 0.03, "shift_y": -0.02, "radius": 0.35, "face": face, "view": view}
    numbers = {f"misplaced_marker__{name}": value for name, value in board.items()}
    (ranked,) = bank_of(*(recording(seed, **numbers) for seed in (0, 1))).rank(
        [registry()["misplaced_marker"]]
    )
    assert ranked.hypothesis.closure == "seen from one side"
    found = dict(zip(ranked.hypothesis.names, ranked.fit.slot_values()[-8:], strict=True))
    assert np.angle(np.exp(1j * (found["face"] - face))) == pytest.approx(0.0, abs=0.1)
    assert found["view"] == pytest.approx(view, abs=0.1)
    assert found["turn"] == pytest.approx(MARKER["turn"], rel=0.15)


def test_a_scan_that_tells_a_heading_asks_for_the_closure_that_has_one():
    effect = registry()["misplaced_marker"]
    disc = {"turn", "shift_x", "shift_y", "x", "y", "radius", "rigid"}
    assert [c.name for c in asked_for(effect, {*disc, "face", "view"})] == ["seen from one side"]
    assert asked_for(effect, disc) == list(effect.competing)


def test_headings_that_are_wrong_over_a_metre_and_more_are_found_by_the_edge_of_that_floor():
    far = {"turn": 0.06, "x": 0.3, "y": 0.5, "radius": 0.7}
    numbers = {f"misplaced_marker__{name}": value for name, value in far.items()}
    bank = bank_of(*(recording(seed, **numbers, misplaced_marker__rigid=0.0) for seed in (0, 1)))
    assert max(disc.radius for disc in discs_of(bank, HEADING)[:3]) > 0.5
    found = fitted(bank, "misplaced_marker")
    assert found["turn"] == pytest.approx(0.06, rel=0.05)
    assert found["radius"] == pytest.approx(0.7, abs=0.1)


def test_the_disc_is_found_to_a_centimetre_where_poses_come_fast():
    marker = {"turn": 0.12, "x": 0.16, "y": 0.02, "radius": 0.21}
    numbers = {f"misplaced_marker__{name}": value for name, value in marker.items()}
    best = discs_of(bank_of(*(recording(seed, rate=30.0, **numbers) for seed in (0, 1))))[0]
    assert (best.x, best.y, best.radius) == pytest.approx((0.16, 0.02, 0.21), abs=0.01)


def test_four_outliers_in_a_row_are_no_evidence_of_a_marker():
    drive = recording(0)
    x, theta = drive.pose.x.copy(), drive.pose.theta.copy()
    x[420:424] += 0.05
    theta[420:424] += 0.1
    bank = bank_of(replace(drive, pose=replace(drive.pose, x=x, theta=theta)))
    prepared = [s.prepared for s in bank.engine.simulators]
    assert jump_evidence(prepared, bank.parent.simulated, bank.engine.count) < 10.0


def test_jumps_of_a_map_that_the_same_frames_told_are_no_evidence_of_a_marker(marked):
    prepared = [s.prepared for s in marked.engine.simulators]
    own = [replace(p, settings=replace(p.settings, own_map=True)) for p in prepared]
    assert jump_evidence(prepared, marked.parent.simulated, marked.engine.count) > 100.0
    assert jump_evidence(own, marked.parent.simulated, marked.engine.count) == -np.inf


def test_two_outliers_in_a_row_are_no_marker():
    drive = recording(0)
    x = drive.pose.x.copy()
    x[200:202] += 0.1
    spoilt = bank_of(replace(drive, pose=replace(drive.pose, x=x)))
    assert all(disc.promise < 25.0 for disc in discs_of(spoilt))


def test_the_jumps_of_a_plain_robot_are_noise():
    bank = bank_of(recording(0))
    assert all(disc.promise < 25.0 for disc in discs_of(bank))


def test_a_push_is_found_and_stands_out_from_other_moments():
    push = {"external_push__impulse_turn": 0.06, "external_push__start": 15.2}
    bank = bank_of(recording(0, **push), recording(1))
    best = bank.scanner.pushes(registry()["external_push"])[0]
    assert best.run == 0
    assert best.changes["external_push.start"] == pytest.approx(
        15.2, abs=0.4
    )  # a step and a half of the scan
    assert 0.0 < best.chance < 1e-4


def test_without_a_push_no_moment_stands_out():
    best = bank_of(recording(0), recording(1)).scanner.pushes(registry()["external_push"])[0]
    assert best.chance > 0.01


@pytest.mark.parametrize(("chance", "asked"), [(0.9 * RARE, True), (1.1 * RARE, False)])
def test_a_moment_is_asked_where_chance_hardly_equals_it_and_its_evidence_is_an_effects(chance, asked):
    push = bank_of(recording(0)).best_of(registry()["external_push"])
    rare = replace(push, hypothesis=replace(push.hypothesis, chance=chance), evidence=20.0)
    assert stands_out(rare, 14.0) is asked
    assert not stands_out(rare, 28.0)


def test_what_is_asked_by_chance_may_still_be_said():
    """Of the odds against a name the chance takes the catalogue's number: 0.18, where 0.67 are the most."""
    assert (
        RARE * len(registry()) < 0.5 * (1.0 - DEFAULT_GATES.least_confidence) / DEFAULT_GATES.least_confidence
    )


PATCH = {"loss": 0.75, "x": 0.15, "y": 0.05, "radius": 0.2, "spread": 0.0}


@pytest.fixture(scope="module")
def slippery():
    numbers = {f"low_friction_patch__{name}": value for name, value in PATCH.items()}
    return bank_of(*(recording(seed, **numbers) for seed in (0, 1)))


def test_a_slippery_spot_is_found_from_anywhere_on_the_floor(slippery):
    best = slippery.scanner.slippery_areas(registry()["low_friction_patch"])[0]
    x, y = (best.changes[f"low_friction_patch.{name}"] for name in ("x", "y"))
    assert np.hypot(x - PATCH["x"], y - PATCH["y"]) < 0.15
    assert best.promise > 20.0


def test_events_of_poses_and_wheels_that_come_at_once_ask_no_more_of_the_tyres():
    def demand(bank):
        scan = bank.scanner
        effect = registry()["low_friction_patch"]
        (asked, *_) = Slides(bank.parent, scan.residual, effect, scan.passages, scan.size).demand
        return asked

    both = demand(bank_of(with_encoders(0), with_encoders(1)))
    assert np.isfinite(both).all()
    assert both.max() == pytest.approx(demand(bank_of(recording(0), recording(1))).max(), rel=0.15)


def on_wide_wheels(seed, **changes):
    drive = recording(seed, axle_length=0.45, **changes)
    return replace(drive, robot=replace(drive.robot, axle_length=0.45))


def test_a_spot_that_one_wheel_of_a_large_robot_is_in_at_a_time_is_found_there():
    numbers = {"low_friction_patch__loss": 0.75, "low_friction_patch__x": 0.3, "low_friction_patch__y": 0.1}
    bank = bank_of(*(on_wide_wheels(s, low_friction_patch__radius=0.3, **numbers) for s in (0, 1)))
    best, *others = bank.scanner.slippery_areas(registry()["low_friction_patch"])
    x, y = (best.changes[f"low_friction_patch.{name}"] for name in ("x", "y"))
    assert np.hypot(x - 0.3, y - 0.1) < 0.2
    assert best.changes["low_friction_patch.spread"] == 1.0
    assert best.promise > 10.0 * max(other.promise for other in others)


def test_a_puddle_that_is_smaller_than_half_a_turn_is_found_and_fitted():
    puddle = {"loss": 0.8, "x": 0.3, "y": 0.1, "radius": 0.12}
    numbers = {f"low_friction_patch__{name}": value for name, value in puddle.items()}
    bank = bank_of(*(recording(seed, **numbers) for seed in (0, 1)))
    (ranked,) = bank.rank([registry()["low_friction_patch"]])
    x, y = (ranked.fit.values[0, parameter_table().place(f"low_friction_patch.{n}")] for n in ("x", "y"))
    assert ranked.gain > 100.0
    assert np.hypot(x - puddle["x"], y - puddle["y"]) < 0.08


def test_a_slippery_spot_is_fitted_from_there(slippery):
    found = fitted(slippery, "low_friction_patch")
    assert found["loss"] == pytest.approx(PATCH["loss"], abs=0.1)
    assert np.hypot(found["x"] - PATCH["x"], found["y"] - PATCH["y"]) < 0.1


def test_what_a_change_wins_is_the_difference_of_log_likelihoods(slippery):
    engine, base = slippery.engine, slippery.parent
    values = with_values(base.values, {f"low_friction_patch.{name}": value for name, value in PATCH.items()})
    simulated = [s.increments(v[None])[0] for s, v in zip(engine.simulators, values, strict=True)]
    white = engine.white_columns(
        slippery.prober.residual.whiteners,
        [(after - before)[:, :, None] for after, before in zip(simulated, base.simulated, strict=True)],
    )
    whiteners = engine.whiteners(base.noise)
    alone = replace(slippery.prober.residual, basis=np.zeros((engine.count, 0)))
    expected = engine.log_likelihood(whiteners, simulated) - engine.log_likelihood(whiteners, base.simulated)
    assert winnings(alone, white)[0] == pytest.approx(expected, abs=1e-6)
    assert winnings(slippery.prober.residual, white)[0] >= expected


def test_a_push_so_strong_that_its_poses_are_outliers_is_found():
    numbers = {"impulse_turn": 0.04, "impulse_y": 0.8, "start": 17.0}
    pushed = recording(0, **{f"external_push__{name}": value for name, value in numbers.items()})
    best = bank_of(pushed, recording(1)).scanner.pushes(registry()["external_push"])[0]
    assert best.run == 0
    assert best.changes["external_push.start"] == pytest.approx(17.0, abs=0.3)
    assert best.chance < 1e-6


def test_a_hand_that_leans_on_the_robot_for_seconds_is_found_with_how_long():
    numbers = {"impulse_x": 0.5, "impulse_turn": 0.1, "start": 17.0, "duration": 2.2}
    pushed = recording(0, **{f"external_push__{name}": value for name, value in numbers.items()})
    bank = bank_of(pushed, recording(1))
    best = max(bank.scanner.pushes(registry()["external_push"]), key=lambda candidate: candidate.promise)
    assert best.run == 0
    assert best.changes["external_push.duration"] == pytest.approx(2.2, abs=0.9)
    found = fitted(bank, "external_push")
    assert found["duration"] == pytest.approx(2.2, abs=0.2)
    assert found["start"] == pytest.approx(17.0, abs=0.2)


def test_a_kick_is_not_asked_how_long_it_lasted():
    push = {"external_push__impulse_turn": 0.06, "external_push__start": 15.2}
    bank = bank_of(recording(0, **push), recording(1))
    closures = {form.closure for form, _ in bank.plans(registry()["external_push"])}
    assert closures == {"push"}


def test_several_pushes_of_a_drive_are_offered_and_fitted_together():
    begins = {"start": 15.2, "start_2": 6.0, "start_3": 29.0}
    turns = {"impulse_turn": 0.06, "impulse_turn_2": -0.05, "impulse_turn_3": 0.05}
    numbers = {f"external_push__{name}": value for name, value in {**begins, **turns}.items()}
    bank = bank_of(recording(0, 40.0, **numbers), recording(1))
    (form, (start,)), *others = (
        p for p in bank.plans(registry()["external_push"]) if "pushes" in p[0].closure
    )
    assert (form.closure, form.run, others) == ("three pushes", 0, [])
    found = bank.fit(form, start)
    told = sorted(float(parameters_of(found)[name][0]) for name in begins)
    np.testing.assert_allclose(told, sorted(begins.values()), atol=0.1)
    assert stands_out(found, 14.0)


def test_disturbances_fade_only_after_a_robot_has_come_to_rest():
    prepared = prepare(recording(0))
    moving, stopped = prepared.moving, prepared.recording.command
    rests = [
        t
        for t, left, right in zip(stopped.time, stopped.left, stopped.right, strict=True)
        if left == right == 0
    ]
    at = np.interp(np.array(rests[:-1]) + 0.15, prepared.time, moving)
    assert at.min() > 0.5


def test_a_rug_as_wide_as_the_drive_is_sought_as_one_and_the_same_place_once():
    rug = {"drag": 0.05, "x": 0.3, "y": 0.2, "half_x": 0.6, "half_y": 0.5, "spread": 1.0, "roundness": 1.0}
    hidden = {f"rough_floor_patch__{name}": value for name, value in rug.items()}
    bank = bank_of(*(recording(seed, 40.0, **hidden) for seed in (0, 1)))
    found = bank.scanner.candidates(registry()["rough_floor_patch"])
    first = {name.split(".")[1]: value for name, value in found[0].changes.items()}
    assert np.hypot(first["x"] - 0.3, first["y"] - 0.2) < 0.15
    assert min(first["half_x"], first["half_y"]) > 0.4
    places = [tuple(candidate.changes.values()) for candidate in found]
    assert all(np.abs(np.subtract(a, b)).max() > 0.05 for i, a in enumerate(places) for b in places[:i])
