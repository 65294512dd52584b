"""Fleets: the same rows whoever does the work, and what a death or a kill may cost."""

import json
import os
import signal
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest
import study_tiny
from processes import is_alive
from ros_rig import until
from study_tiny import KILLER, marks, results, study

from fsm_calib.errors import InputError
from fsm_calib.study.backends import Crew, check_backend
from fsm_calib.study.fleet import run_fleet
from fsm_calib.study.models import Study
from fsm_calib.study.store import Store

HERE = Path(__file__).parent


def real_study():
    """Two robots with a known camera that turn to the markers: real pixels, machines and physics."""
    scenario = {"plan": ["orientation"], "robot": {"known": {"camera": True}}}
    return Study.model_validate(
        {"name": "turn", "seed": 3, "robots": 2, "parts": ["test_2"], "scenario": scenario}
    )


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """Rows of real robots run one after the other in this process."""
    directory = tmp_path_factory.mktemp("alone")
    run_fleet(real_study(), directory, Crew(jobs=1))
    return results(directory)


@pytest.mark.parametrize("backend", ["loky", "threading"])
def test_real_robots_give_the_same_rows_bit_for_bit(backend, alone, tmp_path):
    run_fleet(real_study(), tmp_path, Crew(backend, 2))
    assert results(tmp_path) == alone
    assert all('"outcome": "done"' in row for row in alone)


def test_two_dask_worker_processes_give_the_same_rows_bit_for_bit(tmp_path):
    distributed = pytest.importorskip("distributed")
    settings = {"n_workers": 2, "threads_per_worker": 1, "processes": True, "dashboard_address": None}
    with distributed.LocalCluster(**settings) as cluster:
        crew = Crew("dask", address=cluster.scheduler_address)
        store = run_fleet(study(), tmp_path / "dask", crew, trial=study_tiny.plain)
    run_fleet(study(), tmp_path / "alone", Crew(jobs=1), trial=study_tiny.plain)
    assert results(tmp_path / "dask") == results(tmp_path / "alone")
    assert os.getpid() not in {row["worker"]["process"] for row in store.rows.values()}


def test_every_robot_has_one_row_and_leaves_no_working_directory(tmp_path):
    store = run_fleet(study(), tmp_path, Crew(jobs=2), trial=study_tiny.plain)
    assert sorted(robot for _, robot in store.rows) == list(range(6))
    assert list((tmp_path / "work").iterdir()) == []


def test_more_robots_are_added_to_those_that_are_there(tmp_path):
    run_fleet(study(3), tmp_path, Crew(jobs=1), trial=study_tiny.plain)
    run_fleet(study(5), tmp_path, Crew(jobs=1), trial=study_tiny.plain)
    assert Counter(marks(tmp_path)) == Counter(f"{i} {s}" for i in range(5) for s in ("first", "second"))


def test_a_robot_with_an_error_costs_itself_alone(tmp_path):
    store = run_fleet(study(), tmp_path, Crew(jobs=2), trial=study_tiny.failing)
    errors = {robot: row["error"] for (_, robot), row in store.rows.items() if "error" in row}
    assert list(errors) == [KILLER]
    assert errors[KILLER]["reason"] == "this robot has no wheels"
    assert len(store.rows) == 6


def assert_only_what_was_under_way_is_repeated(found, deaths):
    """A death takes the other worker along, and with it one stage at most that had begun and not ended."""
    counts = Counter(found)
    assert counts[f"{KILLER} first"] == 1
    assert sum(count - 1 for count in counts.values()) <= deaths


def test_a_worker_that_dies_loses_nothing_and_repeats_nothing(tmp_path):
    store = run_fleet(study(), tmp_path, Crew(jobs=2), trial=study_tiny.dying_once)
    assert len(store.rows) == 6
    assert not any("error" in row for row in store.rows.values())
    assert_only_what_was_under_way_is_repeated(marks(tmp_path), deaths=1)


def test_a_robot_that_always_kills_its_worker_costs_itself_alone(tmp_path):
    store = run_fleet(study(), tmp_path, Crew(jobs=2), trial=study_tiny.dying)
    errors = {robot: row["error"]["name"] for (_, robot), row in store.rows.items() if "error" in row}
    assert errors == {KILLER: "WorkerDied"}
    assert len(store.rows) == 6
    reason = next(row["error"]["reason"] for row in store.rows.values() if "error" in row)
    deaths = int(reason.split("died ")[1].split()[0])
    assert_only_what_was_under_way_is_repeated(marks(tmp_path), deaths)


COMMAND = """
import sys
from pathlib import Path
import study_tiny
from fsm_calib.study.backends import Crew
from fsm_calib.study.fleet import run_fleet
if __name__ == "__main__":
    run_fleet(study_tiny.study(), Path(sys.argv[1]), Crew("loky", 2), trial=study_tiny.held)
"""


@pytest.mark.slow
def test_a_killed_command_goes_on_and_nothing_is_lost_or_run_twice(tmp_path):
    out = tmp_path / "out"
    command = [sys.executable, "-c", COMMAND, str(out)]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(HERE), *filter(None, sys.path)])}
    process = subprocess.Popen(command, env=environment)
    until(lambda: len(rows_in(out)) == 2 and len(study_tiny.holding(out)) == 2, "both workers wait")
    process.send_signal(signal.SIGKILL)
    process.wait()
    until(lambda: not any(map(is_alive, study_tiny.holding(out))), "the workers end with their command")
    before = rows_in(out)
    assert len(before) == 2
    study_tiny.let_go(out)
    subprocess.run(command, env=environment, check=True)
    after = rows_in(out)
    assert after[: len(before)] == before
    assert sorted(row["robot"] for row in after) == list(range(6))
    assert Counter(marks(out)) == Counter(f"{i} {s}" for i in range(6) for s in ("first", "second"))
    run_fleet(study(), tmp_path / "whole", Crew(jobs=1), trial=study_tiny.plain)
    assert results(out) == results(tmp_path / "whole")


def rows_in(directory):
    path = directory / "results.jsonl"
    whole = path.read_text().split("\n")[:-1] if path.exists() else []
    return [json.loads(line) for line in whole]


def test_a_torn_last_line_is_cut_off_and_its_robot_run_again(tmp_path):
    run_fleet(study(), tmp_path, Crew(jobs=1), trial=study_tiny.plain)
    path, whole = tmp_path / "results.jsonl", results(tmp_path)
    path.write_bytes(path.read_bytes()[:-10])
    run_fleet(study(), tmp_path, Crew(jobs=1), trial=study_tiny.plain)
    assert results(tmp_path) == whole


def test_a_directory_of_another_study_is_refused(tmp_path):
    Store(tmp_path, study())
    with pytest.raises(InputError, match="another study"):
        Store(tmp_path, study().model_copy(update={"seed": 6}))


def test_a_second_command_in_the_same_directory_is_refused(tmp_path):
    def trial(tiny, variant, robot, directory):
        with pytest.raises(InputError, match="another command is at work"):
            run_fleet(tiny, tmp_path, Crew(jobs=1), trial=study_tiny.plain)
        return study_tiny.plain(tiny, variant, robot, directory)

    store = run_fleet(study(1), tmp_path, Crew(jobs=1), trial=trial)
    assert "error" not in store.rows["base", 0]


def test_an_address_without_a_cluster_is_refused():
    with pytest.raises(InputError, match="no address"):
        check_backend("loky", "tcp://localhost:8786", None)


def test_a_cluster_that_does_not_answer_is_named(tmp_path, monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("fsm_calib.study.backends.CONNECT_SECONDS", 1)
    with pytest.raises(InputError, match="no Dask cluster answers"):
        run_fleet(study(1), tmp_path, Crew("dask", address="tcp://127.0.0.1:1"), trial=study_tiny.plain)
