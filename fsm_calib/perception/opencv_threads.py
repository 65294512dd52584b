"""Keeps OpenCV to one thread: for programs that use the other cores for other robots."""

from __future__ import annotations

import cv2


def use_one_thread() -> None:
    """Let OpenCV work on the calling thread alone, in this process, from now on."""
    cv2.setNumThreads(1)
