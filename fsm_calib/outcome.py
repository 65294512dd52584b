"""What an action hands back to the machine that runs it.

An action never raises because the robot failed: a board that is not in sight, a wall, a dead wheel are outcomes,
and a declared transition takes each of them. `trigger` is the past-tense fact that the machine receives; `evidence`
holds the numbers that guards read and the journal keeps; `sentence` is for a person.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any


@dataclass(frozen=True, slots=True)
class Outcome:
    """The result of one do-activity.

    Parameters
    ----------
    trigger : str
        The fact that happened, as declared in the machine's table (for instance ``board_seen``).
    evidence : mapping of str to plain JSON values
        What guards read and the journal keeps. Never arrays: large results go to the bench (`actions.bench`).
    sentence : str
        One sentence for a person; for a failure it holds the reason.
    cure : str
        For a failure, what the operator can do about it.
    """

    trigger: str
    evidence: Mapping[str, Any] = field(default_factory=dict)
    sentence: str = ""
    cure: str = ""

    def __post_init__(self) -> None:
        """Freeze the evidence, so that what the journal keeps is what the guards saw."""
        object.__setattr__(self, "evidence", MappingProxyType(dict(self.evidence)))
