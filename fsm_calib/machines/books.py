"""The books: what a run has counted so far. Plain numbers, kept by `bookkeeping`, read by `guards`."""

from __future__ import annotations

from dataclasses import dataclass

from fsm_calib.statechart.books import Books as StatechartBooks


@dataclass(slots=True)
class Books(StatechartBooks):
    """The mutable context of the calibration's machines; plan, phase, ticks and failure are every machine's.

    Parameters
    ----------
    board : int
        The board that is observed or searched, from 0, counter-clockwise; outside the row only as published.
    changes : int
        Changes of the scan's direction.
    misses : int
        Misses in a row.
    views : int
        Steps that saw the present board in this sweep.
    precise : int
        Judgements in a row that found the camera precise.
    steps, angle : int, float
        Steps and angle [rad] of the present search.
    turns, overshoots : int
        Turning steps and changes of direction of the present alignment.
    standpoints, cameras : int
        Standpoints used, and those whose views gave a camera that was not precise enough.
    looks, iterations, quiet, leaving, following, markers, recoveries, lost_frames : int
        Events of their kind in this phase; `quiet` and `lost_frames` in a row.
    """

    board: int = 0
    changes: int = 0
    misses: int = 0
    views: int = 0
    precise: int = 0
    steps: int = 0
    angle: float = 0.0
    turns: int = 0
    overshoots: int = 0
    standpoints: int = 1
    cameras: int = 0
    looks: int = 0
    iterations: int = 0
    quiet: int = 0
    leaving: int = 0
    following: int = 0
    markers: int = 0
    recoveries: int = 0
    lost_frames: int = 0
