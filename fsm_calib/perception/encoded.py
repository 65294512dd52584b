"""Images as they travel: JPEG or PNG bytes to pixels."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray


def decode_image(data: bytes | NDArray[np.uint8]) -> NDArray[np.uint8] | None:
    """Return the grey image (height, width), 8 bits, of JPEG or PNG `data`; None if it is no image."""
    buffer = np.frombuffer(bytes(data), dtype=np.uint8)
    try:
        image = cv2.imdecode(buffer, cv2.IMREAD_GRAYSCALE) if buffer.size else None
    except cv2.error:  # more pixels than OpenCV unpacks, among others
        return None
    return None if image is None else np.asarray(image, dtype=np.uint8)


def decode_colour(data: bytes | NDArray[np.uint8]) -> NDArray[np.uint8] | None:
    """Return the BGR image (height, width, 3), 8 bits, of JPEG or PNG `data`; None if it is no image."""
    buffer = np.frombuffer(bytes(data), dtype=np.uint8)
    image = cv2.imdecode(buffer, cv2.IMREAD_COLOR) if buffer.size else None
    return None if image is None else np.asarray(image, dtype=np.uint8)


def encode_jpeg(image: NDArray[np.uint8], quality: int = 90) -> bytes:
    """Return `image`, 8 bits, grey or BGR, as JPEG bytes of `quality` 0 to 100."""
    return bytes(cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, quality])[1])
