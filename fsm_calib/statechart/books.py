"""The books of a machine: what it has counted so far. Plain numbers, kept by actions, read by guards."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any, Self

from fsm_calib.errors import InputError


@dataclass(slots=True)
class Books:
    """What the books of every machine hold; a machine's own books are a dataclass that adds its counts.

    Every field must have a default and be JSON as it stands.

    Parameters
    ----------
    plan : list of str
        The phases still to come, in order; empty for a machine without phases.
    phase : str
        The phase that runs; empty before the first and after the last.
    ticks : int
        Outcomes taken since the start of the run.
    failure : dict of str to str
        Why the run failed (name, reason, cure, state); empty while it has not.
    """

    plan: list[str] = field(default_factory=list)
    phase: str = ""
    ticks: int = 0
    failure: dict[str, str] = field(default_factory=dict)

    @classmethod
    def for_plan(cls, plan: Iterable[str]) -> Self:
        """Return empty books for a run through the phases of `plan`."""
        return cls(plan=list(plan))

    def clear(self) -> None:
        """Begin a phase: forget the counts of the one before."""
        fresh = type(self)(plan=self.plan, phase=self.phase, ticks=self.ticks)
        for item in fields(self):
            setattr(self, item.name, getattr(fresh, item.name))

    def to_dict(self) -> dict[str, Any]:
        """Return the books as plain JSON values, which share nothing with them."""
        return {item.name: _copied(getattr(self, item.name)) for item in fields(self)}

    @classmethod
    def from_dict(cls, data: Mapping[str, Any]) -> Self:
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
        return cls(**{name: _copied(value) for name, value in data.items()})


def _copied(value: Any) -> Any:
    """Return a list or a mapping as a new one; other values as they are."""
    if isinstance(value, list):
        return list(value)
    return dict(value) if isinstance(value, Mapping) else value
