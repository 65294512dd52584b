"""Benchmarks that run one scenario on many robots: what they keep, and when their workers end."""

import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from processes import is_alive, worker_of_killed
from recording_samples import ROOT
from ros_rig import until

sys.path.insert(0, str(ROOT / "benchmarks"))
import fleet_runs


def test_a_worker_ends_when_its_benchmark_is_killed() -> None:
    code = (
        "import os, sys, time\n"
        f"sys.path.insert(0, {str(ROOT / 'benchmarks')!r})\n"
        "import fleet_runs\n"
        "pool = fleet_runs.workers(1)\n"
        "print(pool.submit(os.getpid).result(), flush=True)\n"
        "pool.submit(time.sleep, 600).result()\n"
    )
    worker = worker_of_killed(code)
    until(lambda: not is_alive(worker), "the worker of a killed benchmark ends")


def test_a_run_that_was_stopped_is_no_result(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stopped = SimpleNamespace(result={"outcome": "aborted"})
    monkeypatch.setattr("fsm_calib.runner.run.run_scenario", lambda scenario, directory: stopped)
    with pytest.raises(SystemExit, match="edge, seed 3: stopped"):
        fleet_runs.one_run("exit", ("edge", 3, {}))
