"""`fsm-calib diagnose` as one of the peers: in the same process, judged on the same windows of the same drive."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

from fsm_calib.diagnosis.diagnose import Diagnosis, diagnose
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.proof.transfer import on_new_recording
from fsm_calib.diagnosis.proof.windows import median_error, median_floor, prediction_windows
from fsm_calib.diagnosis.replay.prepared import Prepared, prepare
from fsm_calib.recording import read_recording
from peers.data import Track, Windows

OURS = "fsm-calib diagnose"
BASE = "base re-fitted by likelihood"
SAME_POSE = 1e-6  # s


def shared(track: Track, windows: Windows, prepared: Prepared) -> tuple[Windows, np.ndarray, np.ndarray]:
    """Return the windows that all can be judged on, with their first and last events in `prepared`.

    A window begins at the last pose before the peers' smoothed start and ends at the same measured pose; windows that
    end at a pose which the diagnosis took for a spike, or that hold a gap, are left out for everybody.
    """
    poses = np.flatnonzero(prepared.seen[:, 2])
    begun = poses[
        np.maximum(np.searchsorted(prepared.time[poses], track.t[windows.rows], side="right") - 1, 0)
    ]
    last = track.t[windows.rows] + windows.lasts
    ended = poses[np.clip(np.searchsorted(prepared.time[poses], last - SAME_POSE), 0, len(poses) - 1)]
    breaks = np.cumsum(prepared.restart)
    keep = (np.abs(prepared.time[ended] - last) < SAME_POSE) & (breaks[begun] == breaks[ended])
    return Windows(windows.rows[keep], windows.ends[keep], windows.lasts[keep]), begun[keep], ended[keep]


def new_drive(folder: Path) -> Prepared:
    """Return the drive that nobody fits, on the diagnosis' time line."""
    return prepare(read_recording(folder))


def answers(folder: Path, places: tuple[np.ndarray, np.ndarray]) -> list[dict]:
    """Diagnose one robot; return the lines of the re-fitted base and of the diagnosis, with the floor."""
    started = time.process_time()
    train = [read_recording(folder / run) for run in ("run-a", "run-b")]
    result = diagnose(train, [read_recording(folder / "run-h")])
    seconds = time.process_time() - started
    verdict = result.verdict
    names = [effect.name for effect in verdict.effects[:1]]
    names += [name for group in verdict.ambiguous if set(group) & set(names) for name in group]
    base, _ = _errors(result, result.decision.base, places)
    ours, floor = _errors(result, result.decision.model.fit, places)
    common = {"robot": folder.name, "floor": floor}
    said = {"names": sorted(set(names)), "verdict": verdict.verdict, "seconds": seconds}
    return [
        {**common, "peer": BASE, "names": [], **base},
        {**common, "peer": OURS, **said, **ours},
    ]


def _errors(result: Diagnosis, fit: Fit, places: tuple[np.ndarray, np.ndarray]) -> tuple[dict, dict]:
    """Return the median errors and floors [m], [rad] of a fit on the drive that it has not seen."""
    (simulator,) = result.holdout_simulators
    values = on_new_recording(Engine((simulator,)), fit)
    simulated = simulator.increments(values)[0]
    windows = [prediction_windows(simulator.prepared, fit.noise, simulated, places)]
    error, floor = median_error(windows), median_floor(windows)
    return (
        {"xy_m": error.xy_m, "theta_rad": error.theta_rad},
        {"xy_m": floor.xy_m, "theta_rad": floor.theta_rad},
    )
