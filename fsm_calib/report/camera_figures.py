"""The figures of the camera report: where it is uncertain, where it is off, what the boards reached, what
it does.
"""

from __future__ import annotations

import base64
from collections.abc import Sequence

import numpy as np
from matplotlib.colors import LogNorm
from numpy.typing import NDArray

from fsm_calib.perception.calibration import CameraCalibration
from fsm_calib.perception.prediction import ImageError, image_grid
from fsm_calib.perception.undistort import as_png, undistorted
from fsm_calib.report.palette import BOARD_COLOURS
from fsm_calib.report.run_style import figure, svg
from fsm_calib.types import BoardView, FloatArray

_ARROW = 50.0  # residual arrows are drawn so many times their length


def error_map(error: ImageError, image_size: tuple[int, int], scale: str, label: str) -> str:
    """Return an error over the image as SVG [px]; `scale` names it beside the colours, `label` tells what is shown."""
    grid, (width, height) = error.grid, image_size
    with figure(5.2, 3.9) as fig:
        axes = fig.add_subplot()
        points = image_grid(image_size).reshape(*grid.shape, 2)
        levels = round_levels(grid)
        filled = axes.contourf(
            points[..., 0], points[..., 1], grid, levels=levels, norm=LogNorm(), extend="both"
        )
        axes.contour(points[..., 0], points[..., 1], grid, levels=levels, colors="white", linewidths=0.6)
        bar = fig.colorbar(filled, ax=axes, label=scale, shrink=0.85, ticks=levels)
        bar.ax.minorticks_off()
        bar.ax.set_yticklabels([f"{level:g}" for level in levels])
        axes.set(xlim=(0, width), ylim=(height, 0), xlabel="u [px]", ylabel="v [px]", aspect="equal")
        return svg(fig, label)


def round_levels(grid: FloatArray) -> list[float]:
    """Return round numbers (1, 2 or 5 times a power of ten) over the range of positive values, three and more.

    They are evenly spaced for the eye where an error is a tenth in the middle of an image and ten in its corners.
    """
    low, high = (float(np.percentile(np.maximum(grid, 1e-6), share)) for share in (1.0, 99.5))
    powers = range(int(np.floor(np.log10(low))) - 1, int(np.ceil(np.log10(high))) + 2)
    rounds = [float(f"{step}e{power}") for power in powers for step in (1, 2, 5)]
    first = max(index for index, level in enumerate(rounds) if level <= low)
    last = min(index for index, level in enumerate(rounds) if level >= high)
    return rounds[first : max(last, first + 2) + 1]


def residual_arrows(calibration: CameraCalibration, views: Sequence[BoardView]) -> str:
    """Return found corners with their residuals, 50 times enlarged, as SVG; `views` are those used."""
    camera = calibration.camera
    with figure(5.2, 3.9) as fig:
        axes = fig.add_subplot()
        for view, residuals in zip(views, calibration.residuals, strict=True):
            kept = np.isfinite(residuals).all(axis=1)
            corners, off = view.corners_image[kept], residuals[kept]
            colour = BOARD_COLOURS[view.board % len(BOARD_COLOURS)]
            axes.quiver(
                corners[:, 0], corners[:, 1], off[:, 0], off[:, 1], angles="xy", scale_units="xy",
                scale=1.0 / _ARROW, width=0.0018, color=colour, rasterized=len(views) > 40,
            )  # fmt: skip
        axes.set(
            xlim=(0, camera.width), ylim=(camera.height, 0), xlabel="u [px]", ylabel="v [px]", aspect="equal"
        )
        axes.set_title(f"residuals, {_ARROW:.0f} times enlarged", fontweight="normal")
        return svg(fig, "Reprojection residuals")


def reach(calibration: CameraCalibration, views: Sequence[BoardView]) -> str:
    """Return the outlines of the boards in the image as SVG."""
    camera = calibration.camera
    with figure(5.2, 3.9) as fig:
        axes = fig.add_subplot()
        for view in views:
            corners = view.corners_image
            colour = BOARD_COLOURS[view.board % len(BOARD_COLOURS)]
            axes.scatter(corners[:, 0], corners[:, 1], s=1.5, color=colour, linewidths=0, rasterized=True)
        axes.set(
            xlim=(0, camera.width), ylim=(camera.height, 0), xlabel="u [px]", ylabel="v [px]", aspect="equal"
        )
        return svg(fig, "Where the boards were in the image")


def coverage_bars(calibration: CameraCalibration) -> str:
    """Return Duckietown's four coverage bars as SVG."""
    bars = calibration.coverage
    with figure(5.2, 1.5) as fig:
        axes = fig.add_subplot()
        names, values = ("skew", "size", "Y", "X"), (bars.skew, bars.size, bars.y, bars.x)
        colours = ["#2a9d5c" if value >= 1.0 else "#e08214" for value in values]
        axes.barh(names, values, color=colours, height=0.6)
        for row, value in enumerate(values):
            axes.text(value + 0.01, row, f"{100.0 * value:.0f} %", va="center", fontsize=8)
        axes.set(xlim=(0.0, 1.12), xticks=[])
        return svg(fig, "Coverage bars")


def lens_curve(calibration: CameraCalibration) -> str:
    """Return how far the lens moves a point from the pinhole's place against its angle, as SVG."""
    from fsm_calib.perception.lens import intrinsics_vector, radial_factor

    camera = calibration.camera
    vector = intrinsics_vector(camera)
    corner = np.hypot(camera.width / 2.0, camera.height / 2.0)
    radius = np.linspace(0.0, 3.0, 600)
    factor, _, _ = radial_factor(vector, radius**2)
    image_radius = camera.matrix[0, 0] * radius * factor
    inside = (image_radius <= corner) & (np.cumsum(np.diff(image_radius, prepend=-1.0) <= 0.0) == 0)
    with figure(5.2, 2.6) as fig:
        axes = fig.add_subplot()
        degrees = np.degrees(np.arctan(radius[inside]))
        axes.plot(degrees, image_radius[inside], color="#2b7bba", label="this lens")
        axes.plot(
            degrees,
            camera.matrix[0, 0] * radius[inside],
            color="#9aa0a6",
            label="without distortion",
            ls="--",
        )
        axes.set(
            xlabel="angle from the optical axis [deg]",
            ylabel="distance in the image [px]",
            ylim=(0, 1.1 * corner),
        )
        axes.legend(fontsize=8)
        return svg(fig, "Lens curve")


def undistorted_view(calibration: CameraCalibration, image: NDArray[np.uint8]) -> tuple[str, str]:
    """Return the photo as it is and undistorted, each as a data URI of a PNG."""
    return _data_uri(image), _data_uri(undistorted(image, calibration.camera))


def _data_uri(image: NDArray[np.uint8]) -> str:
    return "data:image/png;base64," + base64.b64encode(as_png(image)).decode("ascii")
