"""`fsm-calib warm` compiles what the other commands would compile when they are first used."""

from __future__ import annotations

import multiprocessing
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

from fsm_calib.cli import app
from fsm_calib.world2d.ahead import compile_world
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.kernel import kernel
from fsm_calib.world2d.parameters import null_parameters, typical_parameters
from fsm_calib.world2d.rollout import Drive, simulate


@pytest.mark.parametrize("bare", [True, False])
def test_a_roll_out_after_it_compiles_nothing(bare: bool) -> None:
    compile_world()
    compiled = kernel(bare=bare).run_many
    before = len(compiled.signatures)
    vector = null_parameters() if bare else typical_parameters(registry()["battery_sag"])
    simulate(
        vector, Drive(np.array([0.0, 1.0]), np.ones(2), np.zeros(2)), np.arange(0.0, 2.0, 0.1), (0, 0, 0)
    )
    assert before == len(compiled.signatures) == 1


def test_a_compiling_process_that_dies_is_told_with_a_cure(monkeypatch: pytest.MonkeyPatch) -> None:
    class Dying:
        exitcode = -9

        def __init__(self, target: object) -> None:
            pass

        def start(self) -> None:
            pass

        join = start

    monkeypatch.setattr(multiprocessing.get_context("spawn"), "Process", Dying, raising=False)
    monkeypatch.setattr("fsm_calib.demo.drive_demo", lambda seed, seconds: SimpleNamespace(learned=()))
    monkeypatch.setattr("fsm_calib.diagnosis.identify.identify.identify", lambda recordings: None)
    done = CliRunner().invoke(app, ["warm"])
    assert done.exit_code == 1
    assert "ended with code -9" in done.output
