r"""What sampled wheel rates leave open of the motion between them, laid to their stamps.

A wheel that begins to follow a step at the share f of an interval h, with a time constant tau, has a bend there which
straight lines from sample to sample cut off. They travel as if the wheel were late by

    h^2 / tau (1/12 - f (1 - f) / 2)         between - h / 12 and h / 6 where tau is h / 2 or more

and where commands and samples run on one clock, f is the same each time: poses then seem some milliseconds early or
late, though nothing delays them. So that shift of the stamps is taken at which the base robot tells the poses best, if
it lies within these bounds; one beyond them is no matter of sampling and stays to be named.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.fitting.fit import Engine
from fsm_calib.diagnosis.inputs import driving_rates, with_driving_rates
from fsm_calib.diagnosis.replay.prepared import prepare
from fsm_calib.diagnosis.replay.simulator import make_simulator
from fsm_calib.recording.channels import WheelPair
from fsm_calib.recording.recording import Recording

SHARES = (
    np.arange(-2, 5) / 24.0
)  # of the interval, by which samples may seem late: the bounds above, and between
LIKELIER = 2.0  # log-likelihood units: two standard deviations of a shift
SHORT = 0.01  # s: rates that come more often leave less than the tyres' own lag open


def with_bends(
    recordings: Sequence[Recording], others: Sequence[Recording] = ()
) -> tuple[list[Recording], list[Recording], str]:
    """Return both lists, their rates moved where samples leave it open, and a sentence where they were.

    recordings, others : drives with poses that are ready to be prepared; only `recordings` decide.
    """
    sampled = [pair for pair in map(_samples, recordings) if pair is not None]
    same = list(recordings), list(others), ""
    if not sampled or len(sampled) < len(recordings):
        return same
    interval = float(np.median(np.concatenate([np.diff(pair.time) for pair in sampled])))
    if interval < SHORT:
        return same
    shifts = interval * SHARES
    told = np.array([_told(recordings, float(shift)) for shift in shifts])
    if told.argmax() in (0, len(told) - 1):  # at a bound: not what sampling does
        return same
    shift = _top(shifts, told)
    if _told(recordings, shift) < told[SHARES == 0.0][0] + LIKELIER:
        return same
    sentence = (
        f"the wheels' rates, a sample every {interval:.3g} s, are read {1e3 * abs(shift):.1f} ms "
        f"{'earlier' if shift > 0.0 else 'later'}: so much they leave open of what the wheels do between them"
    )
    return _moved(recordings, shift), _moved(others, shift), sentence


def _samples(recording: Recording) -> WheelPair | None:
    """Return the rates that drive the simulation of a recording, where they are samples."""
    pair = driving_rates(recording)
    sampled = pair is not None and pair.duration is None and pair.stamp in (None, "middle") and len(pair) > 2
    return pair if sampled else None


def _moved(recordings: Sequence[Recording], shift: float) -> list[Recording]:
    """Return the recordings with their rates `shift` [s] earlier."""
    moved = []
    for recording in recordings:
        pair = _samples(recording)
        earlier = None if pair is None else replace(pair, time=pair.time - shift)
        moved.append(recording if earlier is None else with_driving_rates(recording, earlier))
    return moved


def _told(recordings: Sequence[Recording], shift: float) -> float:
    """Return the log-likelihood of the base robot with the rates `shift` [s] earlier."""
    engine = Engine(tuple(make_simulator(prepare(r)) for r in _moved(recordings, shift)))
    return fit_base(engine).log_likelihood


def _top(shifts: np.ndarray, told: np.ndarray) -> float:
    """Return where the parabola through the largest of `told` (n,) and its neighbours has its top."""
    i = int(told.argmax())
    a, b, _ = np.polyfit(shifts[i - 1 : i + 2], told[i - 1 : i + 2], 2)
    return float(-0.5 * b / a)
