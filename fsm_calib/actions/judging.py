"""What a scan knows so far: views are kept for what they add, and now and then it is asked whether they suffice."""

from __future__ import annotations

from typing import Any

from fsm_calib.actions.bench import Bench
from fsm_calib.actions.settings import CameraSettings
from fsm_calib.outcome import Outcome
from fsm_calib.perception.information import (
    ScanProgress,
    StopRule,
    begin_scan,
    is_enough,
    solve_scan,
    weigh_view,
)
from fsm_calib.types import BoardView

ADDS_TOO_LITTLE = "adds too little"
"""Why a view is refused, as the journal says it."""


def stop_rule(settings: CameraSettings) -> StopRule:
    """Return the settings as the rule that perception knows."""
    return StopRule(
        predicted_px=settings.target_px,
        views_per_board=settings.least_views_per_board,
        views=settings.least_views,
        smallest_gain=settings.smallest_gain,
    )


def offer_view(bench: Bench, view: BoardView) -> dict[str, Any]:
    """Keep a numbered view when it adds enough, and return what the journal should know of it.

    Every view is kept, unweighed, when no gain is asked for (as published), and when it was filed under a number
    that no board of the row has (only as published).
    """
    notebook, settings = bench.notebook, bench.settings
    notebook.fresh_views += 1
    if settings.camera.smallest_gain == 0.0 or not 0 <= view.board < _boards(bench):
        notebook.views.append(view)
        return {"kept": True}
    rule = stop_rule(settings.camera)
    weighed = weigh_view(view, settings.board, _progress(bench), rule)
    said = {"kept": weighed.is_wanted, "gain": round(weighed.gain, 4)}
    if not weighed.is_wanted:
        notebook.views_refused += 1
        return said | {"refused": ADDS_TOO_LITTLE}
    notebook.views.append(view)
    notebook.progress = weighed.progress
    return said


def judge_views(bench: Bench) -> Outcome:
    """Solve the camera from the views kept so far and predict its error over the image; nothing moves."""
    notebook, settings = bench.notebook, bench.settings
    boards = range(_boards(bench))
    views = [view for view in notebook.views if view.board in boards]
    progress = solve_scan(views, settings.board, _progress(bench), boards=len(boards))
    notebook.progress, notebook.fresh_views = progress, 0
    rule = stop_rule(settings.camera)
    precise, predicted = is_enough(progress, rule), round(progress.predicted_px, 4)
    fewest = min(progress.views_per_board)
    evidence = {
        "precise": precise,
        "predicted_px": predicted,
        "views": progress.views,
        "fewest_views": fewest,
    }
    sentence = (
        f"{progress.views} views, at least {fewest} of a board: {predicted:.3f} px predicted error,"
        f" {rule.predicted_px:.3g} px asked for."
    )
    return Outcome("views_judged", evidence, sentence)


def _boards(bench: Bench) -> int:
    """Return how many boards the row has; 1 when nobody told."""
    return int(bench.briefing.get("boards", 1))


def _progress(bench: Bench) -> ScanProgress:
    """Return what the scan knows so far; at its beginning the fleet's median camera."""
    progress = bench.notebook.progress
    return begin_scan(bench.notebook.image_size, _boards(bench)) if progress is None else progress
