"""A run that is cut at any event and resumed from its books goes on exactly as it would have."""

from __future__ import annotations

import json

import numpy as np
import pytest

from fsm_calib.errors import InputError
from fsm_calib.machines.books import Books
from fsm_calib.machines.calibration import CALIBRATION
from fsm_calib.machines.limits import Limits
from fsm_calib.outcome import Outcome
from fsm_calib.statechart.explore import outcomes
from fsm_calib.statechart.runtime import Fired, Machine

LIMITS = Limits(
    boards=3,
    start_board=1,
    search_angle=1e3,
    seeking_angle=1e3,
    misses_before_lost=2,
    search_steps=9,
    seeking_steps=9,
    iterations=12,
)
KIND = ("frame_missing", "frame_frozen", "wheel_stalled", "robot_blocked", "abort")


def walk(seed: int) -> tuple[list[Outcome], list[Fired], list[tuple[str, str]]]:
    """A random run: its outcomes, its records, and a checkpoint before each event; losses are made rare."""
    rng = np.random.default_rng(seed)
    machine = Machine(CALIBRATION, LIMITS)
    told, records, saved = [], [], []
    while not machine.is_terminal:
        choices = list(outcomes(CALIBRATION, machine.state))
        weights = np.array([0.004 if trigger in KIND else 1.0 for trigger, _ in choices])
        trigger, evidence = choices[rng.choice(len(choices), p=weights / weights.sum())]
        saved.append((machine.state, json.dumps(machine.books.to_dict())))
        told.append(Outcome(trigger, evidence))
        records.append(machine.fire(told[-1]))
    return told, records, saved


@pytest.mark.parametrize("seed", range(25))
def test_run_resumed_at_any_event_gives_the_same_records(seed: int) -> None:
    told, records, saved = walk(seed)
    for index in range(0, len(told), max(1, len(told) // 12)):
        state, books = saved[index]
        machine = Machine(CALIBRATION, LIMITS, books=Books.from_dict(json.loads(books)), state=state)
        assert [machine.fire(outcome) for outcome in told[index:]] == records[index:]
        assert machine.is_terminal


def test_random_runs_are_long_enough_to_mean_something() -> None:
    lengths = [len(walk(seed)[0]) for seed in range(25)]
    assert sum(lengths) > 250
    assert max(lengths) > 40


@pytest.mark.parametrize("change", [{"boards": 3}, {"plan": None}])
def test_books_of_another_version_are_refused(change: dict) -> None:
    data = Books().to_dict()
    data = {key: value for key, value in data.items() if key not in change} | {
        k: v for k, v in change.items() if v
    }
    with pytest.raises(InputError, match="fields differ"):
        Books.from_dict(data)
