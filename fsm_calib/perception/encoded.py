"""Images as they travel: JPEG or PNG bytes to pixels, and pixels to JPEG or a film."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
CHUNK_FRAME = 12  # bytes of a PNG chunk beside its content: length, type, checksum


def decoded(data: bytes | NDArray[np.uint8], flags: int) -> NDArray[np.uint8] | None:
    """Return the pixels of an image file's bytes, as OpenCV's `flags` say; None if it is no whole image.

    A PNG with a chunk longer than the file is none: OpenCV would first reserve the length that the chunk claims,
    up to 4 GiB (PNG specification, third edition, section 5.3).
    """
    buffer = np.frombuffer(bytes(data), dtype=np.uint8)
    if not buffer.size or _claims_too_much(bytes(data)):
        return None
    try:
        image = cv2.imdecode(buffer, flags)
    except cv2.error:  # more pixels than OpenCV unpacks, among others
        return None
    return None if image is None else np.asarray(image, dtype=np.uint8)


def _claims_too_much(data: bytes) -> bool:
    """Return whether a PNG's chunk says that it is longer than the file."""
    place = len(PNG_SIGNATURE)
    if not data.startswith(PNG_SIGNATURE):
        return False
    while place + CHUNK_FRAME <= len(data):
        place += CHUNK_FRAME + int.from_bytes(data[place : place + 4], "big")
    return place > len(data)


def decode_image(data: bytes | NDArray[np.uint8]) -> NDArray[np.uint8] | None:
    """Return the grey image (height, width), 8 bits, of JPEG or PNG `data`; None if it is no image."""
    return decoded(data, cv2.IMREAD_GRAYSCALE)


def decode_colour(data: bytes | NDArray[np.uint8]) -> NDArray[np.uint8] | None:
    """Return the BGR image (height, width, 3), 8 bits, of JPEG or PNG `data`; None if it is no image."""
    return decoded(data, cv2.IMREAD_COLOR)


def encode_jpeg(image: NDArray[np.uint8], quality: int = 90) -> bytes:
    """Return `image`, 8 bits, grey or BGR, as JPEG bytes of `quality` 0 to 100."""
    return bytes(cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, quality])[1])


def write_mp4(path: Path, images: Iterable[NDArray[np.uint8]], rate: float) -> None:
    """Write BGR images of one size, each (height, width, 3), as a film of `rate` images a second: VP9 in an MP4.

    Browsers and VLC play VP9; H.264 is not among what OpenCV's wheels may write.

    Raises
    ------
    OSError
        The file cannot be written, or this OpenCV has no VP9.
    """
    writer = None
    for image in images:
        if writer is None:
            size = (image.shape[1], image.shape[0])
            writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"vp09"), rate, size)
            if not writer.isOpened():
                raise OSError("OpenCV cannot write a film there")
        writer.write(np.ascontiguousarray(image))
    if writer is not None:
        writer.release()
