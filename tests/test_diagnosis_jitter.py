"""Commands that come early or late at random: a noise of their own, found where it is and nowhere else."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_robots import HEADING_NOISE, POSITION_NOISE, engine_of, judged, recording, selector_on

from fsm_calib.diagnosis.candidates.jitter import with_jitter, without_jitter
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.likelihood.noise import Noise
from fsm_calib.diagnosis.likelihood.robust import Whitener
from fsm_calib.diagnosis.replay.prepared import prepare
from fsm_calib.diagnosis.verdict.punctual import likelier_if_punctual, ranked_if_punctual


def based(**changes):
    """Return the engine of two drives with `changes` and their base robot, with a jitter where it is found."""
    engine = engine_of(*(recording(seed, **changes) for seed in (0, 1)))
    return engine, with_jitter(engine, fit_base(engine))


@pytest.mark.parametrize("jitter", [0.005, 0.01, 0.025])
def test_the_size_of_a_jitter_is_found(jitter):
    _, fit = based(jitter=jitter)
    assert fit.noise.jitter == pytest.approx(jitter, rel=0.25)  # the spread of 70 draws: 9 % of the deviation


def test_drives_whose_commands_come_in_time_have_none():
    _, fit = based()
    assert fit.noise.jitter == 0.0


def test_a_jitter_is_no_noise_of_the_poses_and_moves_no_number():
    _, plain = based()
    _, late = based(jitter=0.025)
    assert late.noise.position == pytest.approx(plain.noise.position, rel=0.1)
    assert late.noise.turning < 0.02
    np.testing.assert_allclose(late.slot_values()[:5], plain.slot_values()[:5], rtol=0.04)


def test_innovations_after_a_change_of_command_are_as_wide_as_the_others():
    engine, fit = based(jitter=0.025)
    white = engine.residual(engine.whiteners(fit.noise), fit.simulated)
    since = np.concatenate([_since_command(s.prepared) for s in engine.simulators])
    after = (since > 0.0) & (since < 0.4)
    assert white[after].std() / white[~after].std() == pytest.approx(1.0, abs=0.12)


def _since_command(prepared):
    """Return the time since the last command [s] of every scored innovation, shape (N,)."""
    times = prepared.recording.command.time
    last = times[np.clip(np.searchsorted(times, prepared.time) - 1, 0, None)]
    return np.broadcast_to((prepared.time - last)[:, None], prepared.scored.shape)[prepared.scored]


def test_the_filter_whitens_what_a_lateness_does():
    """Lateness, drawn here step by step, moves the robot by it times the change of its speed."""
    prepared = prepare(recording(0, duration=12.0))
    noise = Noise(POSITION_NOISE, HEADING_NOISE, 1e-6, 1e-6, 1e-6, 0.08, colour=1e-6, jitter=0.03)
    whitener, rng, draws = Whitener.at(prepared, noise), np.random.default_rng(7), []
    for _ in range(300):
        late, value = np.empty(len(prepared.time)), noise.jitter * rng.normal()
        for k, share in enumerate(whitener.moves[:, 5]):
            value = share * value + np.sqrt(1.0 - share * share) * noise.jitter * rng.normal()
            late[k] = value
        moved = prepared.step.copy()
        before = np.concatenate([late[:1], late[:-1]])  # what the lateness was as the interval began
        moved[:, [0, 2]] -= prepared.surge * before[:, None]
        seen = rng.normal(size=prepared.y.shape) * [POSITION_NOISE, POSITION_NOISE, HEADING_NOISE, 0.0, 0.0]
        drawn = replace(whitener, prepared=replace(prepared, y=seen))
        draws.append(drawn.residual(moved))
    white = np.array(draws)
    assert np.mean(white**2) == pytest.approx(1.0, abs=0.02)
    assert np.mean(white[:, 3:] * white[:, :-3]) == pytest.approx(0.0, abs=0.02)
    surge = np.abs(prepared.surge[:, 0]) > 0.05
    rows = np.broadcast_to(surge[:, None], prepared.scored.shape)[prepared.scored]
    assert np.mean(white[:, rows] ** 2) == pytest.approx(1.0, abs=0.05)


@pytest.mark.slow
def test_a_clean_robot_with_late_commands_is_a_match_and_told():
    found = diagnose([recording(seed, 28.0, jitter=0.025) for seed in (2, 3)])
    assert found.verdict.verdict == "match"
    assert any("early or late by" in note for note in found.notes)


def test_a_side_slip_beside_a_jitter_keeps_its_name():
    decision = judged(
        ("lateral_slip", "external_push", "command_delay"), jitter=0.02, lateral_slip__compliance=0.015
    )
    assert [belief.name for belief in decision.named] == ["lateral_slip"]
    assert decision.model.fit.noise.jitter == pytest.approx(0.02, rel=0.25)


def test_punctual_commands_explain_late_ones_worse():
    engine, late = based(jitter=0.02)
    punctual = without_jitter(engine, late)
    assert punctual.noise.jitter == 0.0
    assert punctual.score < late.score - 50.0


def test_what_is_late_stays_late_where_no_effect_does_as_much():
    engine, base = based(jitter=0.02, lateral_slip__compliance=0.015)
    selector = selector_on(base, engine, "lateral_slip", "external_push")
    grown = selector.grown(selector.first_ranked()[1])
    assert likelier_if_punctual(selector, grown) == (selector, grown)


def test_a_base_robot_that_is_called_late_for_an_effect_is_punctual():
    """A dead zone that a noise of lateness has taken is found again where the commands are held punctual."""
    engine = engine_of(*(recording(s, motor_deadband__offset=0.05) for s in (0, 1)))
    punctual = fit_base(engine)
    late = replace(punctual, noise=replace(punctual.noise, jitter=0.02), log_likelihood=-1e9)
    selector = selector_on(late, engine, "motor_deadband")
    found, bank, ranking = ranked_if_punctual(selector, Bank.on(engine, punctual), [])
    assert found.base.noise.jitter == 0.0
    assert bank.parent is found.base
    assert [r.name for r in ranking] == ["motor_deadband"]
