"""Floor tags: find AprilTag 36h11 squares and their corners.

OpenCV's aruco detector with sub-pixel refinement (2 ms, 0.35 px) is used. Its corner order follows its own
drawing of a tag, which is turned by half a turn against the AprilTag library's; here corners are handed out
in the library's order: bottom left, bottom right, top right, top left of the tag as the library draws it. So
the tag's x axis runs from corner 0 to corner 1, its y axis from corner 0 to corner 3, and z out of the print.
Sources: Olson, AprilTag, ICRA 2011; OpenCV objdetect/aruco; AprilRobotics apriltag, `tag36h11.c`.
"""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from fsm_calib.perception.chessboard import as_gray
from fsm_calib.types import TagDetection

#: position of the library's corners among those of OpenCV (top left, top right, bottom right, bottom left)
LIBRARY_FROM_OPENCV = (1, 0, 3, 2)


@lru_cache(maxsize=1)
def _detector() -> cv2.aruco.ArucoDetector:
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    return cv2.aruco.ArucoDetector(dictionary, parameters)


def find_tags(image: NDArray[np.uint8]) -> tuple[TagDetection, ...]:
    """Return every tag36h11 in a grey or BGR image, by number; corners [px] in the AprilTag library's
    order.
    """
    corners, numbers, _ = _detector().detectMarkers(as_gray(image))
    if numbers is None:
        return ()
    order = list(LIBRARY_FROM_OPENCV)
    found = [
        TagDetection(int(number), quad.reshape(4, 2)[order].astype(float))
        for number, quad in zip(numbers.ravel(), corners, strict=True)
    ]
    return tuple(sorted(found, key=lambda tag: tag.tag_id))


TAG_CELLS = 8
"""Cells along the side of a tag36h11's black square: border and code."""


def tag_cells(tag_id: int) -> NDArray[np.bool_]:
    """Return which cells of a tag36h11 are dark, shape (8, 8), from the top left of the upright tag.

    Upright is as the AprilTag library draws it; OpenCV's drawing is turned by half a turn, which is undone here.
    """
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    return np.rot90(cv2.aruco.generateImageMarker(dictionary, tag_id, TAG_CELLS), 2) < 128
