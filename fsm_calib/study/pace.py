"""How long a study will still take, told from its first second on: by the stages that its robots have behind them."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fsm_calib.study.models import Part
from fsm_calib.study.stages import starts
from fsm_calib.study.variants import BASE

TYPICAL: Mapping[str, float] = {"by_hand": 7.0, "test_1": 9.0, "test_2": 10.0}
"""Time of a stage before one has ended [s]: `fsm-calib study scenarios/study.yaml --robots 1` on a free core."""


@dataclass(frozen=True, slots=True)
class Work:
    """What one robot has to go through: its name, its stages in order, and the folder where ended ones are kept."""

    name: str
    stages: tuple[str, ...]
    folder: Path


@dataclass(frozen=True, slots=True)
class UnderWay:
    """A robot that is worked on: its stage [name], how long the stage has taken [s], and those to come."""

    name: str
    stage: str
    elapsed: float
    later: tuple[str, ...]


def stages_of(parts: Sequence[Part], variant: str) -> tuple[str, ...]:
    """Return the stages of a robot in order (`trial.run_trial`): test 1 needs the camera by hand."""
    if variant != BASE:
        return ("test_2",)
    by_hand = ("by_hand",) if {"by_hand", "test_1"} & set(parts) else ()
    return by_hand + tuple(part for part in ("test_1", "test_2") if part in parts)


class Pace:
    """What is left of a study.

    Parameters
    ----------
    pending : mapping of key to Work
        The robots without a row; `ended` takes them out.
    rows : iterable of dict
        Rows that are there, for what their stages cost.
    workers : int
        Robots at a time.
    """

    def __init__(self, pending: Mapping[Any, Work], rows: Iterable[Mapping[str, Any]], workers: int) -> None:
        self._pending, self._workers = dict(pending), workers
        self._spent: dict[str, list[float]] = {}
        for row in rows:
            self._learn(row.get("cost", {}))

    def ended(self, key: Any, row: Mapping[str, Any]) -> None:
        """Take note of a robot that has ended."""
        self._pending.pop(key, None)
        self._learn(row.get("cost", {}))

    def seconds_left(self) -> float:
        """Return the time [s] until the last robot ends, at the pace of the stages that have ended."""
        busy = {way.name: way for way in self.under_way()}
        left = 0.0
        for work in self._pending.values():
            way = busy.get(work.name)
            if way is None:
                left += sum(map(self._usual, work.stages))
            else:
                left += max(self._usual(way.stage) - way.elapsed, 0.0) + sum(map(self._usual, way.later))
        return left / max(min(self._workers, len(self._pending)), 1)

    def under_way(self) -> list[UnderWay]:
        """Return the robots that have begun, each with its stage."""
        return [way for work in self._pending.values() if (way := _under_way(work)) is not None]

    def sentence(self) -> str:
        """Return what a person is told: minutes left, and the stage of each robot at work."""
        left = self.seconds_left()
        said = f"{left / 60.0:.0f} min" if left >= 90.0 else f"{left:.0f} s"
        at_work = ", ".join(f"{way.name} {way.stage}" for way in self.under_way()[: self._workers])
        return f"about {said} left" + (f"; {at_work}" if at_work else "")

    def _usual(self, stage: str) -> float:
        """Return what the stage takes [s]: the mean of those that have ended."""
        known = self._spent.get(stage)
        return sum(known) / len(known) if known else TYPICAL[stage]

    def _learn(self, cost: Mapping[str, Mapping[str, float]]) -> None:
        for stage, spent in cost.items():
            self._spent.setdefault(stage, []).append(float(spent["wall"]))


def _under_way(work: Work) -> UnderWay | None:
    """Return how far a robot is; None where its work has not begun, or has ended since it was asked."""
    try:
        if not starts(work.folder):
            return None
        ended = [stage for stage in work.stages if (work.folder / f"{stage}.json").exists()]
        since = max(
            (work.folder / name).stat().st_mtime for name in ("starts", *(f"{e}.json" for e in ended))
        )
    except OSError:
        return None
    left = work.stages[len(ended) :]
    if not left:
        return None
    return UnderWay(work.name, left[0], max(time.time() - since, 0.0), left[1:])
