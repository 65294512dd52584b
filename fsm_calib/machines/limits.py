"""The budgets and thresholds that the guards compare the books with."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace

from fsm_calib.errors import InputError, UnknownNameError


@dataclass(frozen=True, slots=True)
class Limits:
    """What a run may spend, and what is good enough. Counts are events of the machine, angles are in rad.

    Parameters
    ----------
    boards : int
        N, how many chessboards stand around the robot (paper, section 3.1).
    start_board : int
        The board in front of the robot at the start, from 0, counter-clockwise.
    passes : int
        P, full sweeps over the row of boards; the scan ends at direction change P + 1.
    misses_before_lost : int
        M, misses in a row that lose a board, a lane or the last marker. The published table loses at 1; with
        detections that fail one time in twenty, three in a row are a loss and not a glitch.
    late_bound_check : bool
        As published: the end of the row is noticed one cycle after it was passed, and one more step follows
        the last change of direction.
    views_per_board : int
        Steps with one board in sight in one sweep before the machine concludes that the robot does not turn.
    views_per_judgement : int
        Views, kept or not, after which the camera is solved and judged; one solve of 60 views takes 40 ms. 0, as
        published: never, the sweeps alone end the scan.
    precise_judgements : int
        Judgements in a row that must find the camera precise; the second one guards against a lucky solve.
    search_steps, search_angle : int, float
        Budget of one search for a board: steps, and angle turned [rad] as far as the activity can tell. A
        board of a semicircle comes into a 100 degree picture after at most 180 - 100 degrees; half a turn
        leaves room for the error of an uncalibrated estimate.
    standpoints : int
        Places from which the boards are scanned, the first included.
    focus_looks : int
        Looks at the sharpness before the picture counts as blurred.
    seeking_steps : int
        Budget of one search for markers or the lane, in steps [1].
    seeking_angle : float
        Budget of one search as a turn [rad]. The paper: "no more than one revolution"; 10 % more for the overlap.
    turns : int
        Small turning steps of one alignment.
    overshoots : int
        Changes of direction of one alignment.
    recoveries : int
        Losses of a marker or the lane in one phase that are followed by a search.
    frame_retries : int
        Missing or frozen frames in a row that are looked for again. A camera that loses half of its frames loses 21 in
        a row once in two million looks; six in a row it loses six times in the 400 of a run.
    aligned_within : float
        Marker angle at which the robot stands along the markers [rad]; 3 degrees in the floor frame. The
        published program stops at 0.15 in its camera frame.
    roughly_aligned_within : float
        Marker angle that is accepted when the turns are spent [rad]; at 10 degrees a drive of 0.7 m moves
        0.12 m sideways, which a field three markers wide holds.
    square_within : float
        Marker angle up to which a wheel drive begins without squaring up first [rad].
    quiet_iterations : int
        Quiet wheel iterations in a row that end the phase (paper, section 3.4: three).
    iterations : int
        Wheel iterations in all.
    leaving_steps : int
        Steps of the straight drive out of the field.
    following_steps : int
        Steps of lane following before the reserved marker must have been seen.
    markers : int
        Markers of the marked lane section whose measurement refines k (paper, section 5.2: the number is
        known).
    """

    boards: int = 2
    start_board: int = 0
    passes: int = 1
    misses_before_lost: int = 3
    late_bound_check: bool = False
    views_per_board: int = 80
    views_per_judgement: int = 5
    precise_judgements: int = 2
    search_steps: int = 80
    search_angle: float = math.pi
    standpoints: int = 2
    focus_looks: int = 30
    seeking_steps: int = 150
    seeking_angle: float = 1.1 * math.tau
    turns: int = 60
    overshoots: int = 12
    recoveries: int = 6
    frame_retries: int = 20
    aligned_within: float = math.radians(3.0)
    roughly_aligned_within: float = math.radians(10.0)
    square_within: float = math.radians(10.0)
    quiet_iterations: int = 3
    iterations: int = 40
    leaving_steps: int = 120
    following_steps: int = 600
    markers: int = 6

    def __post_init__(self) -> None:
        """Refuse budgets that no run could keep."""
        for item in fields(self):
            value = getattr(self, item.name)
            least = 0 if item.name in _MAY_BE_ZERO else 1
            if isinstance(value, bool):
                continue
            if not math.isfinite(value) or (value < least if isinstance(value, int) else value <= 0.0):
                cure = f"Give {least} or more." if isinstance(value, int) else "Give a positive angle in rad."
                raise InputError(f"limit {item.name} is {value}", where=item.name, cure=cure)
        if self.start_board >= self.boards:
            cure = f"Boards are numbered from 0 to {self.boards - 1}, counter-clockwise."
            raise InputError(
                f"start_board is {self.start_board} of {self.boards}", where="start_board", cure=cure
            )


_MAY_BE_ZERO = ("start_board", "views_per_judgement", "frame_retries", "recoveries", "overshoots")

PUBLISHED: dict[str, dict[str, object]] = {
    "single_miss_flip": {"misses_before_lost": 1},
    "late_bound_check": {"late_bound_check": True},
    "sweep_count": {"views_per_judgement": 0, "standpoints": 1},
    "camera_yaw_threshold": {"aligned_within": 0.15},
}
"""The published behaviours that are limits, by name; each lists the limits it changes (docs/machines.md)."""


def with_published(limits: Limits, *names: str) -> Limits:
    """Return `limits` with the published behaviours `names` switched on.

    Raises
    ------
    UnknownNameError
        When a name is not in `PUBLISHED`.
    """
    for name in names:
        if name not in PUBLISHED:
            raise UnknownNameError("published behaviour", name, PUBLISHED)
        limits = replace(limits, **PUBLISHED[name])  # type: ignore[arg-type]
    return limits
