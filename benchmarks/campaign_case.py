"""A case of the campaign of runs: its folder, its random numbers, what was decided, and what is not right."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any


@dataclass
class Case:
    """One case: a folder of its own, its random numbers, and what was decided (kept for the report)."""

    folder: Path
    rng: random.Random
    reference: Callable[..., Path]
    """The directory of an undisturbed run of a scenario and seed; `pictures=False`: of its journal and result alone."""
    only: str = ""
    """The one scenario that kills take; otherwise it is drawn."""
    plan: dict[str, Any] = field(default_factory=dict)

    def choose(self, **given: Any) -> None:
        """Note decisions."""
        self.plan |= given


class Wrong(Exception):
    """What a run must not do."""
