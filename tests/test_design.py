"""The designer of drives: what it promises, what it picks, and the bounds that it keeps."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_robots import recording, robot

from fsm_calib.diagnosis.candidates.ranked import EXACT
from fsm_calib.diagnosis.design.area import Area, Disc
from fsm_calib.diagnosis.design.belief import Belief, Hypothesis, kept
from fsm_calib.diagnosis.design.belief_of import belief_of, prior_belief
from fsm_calib.diagnosis.design.designer import NoDrive, Wishes, design, random_drive
from fsm_calib.diagnosis.design.foresight import Foresight
from fsm_calib.diagnosis.design.separation import (
    Columns,
    Pairs,
    distances,
    expected_posteriors,
    information,
)
from fsm_calib.diagnosis.design.sight import Sight
from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.diagnosis.likelihood.noise import Noise
from fsm_calib.diagnosis.proof.gap import Gap
from fsm_calib.diagnosis.verdict.support import RivalGap
from fsm_calib.types import Pose2
from fsm_calib.world2d.parameters import NUISANCE, parameter_table

AREA = Area(-1.0, 1.0, -1.0, 1.0)
BASE_SPREAD = np.array([0.03, 0.03, 0.003, 0.02, 0.03])


def hypothesis(probability, **changes):
    """Return an explanation by the effects of `changes` (full name with `__`), its base robot a little uncertain."""
    table, values = parameter_table(), robot(**changes)
    own = [name.replace("__", ".") for name in changes]
    places = tuple(table.place(name) for name in (*NUISANCE, *own))
    spread = np.concatenate([BASE_SPREAD, [0.1 * abs(values[table.place(name)]) for name in own]])
    steps = np.array([table.entries[place].difference_step for place in places])
    names = tuple(dict.fromkeys(name.split(".")[0] for name in own))
    return Hypothesis(names, probability, values, places, np.diag(spread**2), steps)


def belief(*hypotheses):
    return Belief(tuple(hypotheses), len(NUISANCE), robot(), Noise())


RIVALS = belief(
    hypothesis(0.5, motor_deadband__offset=0.04),
    hypothesis(0.3, tyre_scrub__moment=0.02),
    hypothesis(0.2),
)


def planned(of, area=AREA, start=None, seed=0, **wishes):
    return design(of, area, start or Pose2(), np.random.default_rng(seed), Wishes(**wishes))


def toy(rng, spread=0.5):
    """Return whitened columns (20, 5) of two means, a shared and two own derivatives, and where they stand."""
    white = np.column_stack([rng.normal(size=(20, 5)), np.zeros(20)])
    columns = Columns(
        6, np.arange(2), np.array([[2, 3], [2, 4]]), np.tile(np.diag([0.3, spread]), (2, 1, 1)), base=1
    )
    return white, columns


def test_distance_is_that_of_two_normals_that_may_both_move_their_numbers():
    white, columns = toy(np.random.default_rng(0))
    apart = distances(white.T @ white, columns, Pairs.of(columns))
    d, z = white[:, 0] - white[:, 1], white[:, [2, 3, 4]]
    covariance = np.eye(20) + z @ np.diag([0.3, 0.25, 0.25]) @ z.T
    assert apart[0, 1] == pytest.approx(d @ np.linalg.solve(covariance, d))


def test_information_is_nothing_for_equals_and_all_the_doubt_for_opposites():
    p = np.array([0.7, 0.3])
    assert information(np.zeros((2, 2)), p, 3.0) == pytest.approx(0.0)
    far = 1e4 * (1.0 - np.eye(2))
    assert information(far, p, 3.0) == pytest.approx(-np.sum(p * np.log(p)))


def test_sampled_posterior_is_the_one_that_direct_simulation_gives():
    rng = np.random.default_rng(1)
    white, columns = toy(rng)
    white[:, 0] *= 0.4
    said, _ = expected_posteriors(
        white.T @ white, columns, lambda log_likelihood: log_likelihood, np.eye(columns.means.size), 4000, rng
    )
    covariances = [np.eye(20) + white[:, n] @ np.diag([0.3, 0.5]) @ white[:, n].T for n in ([2, 3], [2, 4])]
    y = rng.multivariate_normal(white[:, 0], covariances[0], size=4000)
    log_p = []
    for mean, covariance in zip((white[:, 0], white[:, 1]), covariances, strict=True):
        r = y - mean
        log_p.append(
            -0.5
            * (
                np.einsum("na,na->n", r, np.linalg.solve(covariance, r.T).T)
                + np.linalg.slogdet(covariance)[1]
            )
        )
    direct = 1.0 / (1.0 + np.exp(log_p[1] - log_p[0]))
    assert said[0, 0] == pytest.approx(direct.mean(), abs=0.02)


def test_drive_is_expected_to_settle_rivals_that_driving_can_tell_apart():
    plan = planned(RIVALS)
    assert plan.forecast.sureness > 0.9 > 0.5 >= plan.forecast.sureness_before
    assert all(outlook.if_right > 0.8 for outlook in plan.outlooks)


def test_two_delays_without_encoders_are_not_worth_a_drive():
    both = belief(hypothesis(0.5, command_delay__delay=0.08), hypothesis(0.5, observation_delay__delay=0.08))
    assert planned(both) is NoDrive.NOTHING_TOLD


def test_one_explanation_needs_no_drive():
    assert planned(belief(hypothesis(1.0))) is NoDrive.NOTHING_TOLD


def test_every_explanation_stays_in_the_area_and_off_the_obstacle():
    area = Area(-0.6, 0.6, -0.5, 0.5, margin=0.15, obstacles=(Disc(0.3, 0.3, 0.1),))
    plan = planned(RIVALS, area, Pose2(-0.2, -0.1, 0.5))
    values = np.array([h.values for h in RIVALS.hypotheses])
    paths = Foresight(RIVALS).rolled(plan.holds, values, np.array([-0.2, -0.1, 0.5]))
    assert area.holds(paths[:, :, 0], paths[:, :, 1])


def test_area_too_small_for_any_manoeuvre_gives_only_turns_on_the_spot():
    plan = planned(RIVALS, Area(-0.25, 0.25, -0.25, 0.25, margin=0.2))
    assert isinstance(plan, NoDrive) or max(plan.room) < 0.1


SLOPPY = belief(
    hypothesis(0.5, motor_deadband__offset=0.04),
    replace(hypothesis(0.5), covariance=np.diag((4.0 * BASE_SPREAD) ** 2)),
)
"""What a robot of which little is known may do: its gains are uncertain by a fifth."""


def test_manoeuvre_that_might_leave_the_area_gives_way_to_another_one():
    for seed in range(4):
        plan = planned(SLOPPY, Area(-0.5, 0.5, -0.5, 0.5, margin=0.2), seed=seed, careful=12)
        assert plan.seconds > 2.0


def test_area_without_a_drive_says_that_there_is_no_room():
    assert planned(RIVALS, Area(-0.2, 0.2, -0.2, 0.2, margin=0.25)) is NoDrive.NO_ROOM


def test_random_drive_keeps_within_the_bounds_of_every_draw():
    area = Area(-0.5, 0.5, -0.5, 0.5, margin=0.2)
    plans = [random_drive(SLOPPY, area, Pose2(), np.random.default_rng(seed)) for seed in range(4)]
    assert all(plan.seconds > 2.0 for plan in plans)


def test_drive_keeps_to_its_longest_time_and_largest_command():
    plan = planned(RIVALS, longest=10.0, limit=0.3)
    assert plan.seconds <= 10.0
    assert max(max(abs(left), abs(right)) for _, left, right in plan.holds) <= 0.3


def test_same_belief_and_seed_give_the_same_drive():
    assert planned(RIVALS, seed=3).holds == planned(RIVALS, seed=3).holds


def test_designed_drive_promises_more_per_second_than_random_ones():
    plan = planned(RIVALS)
    rng = np.random.default_rng(0)
    others = [random_drive(RIVALS, AREA, Pose2(), rng, seconds=plan.seconds) for _ in range(6)]
    rates = [o.forecast.information / o.seconds for o in others]
    assert plan.forecast.information / plan.seconds > np.median(rates)


def test_drive_ends_at_rest():
    assert planned(RIVALS).holds[-1][1:] == (0.0, 0.0)


def test_place_that_is_believed_in_is_crossed():
    patch = {"x": 0.35, "y": 0.35, "half_x": 0.2, "half_y": 0.2, "drag": 0.8}
    there = hypothesis(0.5, **{f"rough_floor_patch__{name}": value for name, value in patch.items()})
    plan = planned(belief(there, hypothesis(0.5)))
    assert np.min(np.hypot(plan.path[:, 0] - 0.35, plan.path[:, 1] - 0.35)) < 0.2


def test_the_first_drive_is_designed_for_every_effect_that_acts_everywhere():
    held = {name for h in prior_belief().hypotheses for name in h.names}
    assert {"tyre_scrub", "wheel_eccentricity", "sensor_yaw", "motor_deadband"} <= held


def test_prior_holds_nothing_missing_and_the_catalogue():
    prior = prior_belief()
    assert prior.leader.names == ()
    assert len(prior.hypotheses) > 10
    assert prior.probabilities.sum() == pytest.approx(1.0)


def test_unlikely_explanations_are_left_out():
    assert len(kept([hypothesis(1.0), hypothesis(1e-9)], 5)) == 1


@pytest.fixture(scope="module")
def matching():
    """What is decided of a robot of which nothing is missing, after a short drive."""
    return diagnose([recording(0, 12.0)]).decision


@pytest.fixture(scope="module")
def clean(matching):
    return belief_of(matching)


def test_match_still_believes_in_effects_that_would_have_stayed_unseen(clean):
    assert clean.leader.names == ()
    assert 0.0 < clean.sureness < 0.95
    assert len(clean.hypotheses) > 3


def test_what_a_robot_was_not_asked_for_is_not_believed_to_hide(matching, clean):
    hiding = {name for h in clean.hypotheses for name in h.names}
    gone = sorted(hiding)[0]
    asked = tuple(e for e in matching.asked if e.name != gone)
    left = {name for h in belief_of(replace(matching, asked=asked)).hypotheses for name in h.names}
    assert gone not in left
    assert hiding - {gone} <= left


def test_a_moment_that_is_not_said_is_no_part_of_what_is_believed():
    decision = diagnose([recording(k, 12.0, motor_deadband__offset=0.05) for k in range(2)]).decision
    known = decision.model.supports[0]
    event = replace(known.effect, hypothesis=replace(known.effect.hypothesis, effect="external_push", run=0))
    unsaid = replace(known, effect=event)
    larger = replace(decision, model=replace(decision.model, supports=(known, unsaid)))
    assert belief_of(larger).leader.names == ("motor_deadband",)
    said = replace(larger, named=(*decision.named, replace(decision.named[0], effect=event)))
    assert set(belief_of(said).leader.names) == {"motor_deadband", "external_push"}


def test_what_the_verdict_says_as_a_set_is_open_to_the_designer_too():
    decision = diagnose([recording(0, 12.0, motor_deadband__offset=0.05)]).decision
    known = decision.model.supports[0]
    curve = next(r for r in decision.ranking if r.name == "motor_gain_curve")
    gap = Gap(60.0, 90.0, 200)  # by its evidence alone its odds were exp(-10)
    rival = replace(known, rivals=(RivalGap("motor_gain_curve", gap, curve.fit),))
    found = belief_of(replace(decision, model=replace(decision.model, supports=(rival,))))
    believed = {h.names: h.probability for h in found.hypotheses}
    beaten = gap.probability_within(EXACT * known.added.evidence)
    ratio = believed[("motor_gain_curve",)] / believed[("motor_deadband",)]
    assert ratio == pytest.approx((1.0 - beaten) / beaten, rel=1e-6)


@pytest.fixture(scope="module")
def dead_zone():
    """What is believed of a robot with a dead zone after a short drive."""
    return belief_of(diagnose([recording(0, 12.0, motor_deadband__offset=0.05)]).decision)


def test_named_effect_leads_the_belief_alone_or_with_what_may_hide_beside_it(dead_zone):
    assert dead_zone.leader.names == ("motor_deadband",)
    has_it = [h.probability for h in dead_zone.hypotheses if "motor_deadband" in h.names]
    assert sum(has_it) * (1.0 - dead_zone.unnamed) > 0.9


def test_an_answer_that_did_not_lead_at_first_is_believed_in_all_the_same():
    decision = diagnose([recording(0, 12.0, motor_deadband__offset=0.05)]).decision
    found = belief_of(
        replace(decision, ranking=tuple(r for r in decision.ranking if r.name != "motor_deadband"))
    )
    assert found.leader.names == ("motor_deadband",)


def test_what_may_hide_beside_an_answer_is_counted_over_it(dead_zone):
    beside = [h for h in dead_zone.hypotheses if len(h.names) == 2]
    assert beside
    assert all(h.over == ("motor_deadband",) and h.names[0] == "motor_deadband" for h in beside)
    assert len({h.names[1] for h in beside}) == len(beside)


def test_robot_that_looks_for_itself_keeps_markers_in_sight():
    x, y = (a.ravel() for a in np.meshgrid(np.arange(-0.6, 0.61, 0.15), np.arange(-0.6, 0.61, 0.15)))
    view = np.zeros((40, 60), dtype=bool)
    view[5:25, 15:45] = True  # 0.1 to 0.5 m ahead, 0.3 m to both sides
    sight = Sight(np.column_stack([x, y]), view, (0.0, -0.6), 0.02, (-0.8, 0.8, -0.8, 0.8))
    away = np.array([[[0.55, 0.0, 0.0]] * 20])
    assert not sight.keeps(away)
    assert sight.keeps(away + np.array([0.0, 0.0, np.pi]))
    area = Area(-0.8, 0.8, -0.8, 0.8, sight=sight)
    plan = planned(RIVALS, area)
    assert sight.keeps(plan.path[None])
    assert sight.enough(plan.path[None]).mean() > 0.9
