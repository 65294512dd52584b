"""Exported corrections, played in a simulator that lacks what was found: the same prediction as `world.yaml`'s?

    python benchmarks/export_played.py

A simulated robot has one thing that shapes its commands; two of its drives are diagnosed among five such effects, and
`corrections.py` is exported. The simulator is a plain robot of the stated sizes with the real one's lags. Printed: its error
over 2 s on a third drive as it is, told the corrected commands, and that of the fitted world with the effect; the
difference of the last two as a share of what the corrections gain. About a minute.
"""

from __future__ import annotations

import runpy
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))
from diagnosis_robots import recording, robot

from fsm_calib.diagnosis.around import increments_of
from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.diagnosis.own_simulator import poses_at
from fsm_calib.diagnosis.proof.heldout import median_error
from fsm_calib.diagnosis.proof.windows import prediction_windows
from fsm_calib.report.export import exported
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.rollout import Drive, simulate

STATED = 0.0318 * 20.0  # m/s at command 1
STEP = 0.02  # s between poses of the simulator
CASES = {
    "motor_deadband": {"motor_deadband__offset": 0.08},
    "motor_gain_curve": {"motor_gain_curve__curvature": 0.4},
    "command_saturation": {"command_saturation__limit": 0.3},
    "motor_reverse_asymmetry": {
        "motor_reverse_asymmetry__loss": 0.12,
        "motor_reverse_asymmetry__difference": 0.05,
    },
}


def path_of(drive: Drive, start: np.ndarray, end: float) -> np.ndarray:
    """Return the path (n, 4) of the plain robot, which starts at a pose."""
    plain = robot(gain_left=STATED, gain_right=STATED)
    time = np.arange(0.0, end + STEP, STEP)
    return np.column_stack([time, simulate(plain, drive, time, tuple(start))[:, :3]])


def main() -> None:
    """Run the benchmark."""
    others = set(registry()) - set(CASES) - {"coulomb_friction"}
    for name, changes in CASES.items():
        drives = [recording(seed, 40.0, **changes) for seed in (1, 2, 3)]
        found = diagnose(drives[:2], drives[2:], without=others)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "corrections.py")
            path.write_text(exported(found)["corrections.py"])
            corrected = runpy.run_path(str(path))["corrected"]
        (simulator,), fit = found.holdout_simulators, found.decision.model.fit
        p, told = simulator.prepared, drives[2].command
        pairs = np.array([corrected(a, b) for a, b in zip(told.left, told.right, strict=True)])
        like, errors = simulator.increments(fit.values[:1])[0], []
        for drive in (Drive(told.time, told.left, told.right), Drive(told.time, *pairs.T)):
            seen = poses_at(path_of(drive, p.reference[0], p.time[-1]), p.time)
            errors.append(median_error([prediction_windows(p, fit.noise, increments_of(seen, like))]))
        world = median_error([prediction_windows(p, fit.noise, like)])
        named = ", ".join(effect.name for effect in found.verdict.effects) or found.verdict.verdict
        shares = [
            abs(getattr(errors[1], key) - getattr(world, key))
            / (getattr(errors[0], key) - getattr(world, key))
            for key in ("xy_m", "theta_rad")
        ]
        print(
            f"{name}: named {named}; xy {1e3 * errors[0].xy_m:.1f}, {1e3 * errors[1].xy_m:.1f}, {1e3 * world.xy_m:.1f} mm; "
            f"heading {errors[0].theta_rad:.4f}, {errors[1].theta_rad:.4f}, {world.theta_rad:.4f} rad; "
            f"apart by {shares[0]:.1%} and {shares[1]:.1%} of the gain",
            flush=True,
        )


if __name__ == "__main__":
    main()
