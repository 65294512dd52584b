"""How sharp an image is: the ratio of fine to coarse detail in reorganized DCT coefficients.

8x8 block DCT coefficients c(u, v) are regrouped by m = max(u, v) into three scales, as a wavelet would:
S3 = {1}, S2 = {2, 3}, S1 = {4..7}. The value is::

    F = (E(S2) + E(S1 with u + v <= 8)) / E(S3)

with E the mean energy per coefficient group minus the noise's, whose standard deviation is estimated as
median|c(u >= 6, v >= 6)| / 0.6745. Being a ratio it does not depend on contrast, and the subtraction keeps
its scale under noise. A reading of Zhang, Liu, Tan, Zhang, "Robust sharpness metrics using reorganized DCT
coefficients for auto-focus application", ACCV 2014 (the paper's chapter 6, reference 13); their exact weights
are not public.
"""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray

from fsm_calib.perception.chessboard import as_gray
from fsm_calib.types import FloatArray

_BLOCK = 8
_MAD_TO_SIGMA = 0.6745  # median absolute value of a unit normal variable
_ROUNDING = 1.0 / 12.0  # variance of rounding to whole grey levels; weaker detail is none


@lru_cache(maxsize=1)
def _dct_matrix() -> NDArray[np.float32]:
    return np.asarray(cv2.dct(np.eye(_BLOCK, dtype=np.float32), flags=cv2.DCT_ROWS).T, dtype=np.float32)


@lru_cache(maxsize=1)
def _scales() -> tuple[NDArray[np.bool_], NDArray[np.bool_], NDArray[np.bool_]]:
    """Return which coefficients are coarse, fine, and noise, each (8, 8)."""
    u, v = np.mgrid[0:_BLOCK, 0:_BLOCK]
    m = np.maximum(u, v)
    fine = ((m == 2) | (m == 3)) | ((m >= 4) & (u + v <= _BLOCK))
    return m == 1, fine, (u >= 6) & (v >= 6)


def block_dct(gray: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Return the orthonormal DCT of every whole 8x8 block, shape (rows, columns, 8, 8)."""
    height, width = (side // _BLOCK * _BLOCK for side in gray.shape)
    blocks = gray[:height, :width].astype(np.float32)
    blocks = blocks.reshape(height // _BLOCK, _BLOCK, width // _BLOCK, _BLOCK).transpose(0, 2, 1, 3)
    transform = _dct_matrix()
    return transform @ np.ascontiguousarray(blocks) @ transform.T


def sharpness(image: NDArray[np.uint8]) -> float:
    """Return the sharpness F [1] of a grey or BGR image: 0 for no detail, rising as the focus sharpens."""
    coefficients = block_dct(as_gray(image))
    coarse, fine, noisy = _scales()
    noise = (float(np.median(np.abs(coefficients[..., noisy]))) / _MAD_TO_SIGMA) ** 2
    energy: FloatArray = np.mean(np.square(coefficients), axis=(0, 1), dtype=np.float64)
    strong = float(energy[coarse].sum()) - noise * int(coarse.sum())
    weak = float(energy[fine].sum()) - noise * int(fine.sum())
    return max(weak, 0.0) / strong if strong > _ROUNDING * int(coarse.sum()) else 0.0
