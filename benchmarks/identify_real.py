"""What `identify` finds on real robots against what their publishers found, row by row.

    python benchmarks/identify_real.py

Recordings: Censi et al. 2013 (DOI 10.1109/TRO.2012.2226380; two drives of a Khepera III and the three subsets of each,
every third row), a LEGO NXT and the Labyrinth robot (positions alone). They lie outside the repository, where
FSM_CALIB_SHARED points (../shared).
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import numpy as np

from fsm_calib.diagnosis.identify.identify import identify
from fsm_calib.recording import Recording, read_recording

ROOT = Path(os.environ.get("FSM_CALIB_SHARED", "../shared")) / "recordings"
NAMES = ("wheel_radius_left", "wheel_radius_right", "axle_length", "sensor.x", "sensor.y", "sensor.theta")
PUBLISHED = ("l_diam", "r_diam", "axle", "l_x", "l_y", "l_theta")
SUBSETS = ("_all", "_0", "_1", "_2")
POSITION_BARS = {"lego-nxt": 0.032, "labyrinth-uwb": 0.030}  # m, rms


def published(name: str, subset: str) -> tuple[np.ndarray, np.ndarray]:
    """Return values and standard deviations of Censi et al. in the order of NAMES (m, rad)."""
    results = json.loads((ROOT / "khepera3" / f"{name}_published_results.json").read_text())[subset]
    values = np.array([results[key] for key in PUBLISHED])
    values[:2] /= 2.0  # diameters
    return values, np.sqrt(np.diag(results["covariance"]))


def part_of(recording: Recording, subset: str) -> Recording:
    """Return the whole recording, or every third row from the subset's number on."""
    if subset == "_all" or recording.wheel_rate is None or recording.displacement is None:
        return recording
    rows = slice(int(subset[1:]), None, 3)
    return Recording(
        recording.robot,
        wheel_rate=recording.wheel_rate.rows(rows),
        displacement=recording.displacement.rows(rows),
    )


def print_khepera(name: str) -> None:
    """Print ours, theirs and the two bars for one drive and its subsets."""
    recording = read_recording(ROOT / "khepera3" / f"{name}.recording.yaml")
    thirds, deviations = [], []
    for subset in SUBSETS:
        found = identify([part_of(recording, subset)])
        theirs, their_sds = published(name, subset)
        ours = np.array([found.estimates[key].value for key in NAMES], dtype=float)
        sds = np.array([found.estimates[key].sd for key in NAMES], dtype=float)
        robust = np.array([found.estimates[key].sd_robust or found.estimates[key].sd for key in NAMES])
        bar = np.maximum(3.0 * their_sds, 0.002 * np.abs(theirs))
        print(
            f"\n{name}{subset}: {int(found.residual['outliers'])} of {int(found.residual['rows'])} outliers"
        )
        print("                             ours    published   difference/bar   sd/published   sd_robust")
        for i, key in enumerate(NAMES):
            share, ratio = abs(ours[i] - theirs[i]) / bar[i], sds[i] / their_sds[i]
            print(
                f"  {key:20s} {ours[i]:12.6f} {theirs[i]:12.6f} {share:16.3f} {ratio:14.2f} {robust[i]:11.2g}"
            )
        if subset != "_all":
            thirds.append(ours)
            deviations.append(robust)
    spread = np.ptp(thirds, axis=0) / (np.sqrt(2.0) * np.max(deviations, axis=0))
    print(f"\n{name}: largest difference of two subsets over its robust deviation")
    print("  " + ", ".join(f"{key} {value:.1f}" for key, value in zip(NAMES, spread, strict=True)))


def print_positions(folder: str) -> None:
    """Print the position error after identifying and what was said of the robot's facts."""
    found = identify([read_recording(ROOT / folder / "drive.recording.yaml")])
    error, bar = found.residual["xy_m"], POSITION_BARS[folder]
    print(f"\n{folder}: {1e3 * error:.1f} mm rms over the whole drive (bar {1e3 * bar:.0f} mm)")
    for note in found.notes:
        print(f"  {note}")


if __name__ == "__main__":
    if not ROOT.is_dir():
        sys.exit(f"no recordings at {ROOT}: set FSM_CALIB_SHARED")
    for drive in ("l90", "lmov"):
        print_khepera(drive)
    for robot in POSITION_BARS:
        print_positions(robot)
