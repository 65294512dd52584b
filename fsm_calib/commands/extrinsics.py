"""`fsm-calib calibrate-extrinsics`: where the camera sits, from one photo of a chessboard on the floor."""

from __future__ import annotations

import math
from dataclasses import asdict
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fsm_calib.commands.camera_options import parse_board
from fsm_calib.commands.files import check_places, tell_result
from fsm_calib.commands.options import JsonOption
from fsm_calib.errors import InputError

if TYPE_CHECKING:
    from fsm_calib.perception.extrinsics import Extrinsics
    from fsm_calib.types import CameraModel, FloatArray


def register(app: typer.Typer) -> None:
    """Add `calibrate-extrinsics` to the command line."""
    app.command("calibrate-extrinsics")(calibrate_floor)


def calibrate_floor(
    image: Annotated[
        Path,
        typer.Argument(metavar="IMAGE", help="A photo, not rectified, of a board flat on the floor ahead."),
    ],
    camera: Annotated[
        Path, typer.Option(metavar="FILE", help="The camera_info YAML of the camera.", show_default=False)
    ],
    board: Annotated[list[str], typer.Option(help="Inner corners: across x ahead.", metavar="7x5")] = ["7x5"],  # noqa: B006
    square: Annotated[float, typer.Option(metavar="METRES", help="Side of a square [m].")] = 0.031,
    offset: Annotated[
        tuple[float, float],
        typer.Option(
            help="From the axle's middle to the board's near right corner: ahead, left [m].", metavar="X Y"
        ),
    ] = (0.16, -0.124),
    json_file: JsonOption = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write Duckietown's extrinsic YAML.")
    ] = None,
) -> None:
    """Tell where the camera sits and where it looks, from one photo of a board on the floor."""
    from fsm_calib.perception.camera_files import read_intrinsics, read_projection, write_extrinsics
    from fsm_calib.perception.extrinsics import calibrate_extrinsics
    from fsm_calib.perception.photos import read_photo

    spec = parse_board(board, square)
    check_places(json_file, out)
    model, projection, photo = read_intrinsics(camera), read_projection(camera), read_photo(image)
    if photo.shape != (model.height, model.width):
        raise InputError(
            f"is {photo.shape[1]}x{photo.shape[0]} px, but the camera file is for {model.width}x{model.height} px",
            where=str(image),
            cure="Give the file of this camera at this size.",
        )
    found = calibrate_extrinsics(photo, spec, model, offset, projection)
    if out is not None:
        write_extrinsics(out, found.homography, date.today().isoformat())
    tell_result(extrinsics_json(found), extrinsics_text(found, model, projection), json_file)


def extrinsics_json(found: Extrinsics) -> dict[str, Any]:
    """Return the result as plain values: m, rad, px."""
    return {
        "principal_point_reach": found.principal_point_reach,
        "axis_reach": found.axis_reach,
        "mount": asdict(found.mount),
        "homography": found.homography.tolist(),
        "rms_px": found.rms_px,
    }


def extrinsics_text(found: Extrinsics, camera: CameraModel, projection: FloatArray) -> str:
    """Return what a person wants to know; first what can be held against a tape measure."""
    mount = found.mount
    angles = ", ".join(f"{math.degrees(angle):.2f}" for angle in (mount.pitch, mount.roll, mount.yaw))
    return "\n".join(
        [
            f"principal point     meets the floor {found.principal_point_reach:.4f} m ahead of the axle (1)",
            f"optical axis        meets the floor {found.axis_reach:.4f} m ahead of the axle (2)",
            f"camera              {mount.height:.4f} m above the floor, {mount.forward:.3f} m ahead of the axle, "
            f"{mount.left:+.3f} m to the left",
            f"pitch, roll, yaw    {angles} deg",
            f"fit                 {found.rms_px:.2f} px rms",
            *_explained(camera, projection),
        ]
    )


def _explained(camera: CameraModel, projection: FloatArray) -> list[str]:
    """Return what the two points on the floor are, so that each can be found with a tape measure."""
    u, v = camera.matrix[:2, 2]
    centre_u, centre_v = projection[:2, 2]
    return [
        f"(1) To compare with a tape measure: the floor at the pixel ({u:.1f}, {v:.1f}) of the rectified image, which",
        "    Duckietown's software calls the principal point.",
        f"(2) The lens's own direction: the floor at the pixel ({u:.1f}, {v:.1f}) of the photo itself, which is",
        f"    ({centre_u:.1f}, {centre_v:.1f}) in the rectified image.",
    ]
