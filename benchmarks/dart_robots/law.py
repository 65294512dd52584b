"""What an effect's law is: a natural cause with one size, drawn details, and a change of a robot's truth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchmarks.dart_robots.robots import KINDS
from benchmarks.dart_robots.truth import Pair, Truth

Details = dict[str, float]
BOTH = ("duty", "rate")
PLACES = ("rough", "slippery", "seam")  # what limits an effect to a place


def nothing(rng: np.random.Generator, truth: Truth) -> Details:
    """Draw no details."""
    return {}


@dataclass(frozen=True)
class Law:
    """One natural cause of a label.

    size : its name with a unit, and the range from hardly visible to as strong as robots are found; the
    weaker end comes first. touched : what limits it to windows ("rough", "slippery", "seam", "push",
    "fault" or ""). modes : robots that it can show on; kinds, caster : likewise where not on all.
    """

    label: str
    name: str
    size: str
    weak: float
    strong: float
    apply: Callable[[Truth, float, Details], Truth]
    draw: Callable[[np.random.Generator, Truth], Details] = nothing
    modes: tuple[str, ...] = BOTH
    touched: str = ""
    caster: str = ""
    encoders: bool | None = None
    kinds: tuple[str, ...] = tuple(KINDS)

    def at(self, strength: float) -> float:
        """Return the size at a strength of 0 to 1."""
        return float(self.weak * (self.strong / self.weak) ** strength)


def _changed(part: str) -> Callable[..., Truth]:
    """Return a function of a robot and changes of one of its parts that returns the changed robot."""

    def changed(truth: Truth, **changes: Any) -> Truth:
        return replace(truth, **{part: replace(getattr(truth, part), **changes)})

    return changed


with_drive, with_body = _changed("drive"), _changed("body")
with_place, with_watch = _changed("place"), _changed("watch")


def sides(rng: np.random.Generator, truth: Truth) -> Details:
    """Draw which wheels are hit: one of them, or both in unlike measure."""
    which = int(rng.integers(3))
    if which == 2:
        return {"left_share": 1.0, "right_share": float(rng.uniform(0.6, 1.0))}
    return {"left_share": float(which == 0), "right_share": float(which == 1)}


def one_side(rng: np.random.Generator, truth: Truth) -> Details:
    """Draw one wheel."""
    which = int(rng.integers(2))
    return {"left_share": float(which == 0), "right_share": float(which == 1)}


def both_sides(rng: np.random.Generator, truth: Truth) -> Details:
    """Draw both wheels in like measure."""
    low = float(rng.uniform(0.8, 1.0))
    return (
        {"left_share": 1.0, "right_share": low}
        if rng.random() < 0.5
        else {"left_share": low, "right_share": 1.0}
    )


def heading(rng: np.random.Generator, truth: Truth) -> Details:
    """Draw a direction on the floor."""
    return {"heading_rad": float(rng.uniform(-np.pi, np.pi))}


def shared(details: Details, size: float, neutral: float = 0.0) -> Pair:
    """Return a size on the wheels that are hit."""
    left, right = details["left_share"], details["right_share"]
    return neutral + (size - neutral) * left, neutral + (size - neutral) * right
