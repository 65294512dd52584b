"""Calibrate with mrcal from corners, for `camera_peers.py`: run by the Python that has mrcal.

Reads {"corners": (views, rows, columns, 2), "size": [width, height], "square": m, "model": "LENSMODEL_OPENCV4"} from
standard input; writes {"rms_px", "cross_validated_px", "predicted_px", "outliers", "seconds"} to standard output.
mrcal's figures are per coordinate; here they are per corner (times the root of two), as everywhere else in the table.
"""

import json
import sys
import time
from typing import Any

import mrcal
import numpy as np

GRID = (25, 19)  # as in `fsm_calib.perception.prediction`


def inputs(corners: np.ndarray, task: dict[str, Any]) -> dict[str, Any]:
    """Return the problem as mrcal wants it, started from its own seed."""
    views = len(corners)
    observations = np.concatenate([corners, np.ones((*corners.shape[:3], 1))], axis=-1)
    frame_camera = np.column_stack([np.arange(views), np.zeros(views)]).astype(np.int32)
    core, _, frames = mrcal.seed_stereographic(
        [task["size"]], task["size"][0], frame_camera, observations, task["square"]
    )
    distortion = mrcal.lensmodel_num_params(task["model"]) - 4
    return {
        "intrinsics": np.concatenate([core, np.full((1, distortion), 1e-6)], axis=1),
        "extrinsics_rt_fromref": np.zeros((0, 6)),
        "frames_rt_toref": frames,
        "points": None,
        "observations_board": observations,
        "indices_frame_camintrinsics_camextrinsics": np.column_stack(
            [frame_camera, np.full(views, -1)]
        ).astype(np.int32),
        "observations_point": None,
        "indices_point_camintrinsics_camextrinsics": None,
        "lensmodel": task["model"],
        "imagersizes": np.array([task["size"]], dtype=np.int32),
        "calobject_warp": np.zeros(2),
        "calibration_object_spacing": task["square"],
        "do_optimize_intrinsics_core": True,
        "do_optimize_extrinsics": True,
        "do_optimize_frames": True,
        "do_apply_regularization": True,
        "verbose": False,
    }


def solved(corners: np.ndarray, task: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the solved problem and mrcal's account of it: core first, then all with outliers left out."""
    problem = inputs(corners, task)
    for flags in (
        {"do_optimize_intrinsics_distortions": False, "do_optimize_calobject_warp": False},
        {"do_optimize_calobject_warp": False},
        {"do_apply_outlier_rejection": True, "do_optimize_calobject_warp": True},
    ):
        problem.update(
            {"do_optimize_intrinsics_distortions": True, "do_apply_outlier_rejection": False} | flags
        )
        stats = mrcal.optimize(**problem)
    return problem, stats


def left_out_error(corners: np.ndarray, view: int, task: dict[str, Any]) -> float:
    """Return the mean squared corner distance of one view under a lens and a board fitted without it [px^2]."""
    problem, _ = solved(np.delete(corners, view, axis=0), task)
    alone = inputs(corners[view : view + 1], task)
    alone |= {name: problem[name] for name in ("intrinsics", "calobject_warp")}
    fixed = ("intrinsics_core", "intrinsics_distortions", "calobject_warp")
    alone |= {f"do_optimize_{name}": False for name in fixed} | {"do_apply_outlier_rejection": False}
    alone["do_apply_regularization"] = False
    return 2.0 * float(mrcal.optimize(**alone)["rms_reproj_error__pixels"]) ** 2


def predicted(problem: dict[str, Any]) -> float:
    """Return the predicted error over the image for far points, root mean square [px]."""
    model = mrcal.cameramodel(optimization_inputs=problem, icam_intrinsics=0)
    width, height = problem["imagersizes"][0]
    grid = np.stack(
        np.meshgrid(np.linspace(0, width - 1, GRID[0]), np.linspace(0, height - 1, GRID[1])), axis=-1
    )
    rays = mrcal.unproject(np.ascontiguousarray(grid), *model.intrinsics(), normalize=True)
    spread = mrcal.projection_uncertainty(rays, model=model, atinfinity=True, what="rms-stdev")
    return float(np.sqrt(2.0 * np.mean(spread**2)))


def main() -> None:
    """Calibrate what standard input holds."""
    task = json.load(sys.stdin)
    corners = np.array(task["corners"], dtype=float)
    begun = time.process_time()
    problem, stats = solved(corners, task)
    seconds = time.process_time() - begun
    left_out = [left_out_error(corners, view, task) for view in range(len(corners))]
    result = {
        "rms_px": float(np.sqrt(2.0)) * float(stats["rms_reproj_error__pixels"]),
        "cross_validated_px": float(np.sqrt(np.mean(left_out))),
        "predicted_px": predicted(problem),
        "outliers": int(np.count_nonzero(problem["observations_board"][..., 2] < 0.0)),
        "seconds": seconds,
    }
    print(json.dumps(result))


if __name__ == "__main__":
    main()
