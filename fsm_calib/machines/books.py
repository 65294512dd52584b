"""The books: what a run has counted so far. Plain numbers, kept by `bookkeeping`, read by `guards`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any

from fsm_calib.errors import InputError


@dataclass(slots=True)
class Books:
    """The mutable context of one machine; every field is JSON as it stands.

    Parameters
    ----------
    plan : list of str
        The phases still to come, in order.
    phase : str
        The phase that runs; empty before the first and after the last.
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
    ticks : int
        Outcomes taken since the start of the run.
    failure : dict of str to str
        Why the run failed (name, reason, cure, state); empty while it has not.
    """

    plan: list[str] = field(default_factory=list)
    phase: str = ""
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
    ticks: int = 0
    failure: dict[str, str] = field(default_factory=dict)

    @classmethod
    def for_plan(cls, plan: Iterable[str]) -> Books:
        """Return empty books for a run through the phases of `plan`."""
        return cls(plan=list(plan))

    def clear(self) -> None:
        """Begin a phase: forget the counts of the one before."""
        fresh = Books(plan=self.plan, phase=self.phase, ticks=self.ticks)
        for item in fields(self):
            setattr(self, item.name, getattr(fresh, item.name))

    def to_dict(self) -> dict[str, Any]:
        """Return the books as plain JSON values."""
        values = {item.name: getattr(self, item.name) for item in fields(self)}
        return values | {"plan": list(self.plan), "failure": dict(self.failure)}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Books:
        """Return the books that `to_dict` wrote.

        Raises
        ------
        InputError
            When a field is missing or unknown: the checkpoint is from another version.
        """
        known = {item.name for item in fields(cls)}
        if set(data) != known:
            wrong = ", ".join(sorted(set(data) ^ known))
            raise InputError(
                f"the books' fields differ: {wrong}", where="checkpoint", cure="Start the run anew."
            )
        return cls(**{**data, "plan": list(data["plan"]), "failure": dict(data["failure"])})
