"""Find the chessboard that is followed, among those in the frame, and keep its views."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fsm_calib.actions.bench import Bench
from fsm_calib.actions.judging import offer_view
from fsm_calib.actions.moving import CLOCKWISE
from fsm_calib.perception.chessboard import find_boards
from fsm_calib.perception.fleet_camera import fleet_camera
from fsm_calib.perception.lens import intrinsics_vector, unproject
from fsm_calib.types import BoardView, Frame

SAME_BOARD_WITHIN = math.radians(12.0)
"""A board is the one followed when it is this near to where the turn should have brought it [rad]: half the
width of a board at 0.6 m, and three times the error of an uncalibrated azimuth."""


@dataclass(frozen=True, eq=False)
class Sighting:
    """A board in a frame: its view and its azimuth, counter-clockwise of the image's middle [rad]."""

    view: BoardView
    azimuth: float


def sightings(bench: Bench, frame: Frame) -> tuple[Sighting, ...]:
    """Return every board in the frame, from the right to the left (azimuth rising)."""
    views = find_boards(frame.image, bench.settings.board)
    found = [Sighting(view, azimuth_of(view)) for view in views]
    corners = np.vstack([view.corners_image for view in views]) if views else np.empty((0, 2))
    bench.keep(frame.image, frame.time, "scan", corners)
    return tuple(sorted(found, key=lambda sighting: sighting.azimuth))


def azimuth_of(view: BoardView) -> float:
    """Return the azimuth of a board's middle through the fleet's median camera [rad], counter-clockwise
    positive.
    """
    middle = view.corners_image.mean(axis=0, keepdims=True)
    ray = unproject(intrinsics_vector(fleet_camera()), middle)[0]
    return -math.atan2(float(ray[0]), 1.0)


def keep_view(bench: Bench, sighting: Sighting, board: int, frame: Frame) -> dict[str, Any]:
    """Offer the view under the board's number, follow this board from now on, and return what became of the
    view.
    """
    bench.notebook.board_azimuth = sighting.azimuth
    return offer_view(bench, replace(sighting.view, board=board, source=f"frame {frame.index}"))


def followed(bench: Bench, found: tuple[Sighting, ...], turned: float) -> Sighting | None:
    """Return the board that was followed so far, or None: where it should be now is its last azimuth minus
    the turn.
    """
    expected = expected_azimuth(bench, turned)
    if expected is None or not found:
        return None
    best = min(found, key=lambda sighting: abs(sighting.azimuth - expected))
    return best if abs(best.azimuth - expected) <= SAME_BOARD_WITHIN else None


def expected_azimuth(bench: Bench, turned: float) -> float | None:
    """Return where the followed board is after a turn [rad], None when none was followed."""
    last = bench.notebook.board_azimuth
    return None if last is None else last - turned


def beyond(bench: Bench, found: tuple[Sighting, ...], way: str, turned: float) -> Sighting | None:
    """Return the board next to the followed one in the direction of the turn, or None."""
    expected = expected_azimuth(bench, turned)
    if expected is None:
        return first_of(found, way)
    if way == CLOCKWISE:
        return first_of(tuple(s for s in found if s.azimuth < expected - SAME_BOARD_WITHIN), way)
    return first_of(tuple(s for s in found if s.azimuth > expected + SAME_BOARD_WITHIN), way)


def first_of(found: tuple[Sighting, ...], way: str) -> Sighting | None:
    """Return the board that a turn `way` comes to first: the leftmost one clockwise, the rightmost one
    otherwise.
    """
    if not found:
        return None
    return found[-1] if way == CLOCKWISE else found[0]
