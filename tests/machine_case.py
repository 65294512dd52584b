"""A case: one transition of the machines in one situation, and what every machine loses alike.

A case puts the machine into a leaf with given books, fires one outcome and names the row of the table that
must be taken, the leaf that must be reached and every book that must have changed.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from fsm_calib.machines.limits import Limits

LIMITS = Limits(
    boards=3, start_board=1, passes=1, misses_before_lost=2, views_per_board=5, views_per_judgement=3,
    precise_judgements=2, search_steps=4, search_angle=2.0,
    standpoints=2, focus_looks=3, seeking_steps=4, seeking_angle=3.0, turns=3, overshoots=1, recoveries=2,
    frame_retries=2, aligned_within=0.05, roughly_aligned_within=0.2, square_within=0.3, quiet_iterations=3,
    iterations=5, leaving_steps=4, following_steps=4, markers=3,
)  # fmt: skip
ALIGNED, ROUGH, ASKEW = 0.05, 0.2, 0.31
FAILED = "failed/"


@dataclass(frozen=True)
class Case:
    """One transition in one situation: in `leaf` with `before` in the books, `trigger` with `evidence`."""

    source: str
    leaf: str
    trigger: str
    condition: str
    dest: str | None
    before: Mapping[str, Any] = field(default_factory=dict)
    evidence: Mapping[str, Any] = field(default_factory=dict)
    after: Mapping[str, Any] = field(default_factory=dict)
    entered: str = ""

    @property
    def covers(self) -> str:
        """The ident of the row of the table that this case shows."""
        return f"{self.source}--{self.trigger}[{self.condition}]->{self.dest or '(stay)'}"

    @property
    def reached(self) -> str:
        """The leaf that must be active afterwards."""
        return self.entered or self.dest or self.leaf


def case(source: str, trigger: str, condition: str, dest: str | None, before: Mapping[str, Any] | None = None,
         evidence: Mapping[str, Any] | None = None, after: Mapping[str, Any] | None = None, *,
         entered: str = "") -> Case:  # fmt: skip
    """Return a case whose leaf is the source itself."""
    return Case(source, source, trigger, condition, dest, before or {}, evidence or {}, after or {}, entered)


def losing_frames(source: str, *leaves: str) -> Iterable[Case]:
    """Two lost frames in a row are forgiven, the third ends the run; in every leaf of `source`."""
    for leaf in leaves or (source,):
        for trigger, end in (("frame_missing", "camera_silent"), ("frame_frozen", "camera_frozen")):
            yield Case(source, leaf, trigger, "has_frame_retries_left", None, {"lost_frames": 1,
            "misses": 1}, {},
                       {"lost_frames": 2})  # fmt: skip
            yield Case(source, leaf, trigger, "!has_frame_retries_left", FAILED + end, {"lost_frames": 2}, {},
                       {"lost_frames": 0})  # fmt: skip


def losing_motion(source: str, *leaves: str) -> Iterable[Case]:
    """A wheel that stands and an obstacle end the run at once; in every leaf of `source`."""
    for leaf in leaves or (source,):
        yield Case(source, leaf, "wheel_stalled", "", FAILED + "wheel_dead")
        yield Case(source, leaf, "robot_blocked", "", FAILED + "wall_hit")


def stopping(*leaves: str) -> Iterable[Case]:
    """The operator stops the run, from every leaf."""
    for leaf in leaves:
        yield Case(leaf.split("/")[0], leaf, "abort", "", "aborted")
