"""The report of a diagnosis: one page that holds the answer, its figures and the improved world."""

from __future__ import annotations

import html
import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from browser import faults, needs_browser, page_after_scripts

from fsm_calib.diagnosis.diagnose import Diagnosis, diagnose
from fsm_calib.errors import InputError
from fsm_calib.recording.channels import CommandTrack, PoseTrack, StateTrack, WheelPair
from fsm_calib.recording.recording import Recording, RobotFacts
from fsm_calib.report import diagnosis_signature, digits
from fsm_calib.report.diagnosis_figures import state_colour, unjoined
from fsm_calib.report.diagnosis_paths import SEGMENT, drives, predicted_paths, state_spans, titles_of
from fsm_calib.report.diagnosis_report import diagnosis_page, write_report
from fsm_calib.report.diagnosis_world import world_text
from fsm_calib.scenario.load import load_scenario
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.observation import predict
from fsm_calib.world2d.parameters import parameters
from fsm_calib.world2d.rollout import Drive

CONSIDERED = {"motor_deadband", "floor_tilt", "tyre_scrub"}
HOSTILE = "<script>alert(1)</script>"
NOISE = np.array([0.002, 0.002, 0.006])


DEADBAND = {"motor_deadband.offset": 0.08}


def recording(seed: int, hidden: Mapping[str, float] = DEADBAND, seconds: float = 40.0) -> Recording:
    """A drive, with states, of a robot that hides something: its motors lose 0.08 of every command."""
    rng = np.random.default_rng(seed)
    times = np.arange(0.2, seconds, 0.5)
    left = rng.choice([-0.3, -0.15, 0.0, 0.15, 0.3, 0.5], size=len(times))
    right = np.where(rng.uniform(size=len(times)) < 0.5, left, rng.permutation(left))
    truth = parameters({**hidden, "gain_left": 0.62, "gain_right": 0.6})
    stamps = np.arange(0.0, seconds, 0.08)
    poses = predict(truth, Drive(times, left, right), stamps, (0.0, 0.0, 0.0)).poses
    x, y, theta = (poses + rng.normal(size=poses.shape) * NOISE).T
    return Recording(
        robot=RobotFacts(HOSTILE, 0.0318, 0.1, 20.0),
        command=CommandTrack(times, left, right),
        pose=PoseTrack(stamps, x, y, theta),
        state=StateTrack(
            np.array([0.0, 15.0, 30.0]), ("wheels.shuttling", "exit.driving", f"lane.{HOSTILE}")
        ),
        source=f"run-{seed}.recording.yaml",
    )


@pytest.fixture(scope="module")
def diagnosis() -> Diagnosis:
    others = set(registry()) - CONSIDERED
    return diagnose([recording(1), recording(2)], [recording(3)], without=others)


@pytest.fixture(scope="module")
def page(diagnosis: Diagnosis) -> str:
    return diagnosis_page(diagnosis)


def answered(hidden: Mapping[str, float]) -> Diagnosis:
    """Return what the three effects considered say of a robot that hides something else, or nothing."""
    fitted = [recording(1, hidden), recording(2, hidden)]
    return diagnose(fitted, [recording(3, hidden)], without=set(registry()) - CONSIDERED)


@pytest.fixture(scope="module")
def other_pages() -> dict[str, str]:
    """Pages of the two answers that name nothing."""
    found = {"match": answered({}), "unexplained": answered({"wheel_eccentricity.left": 0.12})}
    assert {name: answer.verdict.verdict for name, answer in found.items()} == {name: name for name in found}
    return {name: diagnosis_page(answer) for name, answer in found.items()}


@needs_browser
def test_the_pages_of_every_answer_are_sound_in_a_browser(
    page: str, other_pages: dict[str, str], tmp_path: Path
) -> None:
    assert faults({"explained": page, **other_pages}, tmp_path) == []


def test_a_page_that_names_nothing_draws_one_side_and_says_what_that_means(
    other_pages: dict[str, str],
) -> None:
    for text in other_pages.values():
        assert 'aria-label="Paths base robot, run-1"' in text
        assert "with the effects</th>" not in text
    assert "Nothing is missing that these drives would have shown." in other_pages["match"]
    assert "Something is missing that the catalogue has no name for" in other_pages["unexplained"]


@needs_browser
def test_a_moment_is_shown_on_the_map_too(page: str, tmp_path: Path) -> None:
    move = "clientX: r.left + 0.5 * r.width, clientY: r.top + 0.7 * r.height, bubbles: true"
    point = f"""<script>const s = document.querySelector("svg[data-axes]"), r = s.getBoundingClientRect();
      s.dispatchEvent(new PointerEvent("pointermove", {{{move}}}));</script>"""
    (tmp_path / "page.html").write_text(page + point, encoding="utf-8")
    shown = page_after_scripts((tmp_path / "page.html").as_uri(), tmp_path)
    assert re.search(r'class="cursor"[^>]*>\d+\.\d s, x = ', shown)
    assert len(re.findall(r'<circle[^>]*class="cursor-mark"[^>]*cx="', shown)) == 4


def test_the_page_begins_with_the_answer(page: str) -> None:
    answer = page[page.index("<h2>The answer") : page.index("<h2>Error of a prediction")]
    assert "motor deadband" in answer
    assert re.search(r"\d+ % sure", answer)


def test_the_page_shows_before_after_and_floor_for_both_kinds_of_recordings(page: str) -> None:
    rows = re.findall(r"<tr><td>(fitted|not fitted)</td><td>(median|95 %)</td>(.*?)</tr>", page)
    assert [row[:2] for row in rows] == [
        (name, which) for name in ("not fitted", "fitted") for which in ("median", "95 %")
    ]
    for _, which, cells in rows:  # noise alone is told of the median
        assert cells.count("mm") == cells.count("deg") == (3 if which == "median" else 2)


def test_the_page_draws_every_recording_the_unseen_first(page: str) -> None:
    titles = re.findall(r"<h2>(run-\d), (not fitted|fitted)</h2>", page)
    assert titles == [("run-3", "not fitted"), ("run-1", "fitted"), ("run-2", "fitted")]
    for run in ("run-1", "run-2", "run-3"):
        maps = (
            f"{figure} {side}" for figure in ("Error on the floor", "Paths") for side in ("before", "after")
        )
        for figure in ("Error over time", *maps):
            assert f'aria-label="{figure}, {run}"' in page


def test_the_ribbon_names_the_machines_states(page: str) -> None:
    assert "wheels.shuttling" in page
    assert "exit.driving" in page


def test_a_name_from_a_recording_is_shown_and_never_run(page: str) -> None:
    assert "alert(1)" in page
    assert HOSTILE not in page


def test_the_page_gives_the_effects_parameter_with_its_interval(page: str, diagnosis: Diagnosis) -> None:
    estimate = diagnosis.verdict.effects[0].parameters["offset"]
    row = re.search(r"<td>motor_deadband</td><td>offset</td>(.*?)</tr>", page)
    assert row is not None
    low, high = (float(x) for x in re.findall(r"(-?[\d.]+) to (-?[\d.]+)", row[1])[0])
    assert low < estimate.value < high
    assert high - low == pytest.approx(2 * 1.645 * estimate.sd, rel=0.01)


def test_the_page_needs_no_other_file(page: str) -> None:
    assert not re.search(r'(src|href)="(?!#|data:|world\.yaml")', page)


def test_the_page_shows_the_equation_with_the_fitted_numbers(page: str, diagnosis: Diagnosis) -> None:
    estimate = diagnosis.verdict.effects[0].parameters["offset"]
    physics = page[page.index("<h2>The physics") : page.index("<h2>What gave it away")]
    assert registry()["motor_deadband"].equation.split("=")[0].strip() in html.unescape(physics)
    assert f"offset = {digits.estimate(estimate.value, estimate.sd)}" in physics


def test_the_page_draws_the_error_against_what_gave_it_away(page: str) -> None:
    figure = re.search(r'aria-label="Speed error against ([^:]*): motor deadband', page)
    assert figure is not None


def test_the_error_leaves_zero_without_the_effect_and_stays_there_with_it(diagnosis: Diagnosis) -> None:
    prepared, around, before, after, _ = diagnosis_signature._one_recording(diagnosis)
    quantity = 0.5 * (around.left + around.right)
    parts = [diagnosis_signature.binned(prepared, around, steps, quantity, 0) for steps in (before, after)]
    sizes = [float(np.sqrt(np.mean(part.mean**2))) for part in parts]
    assert sizes[1] < 0.6 * sizes[0]


def test_every_section_is_in_the_contents(page: str) -> None:
    contents = re.findall(r'<a href="#([^"]+)">', page)
    assert contents == re.findall(r'<section id="([^"]+)"', page)


def test_each_part_of_the_time_is_on_the_page(page: str, diagnosis: Diagnosis) -> None:
    assert all(f"<th>{part}</th>" in page for part in diagnosis.verdict.seconds)


def test_an_unwritable_folder_is_an_input_error(diagnosis: Diagnosis, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot write the report"):
        write_report(diagnosis, tmp_path / "missing")


def test_the_improved_world_is_a_scenario_with_the_effect(diagnosis: Diagnosis, tmp_path: Path) -> None:
    path = tmp_path / "world.yaml"
    path.write_text(world_text(diagnosis), encoding="utf-8")
    scenario = load_scenario(path)
    assert scenario.robot.effects.motor_deadband.offset == pytest.approx(0.08, abs=0.01)
    assert scenario.robot.wheel_ratio == pytest.approx(0.62 / 0.6, abs=0.01)


def test_a_match_leaves_a_world_without_effects(diagnosis: Diagnosis) -> None:
    bare = replace(diagnosis.decision.model, effects=(), fit=diagnosis.decision.base)
    matched = replace(diagnosis, decision=replace(diagnosis.decision, outcome="match", model=bare))
    assert yaml.safe_load(world_text(matched))["robot"]["effects"] == {}


def test_measured_wheel_speeds_leave_the_motors_nominal(diagnosis: Diagnosis) -> None:
    engine = diagnosis.decision.engine
    measured = tuple(replace(s, measured_input=True) for s in engine.simulators)
    changed = replace(diagnosis.decision, engine=replace(engine, simulators=measured))
    text = world_text(replace(diagnosis, decision=changed))
    assert yaml.safe_load(text)["robot"]["speed"] == 1.0
    assert "wheel speeds were measured" in text


def test_chaining_the_measured_steps_gives_the_measured_path(diagnosis: Diagnosis) -> None:
    prepared = diagnosis.decision.engine.simulators[0].prepared
    for path in predicted_paths(prepared, prepared.step):
        k = int(np.argmin(np.hypot(*(prepared.reference[:, :2] - path[0]).T)))
        np.testing.assert_allclose(path, prepared.reference[k : k + len(path), :2], atol=1e-9)


def test_predicted_paths_start_afresh_every_segment(diagnosis: Diagnosis) -> None:
    simulator = diagnosis.decision.engine.simulators[0]
    paths = predicted_paths(simulator.prepared, simulator.prepared.step)
    length = float(simulator.prepared.time[-1] - simulator.prepared.time[0])
    assert length / SEGMENT - 1 <= len(paths) <= length / SEGMENT + 1


def test_predictions_come_nearer_with_the_effect(diagnosis: Diagnosis) -> None:
    drive = next(d for d in drives(diagnosis) if d.judged)
    before, after = (np.median(np.hypot(*w.error[:, :2].T)) for w in (drive.before, drive.after))
    assert after < 0.7 * before


def test_state_spans_cover_the_recording(diagnosis: Diagnosis) -> None:
    prepared = diagnosis.decision.engine.simulators[0].prepared
    spans = state_spans(prepared)
    assert spans[0][:2] == (0.0, 15.0)
    assert spans[-1][1] == pytest.approx(prepared.time[-1])


def test_a_line_is_interrupted_where_nothing_was_measured() -> None:
    time, value = unjoined(np.array([0.0, 0.5, 4.0, 4.5]), np.arange(4.0))
    assert np.isnan(time[2])
    assert np.isnan(value[2])
    assert len(time) == 5


def test_phases_keep_their_colour_and_other_states_get_different_ones() -> None:
    names = ["wheels", "a", "b"]
    assert len({state_colour(name, names) for name in names}) == 3


def test_wheel_speeds_alone_are_refused_with_a_cure() -> None:
    from fsm_calib.errors import DataError

    time = np.arange(0.0, 10.0, 0.1)
    alone = Recording(wheel_rate=WheelPair(time, np.ones(100), np.ones(100), "rad/s"))
    with pytest.raises(DataError, match="no poses"):
        diagnose([alone])


def test_recordings_are_called_by_file_or_folder_and_by_both_where_two_share_a_name():
    assert titles_of(["lab/run-a/recording.yaml", "lab/x.recording.yaml", "lab/drive.bag"]) == [
        "run-a",
        "x",
        "drive.bag",
    ]
    assert titles_of(["run-a/manifest.yaml", "run-b/manifest.yaml"]) == [
        "run-a/manifest.yaml",
        "run-b/manifest.yaml",
    ]
    assert titles_of(["folder/bag/", "simulated"]) == ["bag", "simulated"]
