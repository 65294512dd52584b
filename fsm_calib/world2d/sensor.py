"""From light to a picture: defocus, vignetting, exposure noise and JPEG, as a small camera does them.

    luma = JPEG( round( g(u, v) * blur(light) + sqrt(read^2 + shot * level) * n ) )

with g the vignette (1 at the centre), blur a Gaussian of `defocus` [px], read [grey levels] and shot [grey
levels] the two noise parts and n a standard normal field, on the luma alone (what JPEG leaves of colour noise
is small). Assumes that averaging in grey levels is averaging of light (no gamma), which keeps edges in their
places. Colour is added afterwards at half the resolution, as JPEG keeps it.

The normal field is cut from a bank drawn once with a fixed seed: two windows at places that the frame's
generator draws are added, so that no two frames share a field and a frame costs microseconds of random
numbers.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from fsm_calib.types import CameraModel
from fsm_calib.world2d.scene import check_range
from fsm_calib.world2d.textures import Image

_BANK = 1024
"""Side of the bank of noise [px]."""


@dataclass(frozen=True, eq=False)
class Light:
    """What reaches the sensor: luma, uint8 (height, width); chroma, uint8 (half height, half width, 2) Cr and
    Cb.
    """

    luma: Image
    chroma: Image


@dataclass(frozen=True, slots=True)
class SensorSettings:
    """How the camera turns light into a file.

    Parameters
    ----------
    defocus : float
        Standard deviation of the blur [px]; 0.5 to 0.7 in focus.
    exposure : float
        Time the shutter is open [s]; Pi camera in "sports" mode, indoors: about 8 ms.
    read_noise : float
        Noise of reading out, standard deviation [grey levels].
    shot_noise : float
        Variance of the light's own noise for each grey level [grey levels].
    vignette : float
        Loss of light at the image's corners [1].
    brightness : float
        Scale of all light [1]; colours fade with it below 1.
    jpeg_quality : int
        Quality of the JPEG, 1 to 100 [1]; 0 leaves JPEG out.
    """

    defocus: float = 0.6
    exposure: float = 0.008
    read_noise: float = 1.2
    shot_noise: float = 0.02
    vignette: float = 0.25
    brightness: float = 1.0
    jpeg_quality: int = 90

    def __post_init__(self) -> None:
        """Refuse what no camera does."""
        check_range("defocus", self.defocus, 0.0, 20.0)
        check_range("exposure", self.exposure, 0.0, 1.0)
        check_range("read_noise", self.read_noise, 0.0, 60.0)
        check_range("shot_noise", self.shot_noise, 0.0, 10.0)
        check_range("vignette", self.vignette, 0.0, 0.95)
        check_range("brightness", self.brightness, 0.05, 3.0)
        check_range("jpeg_quality", self.jpeg_quality, 0, 100)


@lru_cache(maxsize=1)
def _noise_bank() -> NDArray[Any]:
    bank = np.random.default_rng(20260101).standard_normal((2 * _BANK, 2 * _BANK), dtype=np.float32)
    bank /= np.float32(math.sqrt(2.0))
    bank.setflags(write=False)
    return bank


def noise_field(shape: tuple[int, int], rng: np.random.Generator) -> NDArray[Any]:
    """Return a standard normal field of `shape` (height, width) at most 1024 x 1024: the sum of two windows
    of the bank.
    """
    bank = _noise_bank()
    tops, lefts = rng.integers(0, 2 * _BANK - shape[0], 2), rng.integers(0, 2 * _BANK - shape[1], 2)
    first, second = (bank[t : t + shape[0], x : x + shape[1]] for t, x in zip(tops, lefts, strict=True))
    return cv2.add(first, second[::-1])


@lru_cache(maxsize=32)
def _vignette(width: int, height: int, cx: float, cy: float, loss: float, brightness: float) -> NDArray[Any]:
    """Return the gain of every pixel, shape (height, width): brightness (1 - loss (r / corner)^2)."""
    v, u = np.mgrid[:height, :width].astype(np.float32)
    r2 = (u - cx) ** 2 + (v - cy) ** 2
    gain = brightness * (1.0 - loss * r2 / (0.25 * (width**2 + height**2)))
    gain = np.clip(gain, 0.0, None).astype(np.float32)
    gain.setflags(write=False)
    return gain


def expose(light: Light, camera: CameraModel, settings: SensorSettings, rng: np.random.Generator) -> Image:
    """Return the picture, uint8 (height, width, 3) BGR, that a camera takes of `light`."""
    luma = light.luma
    if settings.defocus > 0.0:
        side = 2 * math.ceil(3.0 * settings.defocus) + 1
        luma = cv2.GaussianBlur(luma, (side, side), settings.defocus)
    centre = float(camera.matrix[0, 2]), float(camera.matrix[1, 2])
    gain = _vignette(camera.width, camera.height, *centre, settings.vignette, settings.brightness)
    luma = cv2.multiply(luma, gain, dtype=cv2.CV_8U)
    if settings.read_noise > 0.0 or settings.shot_noise > 0.0:
        spread = cv2.LUT(luma, _noise_table(settings.read_noise, settings.shot_noise))
        luma = cv2.add(luma, cv2.multiply(spread, noise_field(luma.shape, rng)), dtype=cv2.CV_8U)
    if settings.jpeg_quality > 0:
        _, coded = cv2.imencode(".jpg", luma, [cv2.IMWRITE_JPEG_QUALITY, settings.jpeg_quality])
        luma = np.asarray(cv2.imdecode(coded, cv2.IMREAD_GRAYSCALE))
    chroma = _dimmed(light.chroma, settings.brightness)
    chroma = cv2.resize(chroma, (camera.width, camera.height), interpolation=cv2.INTER_LINEAR)
    return np.asarray(cv2.cvtColor(cv2.merge([luma, chroma]), cv2.COLOR_YCrCb2BGR))


def _dimmed(chroma: Image, brightness: float) -> Image:
    """Return the colours in a darker room, which fade with the light; in a brighter one they stay, as white is cut."""
    if brightness >= 1.0:
        return chroma
    return np.asarray(cv2.convertScaleAbs(chroma, alpha=brightness, beta=128.0 * (1.0 - brightness)))


@lru_cache(maxsize=32)
def _noise_table(read: float, shot: float) -> NDArray[Any]:
    """Return the noise's standard deviation [grey levels] at each of the 256 grey levels."""
    return np.sqrt(read**2 + shot * np.arange(256)).astype(np.float32)
