"""What is found out about one robot: identified, where asked for diagnosed; an error is its row."""

from __future__ import annotations

import os
import time
import traceback
from pathlib import Path
from typing import Any

from fsm_calib.errors import LONGEST_PART, FsmCalibError, shown
from fsm_calib.fleet.folders import RobotFiles
from fsm_calib.journal import plain
from fsm_calib.recording.recording import Recording


def robot_row(
    robot: RobotFiles, diagnosed: bool, stamp: list[list[str | int]], seed: int = 0
) -> dict[str, Any]:
    """Return the robot's row as plain JSON values; whatever goes wrong with it stands under ``error``."""
    began = time.perf_counter()
    row: dict[str, Any] = {
        "robot": robot.name,
        "recordings": [str(path) for path in robot.recordings],
        "asked": {"diagnose": diagnosed, "seed": seed, "files": stamp},
    }
    try:
        recordings = read_all(robot.recordings)
        row |= identified(recordings)
        if diagnosed:
            row["diagnosis"] = diagnosis_of(recordings, seed)
    except Exception as error:  # one robot's failure is its own row, whatever it is
        row["error"] = _error(error)
    return plain(row | {"seconds": time.perf_counter() - began, "process": os.getpid()})  # type: ignore[no-any-return]


def _error(error: Exception) -> dict[str, str]:
    said = (
        str(error) if isinstance(error, FsmCalibError) else f"not foreseen: {type(error).__name__}: {error}"
    )
    trace = "" if isinstance(error, FsmCalibError) else traceback.format_exc(limit=-4)
    return {"name": type(error).__name__, "reason": shown(said, 3 * LONGEST_PART), "trace": trace}


def read_all(paths: tuple[Path, ...]) -> list[Recording]:
    """Return a robot's recordings.

    Raises
    ------
    InputError
        One cannot be read.
    """
    from fsm_calib.recording import read_recording

    return [read_recording(path) for path in paths]


def identified(recordings: list[Recording]) -> dict[str, Any]:
    """Return what `identify` finds, where the robot pulls [m, left positive], gain and trim where they are told.

    Raises
    ------
    DataError
        The recordings do not tell the robot.
    """
    from fsm_calib.diagnosis.identify.identify import identify
    from fsm_calib.diagnosis.identify.straight import pull_of, straight_sentence, wheel_calibration
    from fsm_calib.errors import DataError
    from fsm_calib.recording.untold import why_no_pull

    found = identify(recordings)
    pull = pull_of(found, recordings)
    try:
        wheels = wheel_calibration(found, recordings)
    except DataError:
        wheels = None
    straight = None
    if pull is not None:
        arc = {"sideways_m": pull.sideways, "sd_m": pull.sd, "turned_rad": pull.turned}
        straight = {**arc, "side": pull.side}
    trim = None if wheels is None else {"gain": wheels.gain, "trim": wheels.trim}
    return {
        "straight": straight,
        "trim": trim,
        "sentence": straight_sentence(found, recordings),
        "untold": "" if pull is not None else why_no_pull(recordings),
        "identify": found.to_json(),
    }


def diagnosis_of(recordings: list[Recording], seed: int) -> dict[str, Any]:
    """Return the verdict of `diagnose` as `diagnose --json` writes it; a refusal stands under ``error``."""
    from fsm_calib.diagnosis.diagnose import diagnose

    try:
        return diagnose(recordings, seed=seed).verdict.as_json()
    except FsmCalibError as error:
        return {
            "verdict": "",
            "reason": shown(str(error), 3 * LONGEST_PART),
            "effects": [],
            "error": _error(error),
        }
