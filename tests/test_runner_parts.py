"""The time by part adds up, and every call into OpenCV is seen."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from fsm_calib.perception.opencv_time import watched
from fsm_calib.runner.parts import Parts


class Ticks:
    def __init__(self, *times: float) -> None:
        self.times = iter(times)

    def __call__(self) -> float:
        return next(self.times)


def test_each_moment_is_charged_to_the_innermost_part() -> None:
    parts = Parts("rest", Ticks(0.0, 1.0, 3.0, 6.0, 10.0, 15.0))
    with parts.part("outer"), parts.part("inner"):
        pass
    assert parts.seconds() == {"outer": 2.0 + 4.0, "rest": 1.0 + 5.0, "inner": 3.0}


def test_a_part_ends_when_its_block_raises() -> None:
    parts = Parts("rest", Ticks(0.0, 1.0, 3.0, 6.0))
    with pytest.raises(ValueError, match="x"), parts.part("broken"):
        raise ValueError("x")
    assert parts.seconds() == {"rest": 4.0, "broken": 2.0}


def test_calls_into_opencv_are_seen_and_the_library_is_as_before() -> None:
    events: list[str] = []
    image = np.zeros((64, 64), np.uint8)
    before = (cv2.GaussianBlur, cv2.aruco.ArucoDetector)
    with watched(lambda: events.append("in"), lambda: events.append("out")):
        blurred = cv2.GaussianBlur(image, (3, 3), 1.0)
        detector = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11))
        detector.detectMarkers(image)
    assert events.count("in") == events.count("out") >= 3
    assert blurred.shape == image.shape
    assert (cv2.GaussianBlur, cv2.aruco.ArucoDetector) == before
