"""The lens: projection with derivatives, its inverse, and whether it folds inside the image.

One vector of 12 intrinsics serves plumb_bob and rational_polynomial: fx, fy, cx, cy [px], k1, k2, p1, p2, k3, k4, k5,
k6 [1] (the last three zero for plumb_bob); one of 8 is an equidistant lens (`equidistant`), whose factor c is another
and which has no p1, p2. With x = X/Z, y = Y/Z, r2 = x^2 + y^2::

    c  = (1 + k1 r2 + k2 r2^2 + k3 r2^3) / (1 + k4 r2 + k5 r2^2 + k6 r2^3)
    u  = fx (c x + 2 p1 x y + p2 (r2 + 2 x^2)) + cx
    v  = fy (c y + p1 (r2 + 2 y^2) + 2 p2 x y) + cy

Source: OpenCV, "Camera Calibration and 3D Reconstruction" (same symbols); Brown, Close-range camera
calibration, 1971.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from fsm_calib.perception import equidistant
from fsm_calib.types import CameraModel, FloatArray

INTRINSICS = ("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")
#: which of the 12 intrinsics a model with so many distortion coefficients frees
FREE_OF_COEFFICIENTS = {4: tuple(range(8)), 5: tuple(range(9)), 8: tuple(range(12))}
_NEAREST_DEPTH = 1e-3  # m; a point nearer (or behind) is moved here so that a wild step stays finite
_WIDEST_RADIUS = 20.0  # 1; tangent of 87 deg, the end of the search for a lens's radius
_LONGEST_STEP = 0.3  # 1; a Newton step of `unproject` near a fold goes no farther
_INVERSE_STEPS = 20  # Newton steps of `unproject`; it converges in 4 to 6
_RADIUS_STEPS = 4000  # samples of the radial curve up to _WIDEST_RADIUS, 0.005 apart


def intrinsics_vector(camera: CameraModel) -> FloatArray:
    """Return the intrinsics of `camera`: 8 of an equidistant lens, else 12, zeros where its model has none."""
    vector = np.zeros(equidistant.SIZE if camera.model == "equidistant" else 12)
    vector[:4] = camera.matrix[0, 0], camera.matrix[1, 1], camera.matrix[0, 2], camera.matrix[1, 2]
    vector[4 : 4 + camera.distortion.size] = camera.distortion
    return vector


def camera_model(vector: FloatArray, image_size: tuple[int, int]) -> CameraModel:
    """Return the camera with 12 or 8 intrinsics `vector` and `image_size` (width, height) [px]."""
    matrix = np.array([[vector[0], 0.0, vector[2]], [0.0, vector[1], vector[3]], [0.0, 0.0, 1.0]])
    if is_equidistant(vector):
        return CameraModel(matrix, vector[4:8], *image_size, "equidistant")
    if np.any(vector[9:] != 0.0):
        return CameraModel(matrix, vector[4:12], *image_size, "rational_polynomial")
    return CameraModel(matrix, vector[4:9], *image_size, "plumb_bob")


def is_equidistant(vector: FloatArray) -> bool:
    """Return whether intrinsics are those of an equidistant lens."""
    return vector.size == equidistant.SIZE


def names_of(vector: FloatArray) -> tuple[str, ...]:
    """Return the names of intrinsics in their order."""
    return equidistant.INTRINSICS if is_equidistant(vector) else INTRINSICS


def radial_factor(vector: FloatArray, r2: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the factor c, dc/dr2 and the denominator at squared radii `r2` [1], each of the shape of
    `r2`.
    """
    factor, below = _factor(vector, r2)
    return factor, _slope(vector, r2, factor, below), below


def _factor(vector: FloatArray, r2: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the factor c and its denominator (1 for an equidistant lens)."""
    if is_equidistant(vector):
        return equidistant.factor(vector, r2), np.ones_like(r2)
    k1, k2, _, _, k3, k4, k5, k6 = vector[4:12].tolist()
    above = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))
    below = 1.0 + r2 * (k4 + r2 * (k5 + r2 * k6))
    return above / below, below


def _slope(vector: FloatArray, r2: FloatArray, factor: FloatArray, below: FloatArray) -> FloatArray:
    """Return dc/dr2."""
    if is_equidistant(vector):
        return equidistant.slope(vector, r2)
    k1, k2, _, _, k3, k4, k5, k6 = vector[4:12].tolist()
    slope = k1 + r2 * (2.0 * k2 + 3.0 * r2 * k3) - factor * (k4 + r2 * (2.0 * k5 + 3.0 * r2 * k6))
    return np.asarray(slope / below)


def distort(vector: FloatArray, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return distorted x, y [1] of rays x, y [1], in their shape."""
    return _distorted(vector, x, y, _factor(vector, x * x + y * y)[0])


def _tangential(vector: FloatArray) -> tuple[float, float]:
    """Return p1, p2; an equidistant lens has none."""
    return (0.0, 0.0) if is_equidistant(vector) else (float(vector[6]), float(vector[7]))


def _distorted(
    vector: FloatArray, x: FloatArray, y: FloatArray, factor: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return distorted x, y [1] of rays whose radial factor is known."""
    p1, p2 = _tangential(vector)
    distorted_x = factor * x + 2.0 * p1 * x * y + p2 * (3.0 * x * x + y * y)
    distorted_y = factor * y + p1 * (x * x + 3.0 * y * y) + 2.0 * p2 * x * y
    return distorted_x, distorted_y


def _by_ray(
    vector: FloatArray, x: FloatArray, y: FloatArray, factor: FloatArray, slope: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the derivative of distorted (x, y) by (x, y), which is symmetric: by x of x, of y, and by y of y."""
    p1, p2 = _tangential(vector)
    first = factor + 2.0 * slope * x * x + 2.0 * p1 * y + 6.0 * p2 * x
    cross = 2.0 * (slope * x * y + p1 * x + p2 * y)
    second = factor + 2.0 * slope * y * y + 6.0 * p1 * y + 2.0 * p2 * x
    return first, cross, second


def _perspective(points_camera: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    depth = np.maximum(points_camera[..., 2], _NEAREST_DEPTH)
    return points_camera[..., 0] / depth, points_camera[..., 1] / depth, depth


def project(vector: FloatArray, points_camera: FloatArray) -> FloatArray:
    """Return image points, shape (..., 2) [px], of `points_camera`, shape (..., 3) [m]."""
    x, y, _ = _perspective(points_camera)
    distorted_x, distorted_y = distort(vector, x, y)
    return np.stack([vector[0] * distorted_x + vector[2], vector[1] * distorted_y + vector[3]], axis=-1)


def project_with_derivatives(
    vector: FloatArray, points_camera: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return image points [px] and their derivatives by the point and by the intrinsics.

    Shapes: points_camera (..., 3) [m] -> (..., 2) [px], (..., 2, 3) [px/m], (..., 2, 12 or 8) [px per unit].
    """
    x, y, depth = _perspective(points_camera)
    factor, slope, _ = radial_factor(vector, x * x + y * y)
    distorted_x, distorted_y = _distorted(vector, x, y, factor)
    focal = vector[:2]
    image = np.stack([distorted_x, distorted_y], axis=-1) * focal + vector[2:4]
    by_ray = np.empty((*x.shape, 2, 2))
    first, cross, second = _by_ray(vector, x, y, factor, slope)
    by_ray[..., 0, 0], by_ray[..., 1, 1] = first, second
    by_ray[..., 0, 1] = by_ray[..., 1, 0] = cross
    by_ray = by_ray * focal[:, None]
    by_point = np.empty((*x.shape, 2, 3))
    by_point[..., :2] = by_ray / depth[..., None, None]
    by_point[..., 2] = -(by_ray[..., 0] * x[..., None] + by_ray[..., 1] * y[..., None]) / depth[..., None]
    return image, by_point, _by_intrinsics(vector, x, y, distorted_x, distorted_y)


def _by_intrinsics(
    vector: FloatArray, x: FloatArray, y: FloatArray, distorted_x: FloatArray, distorted_y: FloatArray
) -> FloatArray:
    r2 = x * x + y * y
    result = np.zeros((*x.shape, 2, vector.size))
    result[..., 0, 0], result[..., 1, 1] = distorted_x, distorted_y
    result[..., 0, 2] = result[..., 1, 3] = 1.0
    if is_equidistant(vector):
        ways = np.stack([vector[0] * x, vector[1] * y], axis=-1)
        result[..., 4:8] = ways[..., None] * equidistant.by_coefficients(r2)[..., None, :]
        return result
    factor, below = _factor(vector, r2)
    above_terms = np.stack([r2, r2**2, r2**3], axis=-1) / below[..., None]
    below_terms = -above_terms * factor[..., None]
    for row, (focal, ray) in enumerate(((vector[0], x), (vector[1], y))):
        result[..., row, [4, 5, 8]] = focal * ray[..., None] * above_terms
        result[..., row, 9:12] = focal * ray[..., None] * below_terms
    result[..., 0, 6], result[..., 1, 6] = vector[0] * 2.0 * x * y, vector[1] * (r2 + 2.0 * y * y)
    result[..., 0, 7], result[..., 1, 7] = vector[0] * (r2 + 2.0 * x * x), vector[1] * 2.0 * x * y
    return result


def unproject(vector: FloatArray, image: FloatArray) -> FloatArray:
    """Return the undistorted rays (x, y) = (X/Z, Y/Z), shape (..., 2) [1], of image points, shape (..., 2)
    [px].

    A radial table gives the start, Newton's method the rest. Points beyond the fold of a folding lens get the
    ray of the fold.
    """
    distorted = (np.asarray(image, dtype=float) - vector[2:4]) / vector[:2]
    wanted_x, wanted_y = np.ascontiguousarray(np.moveaxis(distorted, -1, 0))
    radius = np.sqrt(wanted_x * wanted_x + wanted_y * wanted_y)
    start = _undistorted_radius(vector, radius) / np.maximum(radius, 1e-12)
    x, y = wanted_x * start, wanted_y * start
    for _ in range(_INVERSE_STEPS):
        r2 = x * x + y * y
        factor, below = _factor(vector, r2)
        distorted_x, distorted_y = _distorted(vector, x, y, factor)
        error_x, error_y = distorted_x - wanted_x, distorted_y - wanted_y
        if float(np.max(np.maximum(np.abs(error_x), np.abs(error_y)), initial=0.0)) < 1e-10:
            break
        derivative = _by_ray(vector, x, y, factor, _slope(vector, r2, factor, below))
        step_x, step_y = _solve_2x2(*derivative, error_x, error_y)
        length = np.sqrt(step_x * step_x + step_y * step_y)
        share = np.minimum(1.0, _LONGEST_STEP / np.maximum(length, 1e-300))
        x, y = x - step_x * share, y - step_y * share
    return np.stack([x, y], axis=-1)


def _solve_2x2(
    first: FloatArray, cross: FloatArray, second: FloatArray, right_x: FloatArray, right_y: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the solutions of symmetric equations [[first, cross], [cross, second]] s = right, one an element."""
    determinant = first * second - cross * cross
    safe = np.where(np.abs(determinant) < 1e-6, 1e-6, determinant)
    return (second * right_x - cross * right_y) / safe, (first * right_y - cross * right_x) / safe


def _radial_curve(vector: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return radii and distorted radii [1] up to the first fold or pole; a lens in use is remembered."""
    return _radial_curve_of(tuple(vector.tolist()))


@lru_cache(maxsize=16)
def _radial_curve_of(intrinsics: tuple[float, ...]) -> tuple[FloatArray, FloatArray]:
    """Return the curve of `_radial_curve`; both arrays are read-only."""
    vector = np.array(intrinsics)
    radius = np.linspace(0.0, _WIDEST_RADIUS, _RADIUS_STEPS)
    factor, _, below = radial_factor(vector, radius * radius)
    distorted = radius * factor
    bad = (below <= 0.0) | (np.diff(distorted, prepend=-1.0) <= 0.0)
    end = int(np.argmax(bad)) if bool(np.any(bad)) else radius.size
    radius.setflags(write=False)
    distorted.setflags(write=False)
    return radius[:end], distorted[:end]


def _undistorted_radius(vector: FloatArray, distorted: FloatArray) -> FloatArray:
    radius, curve = _radial_curve(vector)
    return np.interp(distorted, curve, radius)


def is_sane_over_image(vector: FloatArray, image_size: tuple[int, int]) -> bool:
    """Tell whether the lens maps every pixel of the image to one ray: monotone radius, positive
    denominator.
    """
    width, height = image_size
    corners = np.array([[0, 0], [width - 1, 0], [0, height - 1], [width - 1, height - 1]], dtype=float)
    farthest = float(np.max(np.linalg.norm((corners - vector[2:4]) / vector[:2], axis=1)))
    _, curve = _radial_curve(vector)
    return bool(curve[-1] >= farthest) and max(map(abs, _tangential(vector))) < 0.2
