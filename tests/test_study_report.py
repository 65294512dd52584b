"""What a study says: figures of made-up robots with known answers, and the report's files."""

import json
import subprocess
import sys
import time

import numpy as np
import pytest
from typer.testing import CliRunner

from fsm_calib.cli import app
from fsm_calib.report.study_blocks import Plot
from fsm_calib.report.study_content import content_of, largest
from fsm_calib.report.study_files import replaced, write_page, write_study
from fsm_calib.study.columns import rounded, rows_of
from fsm_calib.study.fleet import CommandCost
from fsm_calib.study.models import Study
from fsm_calib.study.summary import conclusion, deviation_figures, summarise


def camera(error, paper):
    return {"paper_px": paper, "rms_px": 6.0 * paper, "true_px": error, "predicted_px": 1.1 * error}


def automatic(deviation, error, paper, outcome="done"):
    wheels = {"deviation_2m_m": deviation, "iterations": 8}
    seconds = {"simulated": 150.0}
    failure = None if outcome == "done" else {"name": "marker_missing"}
    return {
        "outcome": outcome,
        "wheels": wheels,
        "camera": camera(error, paper),
        "seconds": seconds,
        "failure": failure,
    }


def row(robot, variant="base", slope=0.0, scale=1.0):
    rng = np.random.default_rng([robot, 1])
    paper = float(rng.uniform(0.005, 0.01))
    noise = float(rng.normal(0.0, 0.004))
    by_hand = {
        "camera": camera(0.9, 0.02) | {"same_solver": camera(0.3, 0.008), "attempts": 32},
        "wheels": {"deviation_2m_m": 0.05 * (-1) ** robot},
        "seconds": {"camera": 120.0, "wheels": 100.0},
    }
    deviation = scale * (0.01 + slope * (paper - 0.0075) + noise)
    return {
        "variant": variant,
        "robot": robot,
        "by_hand": by_hand,
        "test_1": automatic(0.01 + noise, 0.1, paper),
        "test_2": automatic(deviation, 0.1, paper),
        "cost": {part: {"cpu": 10.0, "wall": 11.0} for part in ("by_hand", "test_1", "test_2")},
    }


def study(**more):
    return Study.model_validate({"name": "made_up", "seed": 1, "robots": 20, **more})


def summary(slope=0.0, extra=(), **more):
    return summarise(study(**more), [*(row(robot, slope=slope) for robot in range(20)), *extra])


def test_the_automatic_camera_is_compared_robot_by_robot():
    found = summary()
    assert found.camera_gain["by_hand"].value == pytest.approx(-0.8)
    assert found.camera_gain["by_hand"].high < 0.0
    assert found.cameras["automatic"].true_px.value == pytest.approx(0.1)


def test_a_relation_that_is_there_is_found_and_confirmed():
    found = summary(slope=8.0)
    assert found.relations[0].correlation.low > 0.0
    assert "holds here" in conclusion(found)[0]


def test_a_relation_that_is_not_there_is_not_confirmed():
    assert "is not confirmed" in conclusion(summary())[0]


def test_deviations_are_read_to_the_centimetre():
    assert rounded(np.array([0.104, -0.026, 0.0049])) == pytest.approx([0.10, -0.03, 0.0])


def test_a_robot_that_did_not_finish_counts_as_unfinished_and_not_as_a_deviation():
    failed = row(20) | {"test_2": automatic(0.5, 0.1, 0.007, "failed")}
    found = summary(extra=[failed])
    assert found.deviations["test_2"].finished.value == pytest.approx(20 / 21)
    assert found.deviations["test_2"].largest < 0.1
    assert found.failures == {"test 2: marker_missing": 1}


def test_a_robot_with_an_error_is_counted_and_named():
    found = summary(extra=[{"variant": "base", "robot": 20, "error": {"name": "ValueError", "reason": "x"}}])
    assert found.robots == 21
    assert found.failures == {"ValueError": 1}


def test_a_variant_is_compared_with_the_same_robots():
    extra = [row(robot, "published:equation_3", scale=10.0) for robot in range(5)]
    found = summary(extra=extra, corrections=["equation_3"]).variants
    assert [item.variant.name for item in found] == ["published:equation_3"]
    assert found[0].deviation.median_size.value == pytest.approx(
        10.0 * found[0].base_deviation.median_size.value
    )
    assert found[0].added.count == 5


def test_what_ended_a_robot_of_a_variant_is_told_beside_the_variant(tmp_path):
    failed = row(0, "published:equation_3") | {"test_2": automatic(0.5, 0.1, 0.007, "failed")}
    found = summary(extra=[failed], corrections=["equation_3"])
    assert found.failures == {}
    assert found.variants[0].failures == {"test 2: marker_missing": 1}
    page = tmp_path / "study.md"
    write_page(page, found, tmp_path, "fsm-calib study x.yaml")
    assert "| published:equation_3 | test 2: marker missing | 1 |" in page.read_text()


def test_the_same_rows_in_any_order_give_the_same_summary():
    rows = [row(robot) for robot in range(20)]
    first, second = summarise(study(), rows), summarise(study(), rows[::-1])
    assert first.deviations == second.deviations
    assert rows_of(rows[::-1]).robots() == list(range(20))


def test_the_report_holds_figures_4a_to_4c_and_every_setting(tmp_path):
    sweeps = [{"name": "noise", "setting": "world.drive_noise", "values": [0.02, 0.03]}]
    extra = [row(robot, f"noise={value}", scale=2.0) for value in (0.02, 0.03) for robot in range(4)]
    extra += [row(robot, "published:equation_3", scale=9.0) for robot in range(4)]
    found = summary(extra=extra, sweeps=sweeps, corrections=["equation_3"])
    content = write_study(tmp_path, found)
    page = (tmp_path / "report.html").read_text()
    names = [block.name for part in content.parts for block in part.blocks if isinstance(block, Plot)]
    assert {"figure_4a", "figure_4b", "figure_4c", "relation", "corrections", "sweeps"} <= set(names)
    assert page.count("<svg") == len(names)
    assert "tremor_speed" in page
    assert "src=" not in page
    numbers = json.loads((tmp_path / "study.json").read_text())
    assert numbers["deviations"]["test_2"]["passing"]["value"] == 1.0


def test_a_pages_section_is_renewed_and_the_rest_is_left_alone(tmp_path):
    page = tmp_path / "study.md"
    page.write_text("# Studies\n\nWords.\n")
    write_page(page, summary(), tmp_path, "fsm-calib study x.yaml")
    once = page.read_text()
    page.write_text(once + "\nMore words.\n")
    write_page(page, summary(), tmp_path, "fsm-calib study x.yaml")
    assert once.startswith("# Studies\n\nWords.\n")
    assert page.read_text() == once + "\nMore words.\n"
    assert (tmp_path / "study" / "made_up_figure_4a.png").exists()


def test_sections_of_two_studies_do_not_touch_each_other():
    page = replaced(replaced("", "a", "first"), "b", "second")
    assert replaced(page, "a", "third") == page.replace("first", "third")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--backend", "cloud"], "there is no back end 'cloud'"),
        (["--robots", "0"], "--robots is 0"),
        (["--jobs", "0"], "--jobs is 0"),
        (["--address", "tcp://x:1"], "no address"),
    ],
)
def test_wrong_use_is_refused_before_anything_is_written(arguments, said, tmp_path):
    file = tmp_path / "s.yaml"
    file.write_text("name: s\n")
    out = tmp_path / "out"
    result = CliRunner().invoke(app, ["study", str(file), "--out", str(out), *arguments])
    assert result.exit_code == 2
    assert said in result.output
    assert not out.exists()


def test_a_fleet_of_one_that_only_turns_runs_from_the_command_line(tmp_path):
    file = tmp_path / "s.yaml"
    plan = "scenario: {plan: [orientation], robot: {known: {camera: true}}}"
    file.write_text(f"name: s\nrobots: 1\nparts: [test_2]\n{plan}\n")
    result = CliRunner().invoke(app, ["study", str(file), "--out", str(tmp_path / "out"), "--jobs", "1"])
    assert result.exit_code == 0, result.output
    assert (tmp_path / "out" / "report.html").exists()


def test_a_command_that_is_asked_to_stop_says_how_to_go_on(tmp_path):
    file, out = tmp_path / "s.yaml", tmp_path / "out"
    file.write_text("name: s\nrobots: 3\nparts: [test_2]\n")
    command = [sys.executable, "-c", "from fsm_calib.cli import main; main()"]
    command += ["study", str(file), "--out", str(out), "--jobs", "1"]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    work = out / "work" / "base-robot000000" / "test_2" / "checkpoint.json"
    while not work.exists() and process.poll() is None:
        time.sleep(0.05)
    process.terminate()
    _, said = process.communicate()
    assert process.returncode == 1
    assert "stopped by SIGTERM. Give the same command to go on." in said
    assert not (out / "results.jsonl").exists()


@pytest.mark.parametrize(("workers", "said"), [(1, "50 h with 1 worker."), (2, "50 h with 2 workers.")])
def test_the_pace_of_a_fleet_is_that_of_its_longest_command(workers, said):
    costs = [CommandCost(20, 360.0, 360.0, workers), CommandCost(2, 7200.0, 7200.0, 4)]
    text = content_of(summarise(study(), [row(robot) for robot in range(20)]), costs).text()
    assert f"At this pace 10000 robots take {said}" in text


def test_where_no_robot_finished_there_is_no_largest_deviation():
    assert largest(deviation_figures(np.full(3, np.nan), np.random.default_rng(0))) == "-"
    assert largest(deviation_figures(np.array([0.011, -0.02]), np.random.default_rng(0))) == "2.0"
