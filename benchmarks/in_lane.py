"""A worn robot passes the marked lane section once: is k back, and is it left alone when nothing has worn?

    python benchmarks/in_lane.py [--robots 20] [--drift 0.04]

Each robot of the fleet starts in the lane before the section, with what a calibration leaves: the camera within
0.2 px, tilt within 0.15 deg, yaw within 0.6 deg, k within 0.1 % of what was true before the wear. Its true wheel
ratio has then drifted by `drift`, up for even and down for odd seeds.
"""

from __future__ import annotations

import argparse
import json
import math

import cv2
import numpy as np
import trial
from trial import Trial, drive_machine

from fsm_calib.actions import ActionSettings, Bench
from fsm_calib.machines.limits import Limits
from fsm_calib.machines.runtime import CalibrationMachine
from fsm_calib.perception.fleet_camera import fleet_camera
from fsm_calib.types import CameraModel, Pose2
from fsm_calib.world2d.deviation import straight_deviation
from fsm_calib.world2d.fleet import draw_robot
from fsm_calib.world2d.layout import calibration_area
from fsm_calib.world2d.robot import WorldSpec, make_world

BEFORE_SECTION = 0.75  # m before the first marker
CAMERA_SHARE = 0.01  # of the way from the true camera to the fleet's median: about 0.15 px


def pass_section(seed: int, drift: float) -> dict:
    """Return what one pass did to a robot whose ratio drifted by `drift`."""
    cv2.setNumThreads(1)
    scene, rng = calibration_area(), np.random.default_rng([seed, 7])
    fresh = draw_robot(np.random.default_rng(seed))
    signed = drift if seed % 2 == 0 else -drift
    worn = trial.replace(fresh, wheel_ratio=fresh.wheel_ratio * (1.0 + signed))
    road = scene.road
    y = road.start.y + road.first_marker - BEFORE_SECTION
    start = Pose2(road.start.x + rng.normal(0, 0.02), y, math.pi / 2 + rng.normal(0, 0.05))
    world = make_world(WorldSpec(robot=worn, scene=scene, seed=seed, start=start))
    settings = ActionSettings()
    settings = trial.replace(settings, marker=trial.replace(settings.marker, lane_first=road.first_id))
    bench = Bench(world.robot, settings)
    know(bench, fresh, rng)
    machine = CalibrationMachine(Limits(markers=road.markers), ("lane",))
    result = drive_machine(Trial(seed), world, machine, bench)
    before = fresh.wheel_ratio if bench.notebook.lane_before is None else bench.notebook.lane_before
    result["deviation_before"] = straight_deviation(world.truth.parameters, before)
    return result


def know(bench: Bench, robot: object, rng: np.random.Generator) -> None:
    """Give the bench what an earlier calibration left."""
    notebook, median, true = bench.notebook, fleet_camera(), robot.camera
    mixed = [(1 - CAMERA_SHARE) * a + CAMERA_SHARE * b for a, b in
             ((true.matrix, median.matrix), (true.distortion, median.distortion))]  # fmt: skip
    notebook.camera = CameraModel(*mixed)
    tilt, yaw = np.radians(0.1), np.radians(0.5)
    notebook.mount = trial.replace(
        robot.mount,
        forward=0.07,
        left=0.0,
        pitch=robot.mount.pitch + rng.normal(0, tilt),
        roll=robot.mount.roll + rng.normal(0, tilt),
        yaw=robot.mount.yaw + rng.normal(0, yaw),
    )
    notebook.mount_known = "all"
    notebook.wheel_ratio = robot.wheel_ratio * (1.0 + rng.normal(0.0, 0.001))
    notebook.speed = 0.147 * robot.speed


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--robots", type=int, default=20)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--drift", type=float, nargs="*", default=[0.04, 0.02, 0.0])
    parser.add_argument("--json", default="")
    arguments = parser.parse_args()
    rows = []
    print("drift  finished  applied  |deviation| before  after: median  max [m]")
    for drift in arguments.drift:
        results = [
            pass_section(seed, drift) for seed in range(arguments.first, arguments.first + arguments.robots)
        ]
        done = [r for r in results if r["state"] == "done"]
        after, before = (np.abs([r[name] for r in done]) for name in ("deviation", "deviation_before"))
        applied = sum(r["applied"] for r in done)
        print(
            f"{drift:5.3f}  {len(done):3d}/{len(results)}     {applied:3d}      {np.median(before):.3f}"
            f"              {np.median(after):.3f}  {after.max():.3f}",
            flush=True,
        )
        for r in results:
            if r["state"] != "done":
                print("   seed", r["seed"], r["state"], "from", r["from"], flush=True)
        rows += [r | {"drift": drift} for r in results]
    if arguments.json:
        with open(arguments.json, "w", encoding="utf-8") as file:
            json.dump(rows, file)


if __name__ == "__main__":
    main()
