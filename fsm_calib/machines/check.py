"""What the exhaustive check needs to know of the calibration: evidence and small budgets."""

from __future__ import annotations

from typing import Any

from fsm_calib.machines.limits import Limits
from fsm_calib.machines.supervisor import PHASES
from fsm_calib.statechart.machinery import Small

SAMPLES: dict[str, tuple[Any, ...]] = {
    "fresh_views": (0, 9),
    "turned": (0.0, 4.0),
    "heading": (0.0, -0.1, 0.1, -1.0, 1.0),
}
"""Evidence on both sides of every threshold of `small_limits`; truth values need no samples."""


SCAN = ("scan",)


def small_limits(
    boards: int, *, late: bool = False, passes: int = 1, budget: int = 2, misses: int = 2
) -> Limits:
    """Return budgets so small that every configuration can be visited, thresholds between the samples."""
    return Limits(
        boards=boards, start_board=boards // 2, passes=passes, misses_before_lost=misses,
        late_bound_check=late, views_per_board=budget, views_per_judgement=1, precise_judgements=2,
        search_steps=budget, search_angle=3.0, standpoints=2,
        focus_looks=budget, seeking_steps=budget, seeking_angle=3.0, turns=budget, overshoots=1, recoveries=2,
        frame_retries=1, aligned_within=0.05, roughly_aligned_within=0.2, square_within=0.5,
        quiet_iterations=min(budget, 3), iterations=budget + 1, leaving_steps=budget, following_steps=budget,
        markers=budget,
    )  # fmt: skip


SMALL = (
    *(Small(small_limits(2), (phase,)) for phase in PHASES),
    Small(small_limits(2, misses=1, passes=2, budget=1), SCAN),
    Small(small_limits(2, misses=3, passes=2, budget=1), SCAN),
    Small(small_limits(2, misses=1, passes=2, late=True), SCAN),
)
"""Together these take every row of the tables."""
