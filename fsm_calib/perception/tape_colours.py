"""Which pixels of a floor are white and which are yellow tape, in a room of any light.

Hue and saturation are the same in any light, the value (the largest of the three colours) is not. White begins where
Otsu's threshold divides the values of the floor's grey pixels (Otsu, IEEE Trans. SMC 9(1), 1979), if what lies beyond
is brighter than the rest by `LEAST_CONTRAST`; else there is no white on this floor. Yellow begins at a share of that
value. Hues, saturations and the share are of Duckietown's line_detector (default.yaml), whose white begins at 150.
"""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

WHITE_SATURATION = 60
"""Largest saturation of white and of a grey floor, of 255."""
YELLOW_HUES, YELLOW_SATURATION = (22, 38), 90
"""Hues of yellow, of 180, and its least saturation, of 255."""
YELLOW_SHARE = 90.0 / 150.0
"""Value at which yellow begins, over that at which white does [1]."""
LEAST_CONTRAST = 1.5
"""Mean value of white over that of the floor, at least [1]: 1.8 to 2.9 where there is tape (docs/campaigns.md), 1.15 to
1.35, the lens's fall-off and its noise, where there is none.
"""
_NONE = 256.0
_ALL = 255.0


class TapeValues(NamedTuple):
    """The values at which white and yellow begin, of 255; beyond 255 for a colour that is not there."""

    white: float
    yellow: float


def tape_values(floor: NDArray[np.uint8]) -> TapeValues:
    """Return the values at which tape begins.

    Parameters
    ----------
    floor : array, shape (n, 3), uint8, hue, saturation and value
        Pixels of the floor, taken evenly. Without white among them yellow begins at their median.
    """
    if len(floor) == 0:
        return TapeValues(_NONE, _NONE)
    usual = float(np.median(floor[:, 2]))
    white = _white_begins(floor[floor[:, 1] <= WHITE_SATURATION, 2])
    return TapeValues(white, usual if white == _NONE else max(usual, YELLOW_SHARE * white))


def _white_begins(grey: NDArray[np.uint8]) -> float:
    """Return the value at which white begins among the values (n,) of grey pixels."""
    if len(grey) == 0:
        return _NONE
    level, _ = cv2.threshold(np.ascontiguousarray(grey), 0, 255, cv2.THRESH_BINARY | cv2.THRESH_OTSU)
    bright, dark = grey[grey > level], grey[grey <= level]
    if min(len(bright), len(dark)) == 0 or bright.mean() < LEAST_CONTRAST * dark.mean():
        return _NONE
    return float(level) + 1.0


def tape_masks(hsv: NDArray[np.uint8], begins: TapeValues) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """Return the masks of white and of yellow pixels of a picture, uint8 (height, width), of hue, saturation, value."""
    low_hue, high_hue = YELLOW_HUES
    white = _within(hsv, (0.0, 0.0, begins.white), (180.0, WHITE_SATURATION, _ALL))
    yellow = _within(hsv, (low_hue, YELLOW_SATURATION, begins.yellow), (high_hue, _ALL, _ALL))
    return white, yellow


def _within(
    hsv: NDArray[np.uint8], low: tuple[float, float, float], high: tuple[float, float, float]
) -> NDArray[np.uint8]:
    return np.asarray(
        cv2.inRange(hsv, np.array(low, dtype=float), np.array(high, dtype=float)), dtype=np.uint8
    )
