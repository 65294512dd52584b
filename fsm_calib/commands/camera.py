"""`fsm-calib calibrate-camera` and `fsm-calib focus`: the camera tool on a person's own photos."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import typer

from fsm_calib.commands.camera_compare import compare_cameras
from fsm_calib.commands.camera_options import (
    BOARD_KINDS,
    USUAL_FORM,
    USUAL_NAME,
    BoardOption,
    CoefficientsOption,
    DictionaryOption,
    GapOption,
    KindOption,
    MarkerOption,
    SquareOption,
    camera_writer,
    parse_request,
    refuse_unwritten,
    solve_settings,
)
from fsm_calib.commands.files import check_places, tell_result, write_file
from fsm_calib.commands.options import JsonOption
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
        list[Path] | None,
        typer.Argument(
            metavar="IMAGE", help="Photos, folders or videos of one board by one camera.", show_default=False
        ),
    ] = None,
    board: BoardOption = None,
    square: SquareOption = 0.025,
    kind: KindOption = BOARD_KINDS[0],
    marker: MarkerOption = None,
    dictionary: DictionaryOption = None,
    gap: GapOption = None,
    coefficients: CoefficientsOption = None,
    json_file: JsonOption = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the camera as YAML, in the form of --format.")
    ] = None,
    form: Annotated[
        str | None,
        typer.Option(
            "--format", metavar="FORM", help="With --out: ros, duckietown, opencv or kalibr (default: ros)."
        ),
    ] = None,
    report: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write a page with the error map and residuals.")
    ] = None,
    name: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="With --out: name of the camera in the YAML (default: camera)."),
    ] = None,
    compare: Annotated[
        tuple[Path, Path] | None,
        typer.Option(metavar="A.yaml B.yaml", help="Compare two cameras' files instead.", show_default=False),
    ] = None,
) -> None:
    """Calibrate a camera from photos and say how good the result is."""
    refuse_unwritten(out, form, name, compares=compare is not None)
    if compare is not None:
        compare_cameras(*compare, json_file, report)
        return
    from fsm_calib.perception.intrinsics import calibrate
    from fsm_calib.perception.photo_sources import photo_files
    from fsm_calib.perception.photos import find_in_photos

    if not images or not board:
        raise InputError("photos and --board are needed", cure="For example: photos/ --board 9x6.")
    asked = parse_request(board, square, kind, marker, gap, dictionary)
    spec = asked.spec()
    finder = None if asked.kind == "chessboard" else asked.finder()
    settings = solve_settings(coefficients)
    write = camera_writer(form or USUAL_FORM)
    check_places(json_file, out, report)
    photos = find_in_photos(photo_files(images), spec, finder=finder)
    result = calibrate(photos.views, spec, photos.image_size, may_be_bent=True, settings=settings)
    given = len(photos.views) + len(photos.dropped)
    tell_result(result_json(result, photos), summary_text(result, photos, given), json_file)
    if report is not None:
        _write_report(report, result, photos, spec)
    if result.refused:
        raise DataError(f"the calibration is refused: {result.reason}", cure="Take views of the whole image.")
    if out is not None:
        write_file(out, write(result.camera, name or USUAL_NAME, _origin(result)))


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
        f"predicted error     {result.predicted_px:.2f} px   95 of 100 such calibrations are within it; "
        f"where it is worst {result.predicted_map.max:.2f}",
        f"coverage            X {bars.x:.0%}  Y {bars.y:.0%}  size {bars.size:.0%}  skew {bars.skew:.0%}",
    ]
    lines += [f"  {name:<4}{value:>12} +- {deviation}" for name, value, deviation in parameter_rows(result)]
    for trial in result.models:
        errors = f"{trial.rms_px:.3f} rms, {trial.cross_validated_px:.3f} left out,"
        errors += f" {trial.predicted_px:.2f} predicted"
        lines.append(f"{trial.name:20s} {errors}: {trial.verdict}")
    if result.board_warp is not None:
        warp = result.board_warp
        lines.append(
            f"the board is bent   {1e3 * warp.across:+.2f} mm across, {1e3 * warp.along:+.2f} mm along"
        )
    lines += [
        f"take again          {photos.views[result.used[view]].source}: {result.view_rms[view]:.2f} px, "
        f"the median photo {np.median(result.view_rms):.2f} px"
        for view in result.worst_views
    ]
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
    data["views"] = [
        {
            "file": photos.views[index].source,
            "rms_px": float(rms),
            "corners": int(np.isfinite(residuals[:, 0]).sum()),
            "retake": view in result.worst_views,
        }
        for view, (index, rms, residuals) in enumerate(
            zip(result.used, result.view_rms, result.residuals, strict=True)
        )
    ]
    return data


def _write_report(report: Path, result: CameraCalibration, photos: PhotoSet, spec: BoardSpec) -> None:
    from fsm_calib.perception.photos import read_source
    from fsm_calib.report.camera_report import camera_report

    source = photos.views[0].source
    example = (Path(source).name, read_source(source))
    write_file(report, camera_report(result, photos.views, spec, example, read_source))


def _origin(result: CameraCalibration) -> str:
    """Return where a camera file's numbers come from, for its head."""
    return (
        f"rms {result.rms_px:.3f} px, on views left out {result.cross_validated_px:.3f} px, "
        f"predicted over the image {result.predicted_px:.2f} px, {result.views_used} views"
    )


def focus(
    images: Annotated[
        list[Path], typer.Argument(metavar="IMAGE", help="Photos, or one folder.", show_default=False)
    ],
    watch: Annotated[
        float,
        typer.Option(
            metavar="SECONDS",
            help="With a folder: wait this long [s] for each new photo.",
            show_default=False,
        ),
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
