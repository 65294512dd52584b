"""`fsm-calib calibrate-camera` and `fsm-calib focus`: the camera tool on a person's own photos."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fsm_calib.commands.files import check_places, tell_result, write_file
from fsm_calib.errors import DataError, InputError
from fsm_calib.types import BoardSpec

if TYPE_CHECKING:
    from fsm_calib.perception.calibration import CameraCalibration
    from fsm_calib.perception.photos import PhotoSet

_POLL = 0.2  # s between two looks into a folder that fills


def register(app: typer.Typer) -> None:
    """Add `calibrate-camera` and `focus` to the command line."""
    app.command("calibrate-camera")(calibrate_camera)
    app.command("focus")(focus)


def calibrate_camera(
    images: Annotated[
        list[Path], typer.Argument(help="Photos of one chessboard by one camera.", show_default=False)
    ],
    board: Annotated[
        list[str], typer.Option(help="Inner corners, COLUMNSxROWS.", metavar="9x6", show_default=False)
    ],
    square: Annotated[float, typer.Option(help="Side of a square [m]; it scales distances only.")] = 0.025,
    json_file: Annotated[
        Path | None, typer.Option("--json", help="Write the result as JSON; - for standard output.")
    ] = None,
    out: Annotated[Path | None, typer.Option(help="Write a camera_info YAML (ROS, Duckietown).")] = None,
    report: Annotated[
        Path | None, typer.Option(help="Write a page with the error map and residuals.")
    ] = None,
    name: Annotated[str, typer.Option(help="Name of the camera in the YAML.")] = "camera",
) -> None:
    """Calibrate a camera from photos and say how good the result is."""
    from fsm_calib.perception.intrinsics import calibrate
    from fsm_calib.perception.photos import find_in_photos

    spec = parse_board(board, square)
    check_places(json_file, out, report)
    photos = find_in_photos(images, spec)
    result = calibrate(photos.views, spec, photos.image_size)
    tell_result(result_json(result, photos), summary_text(result, photos, len(images)), json_file)
    if report is not None:
        _write_report(report, result, photos, spec)
    if result.refused:
        raise DataError(f"the calibration is refused: {result.reason}", cure="Take views of the whole image.")
    if out is not None:
        _write_camera_info(out, result, name)


def parse_board(texts: Sequence[str], square: float) -> BoardSpec:
    """Return the board of ``--board COLUMNSxROWS`` and ``--square``.

    Raises
    ------
    InputError
        More than one board, not of the form, smaller than 3x3, or no positive square.
    """
    if len(texts) > 1:
        raise InputError(
            f"{len(texts)} boards are given", where="--board", cure="Calibrate with one board at a time."
        )
    match = re.fullmatch(r"(\d+)[xX](\d+)", texts[0].strip())
    if match is None:
        raise InputError(
            f"{texts[0]!r} is no board", where="--board", cure="Expected COLUMNSxROWS, such as 9x6."
        )
    columns, rows = int(match[1]), int(match[2])
    if min(columns, rows) < 3:
        raise InputError(
            f"a board of {columns}x{rows} is too small", where="--board", cure="Use 3x3 or larger."
        )
    if not 0.0 < square < 10.0:
        raise InputError(f"a square of {square} m", where="--square", cure="Expected metres, such as 0.025.")
    return BoardSpec(columns, rows, square)


def summary_text(result: CameraCalibration, photos: PhotoSet, given: int) -> str:
    """Return what a person wants to know, some twenty lines."""
    from fsm_calib.report.camera_words import parameter_rows, verdict

    bars = result.coverage
    lines = [
        f"boards found        {len(photos.views)} of {given}, {result.views_used} used",
        f"lens model          {result.camera.model}",
        f"rms                 {result.rms_px:.3f} px",
        f"mean, the paper's   {result.mean_px:.3f} px, {result.paper_px:.4f} px",
        f"cross-validated     {result.cross_validated_px:.3f} px   on views left out",
        f"predicted error     {result.predicted_px:.2f} px   at most {result.predicted_map.max:.2f}",
        f"coverage            X {bars.x:.0%}  Y {bars.y:.0%}  size {bars.size:.0%}  skew {bars.skew:.0%}",
    ]
    lines += [f"  {name:<4}{value:>12} +- {deviation}" for name, value, deviation in parameter_rows(result)]
    for trial in result.models:
        errors = f"{trial.rms_px:.3f} rms, {trial.cross_validated_px:.3f} left out,"
        errors += f" {trial.predicted_px:.2f} predicted"
        lines.append(f"{trial.coefficients} coefficients      {errors}: {trial.verdict}")
    dropped = (*photos.dropped, *result.views_dropped)
    lines += [f"left out            {view.source}: {view.reason}" for view in dropped]
    return "\n".join([*lines, verdict(result)])


def result_json(result: CameraCalibration, photos: PhotoSet) -> dict[str, Any]:
    """Return the camera with what became of each photo."""
    from fsm_calib.perception.camera_files import calibration_json

    data = calibration_json(result)
    dropped = [{"file": drop.source, "reason": drop.reason} for drop in photos.dropped]
    data["views_dropped"] = dropped + data["views_dropped"]
    data["boards_found"] = len(photos.views)
    return data


def _write_report(report: Path, result: CameraCalibration, photos: PhotoSet, spec: BoardSpec) -> None:
    from fsm_calib.perception.photos import read_photo
    from fsm_calib.report.camera_report import camera_report

    source = photos.views[0].source
    example = (Path(source).name, read_photo(Path(source), colour=True))
    write_file(report, camera_report(result, photos.views, spec, example))


def _write_camera_info(out: Path, result: CameraCalibration, name: str) -> None:
    from fsm_calib.perception.camera_files import write_intrinsics

    comment = (
        f"rms {result.rms_px:.3f} px, on views left out {result.cross_validated_px:.3f} px, "
        f"predicted over the image {result.predicted_px:.2f} px, {result.views_used} views"
    )
    write_intrinsics(out, result.camera, name, comment)


def focus(
    images: Annotated[list[Path], typer.Argument(help="Photos, or one folder.", show_default=False)],
    watch: Annotated[
        float, typer.Option(help="With a folder: wait this long [s] for each new photo.", show_default=False)
    ] = 0.0,
) -> None:
    """Tell the sharpness of each photo and the best so far; with --watch, of a folder that fills."""
    from fsm_calib.perception.focus import read_focus
    from fsm_calib.perception.photos import read_photo
    from fsm_calib.perception.sharpness import sharpness

    values: list[float] = []
    best = ""
    for path in photo_stream(images, watch):
        values.append(sharpness(read_photo(path)))
        reading = read_focus(values)
        best = path.name if reading.best_index == len(values) - 1 else best
        bar = "#" * round(30.0 * reading.share)
        typer.echo(
            f"{path.name:<28} {reading.value:7.4f}  best {reading.best:7.4f}  {bar:<30} {reading.sentence}"
        )
    if not values:
        raise DataError("no photo was found", cure="Give photos, or a folder that holds some.")
    typer.echo(f"best: {best} ({max(values):.4f})")


def photo_stream(images: Sequence[Path], watch: float) -> Iterator[Path]:
    """Yield photos: the files given, or those of one folder, and for `watch` [s] after each the new ones.

    Raises
    ------
    InputError
        A folder among several arguments.
    """
    from fsm_calib.perception.photos import photos_in

    if len(images) != 1 or not images[0].is_dir():
        for path in images:
            if path.is_dir():
                raise InputError(
                    "is a folder among files", where=str(path), cure="Give one folder alone, or files."
                )
            yield path
        return
    seen: set[Path] = set()
    last = time.monotonic()
    while True:
        for path in photos_in(images[0]):
            if path not in seen:
                seen.add(path)
                yield path
                last = time.monotonic()
        if time.monotonic() - last >= watch:
            return
        time.sleep(_POLL)
