"""A run as a film: what the robot saw on the left, where it was on the right, what it did below; MP4 or GIF."""

from __future__ import annotations

import io
from bisect import bisect_right
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from fsm_calib.errors import InputError
from fsm_calib.perception.encoded import write_mp4
from fsm_calib.report.palette import INK, TEXT
from fsm_calib.report.plot import Axes, Box
from fsm_calib.report.plot_scale import limits
from fsm_calib.report.run_plan import LABEL, draw_scene, draw_track
from fsm_calib.report.run_replay import BODY, SMALLEST
from fsm_calib.runner.record import RunRecord
from fsm_calib.types import FloatArray, Pose2
from fsm_calib.world2d.outlines import scene_corners

SIZE = (960, 464)
CAMERA = (0, 0, 512, 384)
PLAN = Box(536.0, 16.0, 408.0, 356.0)
WORDS = (16, 394)
"""Size of the picture, the camera's part of it, the plan's and where the words begin [px]."""
SECONDS = 24.0
"""Length of the film [s], however long the run was."""
RATES = {".mp4": 12.0, ".gif": 6.0}
"""Pictures in a second, by kind of file: a GIF keeps every one whole."""
FOUND = (0, 229, 255)
"""Colour of what was found in a frame, RGB."""


def movie_kind(path: Path) -> str:
    """Return the kind of film that a file's name asks for.

    Raises
    ------
    InputError
        It is none that can be written.
    """
    kind = path.suffix.lower()
    if kind not in RATES:
        raise InputError("no kind of film", where=str(path), cure=f"End the name in {' or '.join(RATES)}.")
    return kind


def write_movie(record: RunRecord, path: Path) -> None:
    """Write a finished run as an MP4 (VP9: browsers and VLC play it) or a GIF, by the end of the file's name.

    Raises
    ------
    InputError
        The name asks for another kind, the run has nothing to show, or the file cannot be written.
    """
    kind = movie_kind(path)
    if len(record.track) < 2 or not record.events:
        raise InputError("the run has no path to show", where=str(path))
    count = round(SECONDS * RATES[kind])
    pictures = _Film(record).pictures(np.linspace(0.0, float(record.events[-1]["time"]), count))
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if kind == ".mp4":
            write_mp4(path, (np.asarray(picture)[..., ::-1] for picture in pictures), RATES[kind])
        else:
            first, *others = (picture.quantize(128) for picture in pictures)
            wait = round(1000.0 / RATES[kind])
            first.save(path, save_all=True, append_images=others, duration=wait, loop=0)
    except OSError as error:
        raise InputError(f"cannot be written: {error.strerror or error}", where=str(path)) from error


class _Painted(Axes):
    """Axes whose shapes are painted on a picture, where those of a page are written as SVG."""

    def __init__(self, canvas: Image.Image, box: Box, xlim: Any, ylim: Any) -> None:
        super().__init__(box, xlim, ylim)
        self._draw = ImageDraw.Draw(canvas, "RGBA")

    def line(
        self, points: FloatArray, colour: str, width: float = 1.8, dash: str = "", label: str = ""
    ) -> None:
        """Paint a line through points, shape (n, 2) [m]."""
        self._draw.line(self.pixels(points), colour, round(width), joint="curve")

    def dots(
        self, points: FloatArray, colour: str, size: float = 3.0, opacity: float = 1.0, label: str = ""
    ) -> None:
        """Paint a dot of `size` [px] at each point, shape (n, 2) [m]."""
        for x, y in self.pixels(points):
            self._draw.ellipse((x - size / 2, y - size / 2, x + size / 2, y + size / 2), colour)

    def areas(
        self, shapes: Iterable[Any], fill: str, opacity: float = 1.0, edge: str = "none", label: str = ""
    ) -> None:
        """Paint polygons, each of shape (n, 2) [m]."""
        inside = f"{fill}{round(255 * opacity):02x}"
        for shape in shapes:
            self._draw.polygon(self.pixels(np.asarray(shape)), inside, None if edge == "none" else edge)

    def words(self, x: float, y: float, text: str, colour: str = TEXT) -> None:
        """Paint text that begins at a point [m]."""
        self._draw.multiline_text(
            self.pixels(np.array([(x, y)]))[0], text, colour, ImageFont.load_default(11)
        )

    def pixels(self, points: FloatArray) -> list[tuple[float, float]]:
        """Return points, shape (n, 2) [m], as places in the picture [px]."""
        points = np.asarray(points, dtype=float).reshape(-1, 2)
        return list(zip(self.x(points[:, 0]).tolist(), self.y(points[:, 1]).tolist(), strict=True))


class _Film:
    """The pictures of a run's film."""

    def __init__(self, record: RunRecord) -> None:
        self._record = record
        self._back = Image.new("RGB", SIZE, "#ffffff")
        corners = np.vstack([*scene_corners(record.scene), record.track[:, 1:3]])
        xlim, ylim = limits(corners[:, 0]), limits(corners[:, 1])
        xlim = (xlim[0], xlim[1] + LABEL)
        self._axes = _Painted(self._back, PLAN.shrunk(xlim, ylim), xlim, ylim)
        draw_scene(self._axes, record.scene)
        draw_track(self._axes, record, is_named=False, has_robot=False)
        self._ends = [float(event["time"]) for event in record.events]
        self._taken = [picture.time for picture in record.pictures]
        self._seen: tuple[int, Image.Image] = (-1, Image.new("RGB", CAMERA[2:], "#000000"))

    def pictures(self, times: NDArray[np.float64]) -> Iterator[Image.Image]:
        """Yield the picture at each time [s]."""
        for time in times.tolist():
            picture = self._back.copy()
            picture.paste(self._camera(time), CAMERA[:2])
            self._draw_robot(picture, time)
            self._write(ImageDraw.Draw(picture), time)
            yield picture

    def _camera(self, time: float) -> Image.Image:
        """Return the last kept frame, with what was found in it."""
        number = max(bisect_right(self._taken, time) - 1, 0)
        if self._taken and number != self._seen[0]:
            kept = self._record.pictures[number]
            content = (self._record.directory / kept.file).read_bytes()
            frame = Image.open(io.BytesIO(content)).convert("RGB").resize(CAMERA[2:])
            draw, scale = ImageDraw.Draw(frame), CAMERA[2] / kept.width
            for x, y in kept.points:
                draw.circle((scale * x, scale * y), 3.0, outline=FOUND)
            self._seen = (number, frame)
        return self._seen[1]

    def _draw_robot(self, picture: Image.Image, time: float) -> None:
        """Paint the robot where it is, large enough to be seen."""
        track = self._record.track
        row = track[max(int(np.searchsorted(track[:, 0], time, side="right")) - 1, 0)]
        scale = abs(float(self._axes.x(1.0)) - float(self._axes.x(0.0)))
        size = max(1.0, SMALLEST / (0.1 * scale))
        here = Pose2(*row[1:4])
        corners = [here.then(Pose2(size * x, size * y)) for x, y in BODY]
        outline = self._axes.pixels(np.array([(corner.x, corner.y) for corner in corners]))
        ImageDraw.Draw(picture).polygon(outline, INK, "#ffffff")

    def _write(self, draw: ImageDraw.ImageDraw, time: float) -> None:
        """Write the state, the last sentence and the time."""
        last = bisect_right(self._ends, time) - 1
        events = self._record.events
        state = events[min(last + 1, len(events) - 1)]["path"].replace("/", " / ")
        left, top = WORDS
        draw.text((left, top), state, INK, ImageFont.load_default(18))
        draw.text((SIZE[0] - left, top), f"{time:.1f} s", INK, ImageFont.load_default(18), anchor="ra")
        said = "" if last < 0 else str(events[last]["sentence"])
        draw.text((left, top + 28), said[:120], TEXT, ImageFont.load_default(14))
