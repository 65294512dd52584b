"""The words of the contract between states and what is done in them: activities and what they may return."""

from __future__ import annotations

from dataclasses import dataclass

OPERATOR = ("abort",)
"""Triggers that come from the operator and not from an activity."""


@dataclass(frozen=True, slots=True)
class Returned:
    """One outcome of an activity: its trigger, what it means, and the evidence that guards need.

    Each evidence is ``key: what it is``; a truth value is written ``key: bool, what it says``.
    """

    trigger: str
    meaning: str
    evidence: tuple[str, ...] = ()

    @property
    def keys(self) -> tuple[str, ...]:
        """The evidence keys, without their explanations."""
        return tuple(text.split(":")[0] for text in self.evidence)


@dataclass(frozen=True, slots=True)
class Activity:
    """A do-activity: its name, what it must do, what it may return."""

    name: str
    does: str
    returns: tuple[Returned, ...]

    @property
    def triggers(self) -> tuple[str, ...]:
        """The outcomes it may return."""
        return tuple(item.trigger for item in self.returns)


def contract_of(*activities: Activity) -> dict[str, Activity]:
    """Return the activities by name, as a `Machinery` wants them."""
    return {activity.name: activity for activity in activities}
