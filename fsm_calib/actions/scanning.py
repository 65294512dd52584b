"""The verbs of the camera scan: look for the start board, step with a board in sight, search for the next
one.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fsm_calib.actions.bench import Bench
from fsm_calib.actions.boards import (
    Sighting,
    beyond,
    expected_azimuth,
    first_of,
    followed,
    keep_view,
    sightings,
)
from fsm_calib.actions.looking import look
from fsm_calib.actions.moving import CLOCKWISE, COUNTERCLOCKWISE
from fsm_calib.actions.turning import Step, turn_step, turned_evidence
from fsm_calib.outcome import Outcome


def look_for_board(bench: Bench) -> Outcome:
    """Look, without moving, for the board the robot was placed in front of: the one nearest to the middle."""
    bench.notebook.board_azimuth = None
    frame = look(bench)
    if isinstance(frame, Outcome):
        return frame
    found = sightings(bench, frame)
    if not found:
        return _missed(0.0)
    nearest = min(found, key=lambda sighting: abs(sighting.azimuth))
    kept = keep_view(bench, nearest, _board(bench), frame)
    return _seen(bench, nearest, 0.0, kept)


def step_clockwise(bench: Bench) -> Outcome:
    """Turn one step clockwise and keep the view of the board that is followed."""
    return _step(bench, CLOCKWISE)


def step_counterclockwise(bench: Bench) -> Outcome:
    """Turn one step counter-clockwise and keep the view of the board that is followed."""
    return _step(bench, COUNTERCLOCKWISE)


def search_clockwise(bench: Bench) -> Outcome:
    """Turn a larger step clockwise and look for the board that comes into sight."""
    return _search(bench, CLOCKWISE)


def search_counterclockwise(bench: Bench) -> Outcome:
    """Turn a larger step counter-clockwise and look for the board that comes into sight."""
    return _search(bench, COUNTERCLOCKWISE)


def _board(bench: Bench) -> int:
    return int(bench.briefing.get("board", 0))


def _seen(bench: Bench, sighting: Sighting, turned: float, kept: Mapping[str, Any]) -> Outcome:
    views, fresh = len(bench.notebook.views), bench.notebook.fresh_views
    evidence = {"azimuth": round(sighting.azimuth, 4), "views": views, "turned": round(turned, 5)}
    refused = f", this one not: it {kept['refused']}" if "refused" in kept else ""
    sentence = f"The board is in sight; {views} views are kept{refused}."
    return Outcome("board_seen", {**evidence, "fresh_views": fresh, **kept}, sentence)


def _missed(turned: float) -> Outcome:
    return Outcome(
        "board_missed",
        {"turned": round(turned, 5)},
        "The board is not in sight.",
        "Place the robot so that a whole chessboard is in its picture.",
    )


def _step(bench: Bench, way: str) -> Outcome:
    step = turn_step(bench, way, bench.settings.turn.scan_step)
    if isinstance(step, Outcome):
        return step
    found = sightings(bench, step.frame)
    same = followed(bench, found, step.turned)
    if same is not None:
        kept = keep_view(bench, same, _board(bench), step.frame)
        bench.notebook.followed_way = way
        return _seen(bench, same, step.turned, kept)
    next_one = beyond(bench, found, way, step.turned)
    if next_one is not None:
        return _next(bench, next_one, way, step)
    _carry(bench, step.turned)
    return _missed(step.turned)


def _next(bench: Bench, sighting: Sighting, way: str, step: Step) -> Outcome:
    """Follow the next board; beyond the row's end it is none of the declared ones, and no view is kept."""
    board, kept = _board(bench) + (-1 if way == CLOCKWISE else 1), {}
    if 0 <= board < int(bench.briefing.get("boards", board + 1)):
        kept = keep_view(bench, sighting, board, step.frame)
    bench.notebook.followed_way = way
    sentence = "The board followed so far left the picture; the next one is in it."
    return Outcome("next_board_seen", {**turned_evidence(step), **kept}, sentence)


def _search(bench: Bench, way: str) -> Outcome:
    step = turn_step(bench, way, bench.settings.turn.search_step)
    if isinstance(step, Outcome):
        return step
    found = sightings(bench, step.frame)
    onward = bench.notebook.followed_way == way
    sought = beyond(bench, found, way, step.turned) if onward else first_of(found, way)
    if sought is None:
        _carry(bench, step.turned)
        return _missed(step.turned)
    kept = keep_view(bench, sought, _board(bench), step.frame)
    bench.notebook.followed_way = way
    return _seen(bench, sought, step.turned, kept)


def _carry(bench: Bench, turned: float) -> None:
    """Carry the azimuth of the board that was followed along with the turn."""
    bench.notebook.board_azimuth = expected_azimuth(bench, turned)
