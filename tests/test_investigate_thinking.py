"""What an investigation thinks between two drives."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis_robots import recording

from fsm_calib.actions.investigate_settings import InvestigateSettings
from fsm_calib.actions.investigating import Findings
from fsm_calib.diagnosis.design.area import Area
from fsm_calib.diagnosis.design.belief import Belief, Hypothesis
from fsm_calib.diagnosis.likelihood.noise import Noise
from fsm_calib.recording.channels import PoseTrack
from fsm_calib.recording.recording import RobotFacts
from fsm_calib.runner.investigation import thinking
from fsm_calib.runner.investigation.own_camera import MOST_LATE, SEEN, camera_found
from fsm_calib.runner.investigation.thinking import Mind
from fsm_calib.types import FloatArray
from fsm_calib.world2d.parameters import null_parameters, parameter_table
from fsm_calib.world2d.scene import SceneSpec


def sure_of(*names):
    only = Hypothesis(names, 1.0, np.zeros(1), (), np.zeros((0, 0)), np.zeros(0))
    return Belief((only,), 0, np.zeros(1), Noise())


def judged(monkeypatch, *beliefs, sure=None):
    """Return whether the answer is sure after judgements of these beliefs, each of them sure by itself unless told."""
    mind, told, by_itself = Mind(Area(), RobotFacts(), 0), iter(beliefs), iter(sure or [True] * len(beliefs))
    monkeypatch.setattr(mind, "_believed", lambda bench: next(told))
    monkeypatch.setattr(mind, "_is_sure", lambda belief, wanted: next(by_itself))
    bench = SimpleNamespace(asked=InvestigateSettings(), findings=Findings())
    return [mind.judge_answer(bench).evidence["sure"] for _ in beliefs][-1]


def test_same_names_in_another_order_confirm_an_answer(monkeypatch):
    one, other = sure_of("caster_drag", "motor_deadband"), sure_of("motor_deadband", "caster_drag")
    assert judged(monkeypatch, one, other)


def test_a_drive_between_that_was_not_sure_of_the_same_names_does_not_begin_it_again(monkeypatch):
    same = [sure_of("motor_deadband")] * 3
    assert judged(monkeypatch, *same, sure=[True, False, True])
    assert not judged(monkeypatch, *same, sure=[True, True, False])


def test_other_names_begin_the_confirmation_again(monkeypatch):
    assert not judged(monkeypatch, sure_of("caster_drag"), sure_of("motor_deadband"))


def answered(*names, among=(), **shares):
    """Return a mind whose diagnosis says `names` with 0.95 and whose model has effects with these shares."""
    effects = [SimpleNamespace(name=name, confidence=0.95) for name in names]
    supports = [SimpleNamespace(name=name, share=share) for name, share in shares.items()]
    verdict = SimpleNamespace(verdict="explained", effects=effects, ambiguous=among)
    mind = Mind(Area(), RobotFacts(), 0)
    mind.diagnosis = SimpleNamespace(
        verdict=verdict, decision=SimpleNamespace(model=SimpleNamespace(supports=supports))
    )
    return mind


BOTH = sure_of("motor_deadband", "floor_tilt")


def test_what_is_small_beside_a_sure_name_does_not_keep_an_answer_open():
    assert answered("motor_deadband", motor_deadband=0.97, floor_tilt=0.03)._is_sure(BOTH, 0.9)


def test_what_is_large_and_has_no_sure_name_keeps_it_open():
    assert not answered("motor_deadband", motor_deadband=0.8, floor_tilt=0.2)._is_sure(BOTH, 0.9)


def test_what_may_hide_beside_the_names_and_leads_keeps_it_open():
    assert not answered("motor_deadband", motor_deadband=1.0)._is_sure(BOTH, 0.9)


def test_what_happened_once_does_not_keep_it_open():
    pushed = sure_of("motor_deadband", "external_push")
    assert answered("motor_deadband", motor_deadband=0.8, external_push=0.2)._is_sure(pushed, 0.9)


def test_names_that_are_not_the_likeliest_explanation_keep_it_open():
    assert not answered("caster_drag", caster_drag=1.0)._is_sure(BOTH, 0.9)


def test_a_set_that_cannot_be_told_apart_keeps_it_open():
    among = (("motor_deadband", "caster_drag"),)
    assert not answered("motor_deadband", among=among, motor_deadband=1.0)._is_sure(
        sure_of("motor_deadband"), 0.9
    )


def test_an_explanation_without_a_name_that_is_said_keeps_it_open():
    assert not answered(motor_deadband=1.0)._is_sure(sure_of("motor_deadband"), 0.9)


@pytest.mark.parametrize(
    ("linked", "missing"),
    [(False, {"clock_drift", "observation_delay", "misplaced_marker"}), (True, {"misplaced_marker"})],
)
def test_a_robot_that_places_itself_by_its_camera_is_not_asked_for_what_a_tracker_may_have(linked, missing):
    assert Mind(Area(), RobotFacts(), 0, scene=SceneSpec(), linked=linked)._not_asked == missing


def test_recordings_that_were_given_may_be_a_trackers():
    assert not Mind(Area(), RobotFacts(), 0, (recording(0, 12.0),), scene=SceneSpec())._not_asked


@pytest.mark.parametrize("given", [(), (recording(0, 12.0),)])
def test_only_where_all_poses_are_its_own_cameras_do_they_tell_their_map(monkeypatch, given):
    mind, heard = Mind(Area(), RobotFacts(), 0, given, scene=SceneSpec()), {}
    monkeypatch.setattr(
        thinking,
        "diagnose",
        lambda recordings, **asked: heard.update(asked) or SimpleNamespace(decision=None),
    )
    monkeypatch.setattr(thinking, "belief_of", lambda decision: sure_of("motor_deadband"))
    mind._diagnose([recording(1, 12.0)])
    assert heard["settings"].own_map == (not given)


def test_before_a_drive_nothing_is_believed_in_that_is_not_asked():
    believed = Mind(Area(), RobotFacts(), 0, scene=SceneSpec())._prior(10.0)
    assert not {"clock_drift", "observation_delay"} & {name for h in believed.hypotheses for name in h.names}
    assert believed.probabilities.sum() == pytest.approx(1.0)


def decided(values: FloatArray, effects: tuple = (), ranking: tuple = ()) -> SimpleNamespace:
    model = SimpleNamespace(effects=effects, fit=SimpleNamespace(values=values[None]))
    return SimpleNamespace(model=model, ranking=ranking)


@pytest.mark.parametrize(("linked", "late"), [(True, 0.5 * MOST_LATE), (False, 0.0)])
def test_frames_are_late_by_a_network_alone(linked, late):
    table, values = parameter_table(), null_parameters()
    values[table.place("observation_delay.delay")] = 0.5 * MOST_LATE
    assert camera_found(decided(values), linked) == (0.0, 0.0, 0.0, late)


@pytest.mark.parametrize(
    ("named", "gain", "ahead"),
    [((), SEEN + 1.0, 3e-4), ((), SEEN - 1.0, 0.0), (("caster_drag",), SEEN + 1.0, 0.0)],
)
def test_a_seat_too_small_to_be_found_is_learnt_where_nothing_is_named_and_drives_show_it(named, gain, ahead):
    seated = null_parameters()
    seated[parameter_table().place("sensor_offset.x")] = 3e-4
    ranked = SimpleNamespace(name="sensor_offset", gain=gain, fit=SimpleNamespace(values=seated[None]))
    assert camera_found(decided(null_parameters(), named, (ranked,)), False) == (ahead, 0.0, 0.0, 0.0)


def test_a_drive_that_was_cut_off_at_once_is_not_diagnosed(monkeypatch):
    mind, heard, long = Mind(Area(), RobotFacts(), 0), [], recording(0, 12.0)
    first = [series[:15] for series in (long.pose.time, long.pose.x, long.pose.y, long.pose.theta)]
    short = replace(long, pose=PoseTrack(*first))
    monkeypatch.setattr(mind, "recordings", lambda bench: (long, short))
    monkeypatch.setattr(
        thinking,
        "diagnose",
        lambda recordings, **asked: heard.extend(recordings) or SimpleNamespace(decision=None),
    )
    monkeypatch.setattr(thinking, "belief_of", lambda decision: sure_of("motor_deadband"))
    mind._believed(SimpleNamespace(findings=Findings(drives=[None, None])))
    assert len(heard) == 1
