"""Take one frame and say whether the camera lives."""

from __future__ import annotations

import zlib

import numpy as np

from fsm_calib.actions.bench import Bench
from fsm_calib.outcome import Outcome
from fsm_calib.perception.turning import panorama
from fsm_calib.types import Frame

FRAME_MISSING = Outcome(
    "frame_missing",
    sentence="The camera delivered no frame.",
    cure="Check the camera's cable and that its driver runs.",
)
FRAME_FROZEN = Outcome(
    "frame_frozen",
    sentence="The frame is the same, pixel by pixel, as the one before, though the wheels were commanded.",
    cure="Restart the camera driver: it repeats an old frame.",
)


def look(bench: Bench) -> Frame | Outcome:
    """Return a frame, or the outcome that names its loss.

    A live sensor's noise never repeats, so a frame equal to the last one in every pixel is a frozen one. The
    notebook gets the frame's panorama and check sum.
    """
    notebook = bench.notebook
    frame = bench.robot.capture()
    if frame is None:
        notebook.unseen = True
        return FRAME_MISSING
    mark = zlib.crc32(np.ascontiguousarray(frame.image).data)
    if mark == notebook.frame_mark:
        notebook.unseen = True
        return FRAME_FROZEN
    notebook.frame_mark, notebook.unseen = mark, False
    notebook.image_size = (frame.image.shape[1], frame.image.shape[0])
    notebook.panorama = panorama(frame.image)
    return frame
