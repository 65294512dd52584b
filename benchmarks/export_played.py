"""Exported corrections, played in a simulator that lacks what was found: the same prediction as `world.yaml`'s?

    python benchmarks/export_played.py

A simulated robot has one or two things that shape its commands; two of its drives are diagnosed among five such effects,
and `corrections.py` is exported. One robot is a Duckiebot, one has 20 kg and half a metre between its wheels. The simulator
is a plain robot of the stated sizes with the real one's lags. Printed: its error
over 2 s on a third drive as it is, told the corrected commands, and that of the fitted world with the effect; the
difference of the last two as a share of what the corrections gain. About two minutes.
"""

from __future__ import annotations

import runpy
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parent.parent / "tests"))
from diagnosis_robots import HEADING_NOISE, POSITION_NOISE, RATE, START, drive

from fsm_calib.diagnosis.around import increments_of
from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.diagnosis.own_simulator import poses_at
from fsm_calib.diagnosis.proof.heldout import median_error
from fsm_calib.diagnosis.proof.windows import prediction_windows
from fsm_calib.recording.channels import CommandTrack, PoseTrack
from fsm_calib.recording.recording import Recording, RobotFacts
from fsm_calib.report.export import exported
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.observation import predict
from fsm_calib.world2d.parameters import parameters
from fsm_calib.world2d.rollout import Drive, simulate

STEP = 0.02  # s between poses of the simulator
DURATION = 40.0  # s
GAINS = (1.04, 0.96)  # of the stated rate, left and right
EFFECTS = {
    "motor_deadband": {"motor_deadband.offset": 0.08},
    "motor_gain_curve": {"motor_gain_curve.curvature": 0.4},
    "command_saturation": {"command_saturation.limit": 0.3},
    "motor_reverse_asymmetry": {
        "motor_reverse_asymmetry.loss": 0.12,
        "motor_reverse_asymmetry.difference": 0.05,
    },
}
PAIRS = (("motor_deadband", "command_saturation"), ("motor_deadband", "motor_reverse_asymmetry"))


@dataclass(frozen=True)
class Robot:
    """A robot as it is stated: wheel radius, axle [m], mass [kg], rate at command 1 [rad/s]."""

    name: str
    radius: float
    axle: float
    mass: float
    rate: float

    def parameters(self, gains: tuple[float, float], effects: Mapping[str, float]) -> FloatArray:
        """Return the simulation's parameters; gains are shares of the stated rate."""
        sizes = {"axle_length": self.axle, "mass": self.mass}
        for side, gain in zip(("left", "right"), gains, strict=True):
            sizes |= {f"gain_{side}": gain * self.radius * self.rate, f"wheel_radius_{side}": self.radius}
        return parameters(sizes | effects)

    def recording(self, seed: int, effects: Mapping[str, float]) -> Recording:
        """Return a drive of the real one, as a tracker saw it."""
        rng = np.random.default_rng(seed)
        told, stamps = drive(rng, DURATION), np.arange(0.0, DURATION, 1.0 / RATE)
        poses = predict(self.parameters(GAINS, effects), told, stamps, START).poses
        poses = poses + rng.normal(size=poses.shape) * [POSITION_NOISE, POSITION_NOISE, HEADING_NOISE]
        facts = RobotFacts(
            self.name,
            wheel_radius=self.radius,
            axle_length=self.axle,
            max_wheel_rate=self.rate,
            mass=self.mass,
        )
        command = CommandTrack(told.time, told.left, told.right)
        return Recording(facts, command=command, pose=PoseTrack(stamps, *poses.T), source=f"drive-{seed}")

    def path(self, told: Drive, start: np.ndarray, end: float) -> np.ndarray:
        """Return the path (n, 4) of the plain simulator, which starts at a pose."""
        plain, time = self.parameters((1.0, 1.0), {}), np.arange(0.0, end + STEP, STEP)
        return np.column_stack([time, simulate(plain, told, time, tuple(start))[:, :3]])


ROBOTS = (Robot("Duckiebot", 0.0318, 0.1, 1.1, 20.0), Robot("20 kg", 0.1, 0.5, 20.0, 10.0))


def main() -> None:
    """Run the benchmark."""
    others = set(registry()) - set(EFFECTS) - {"coulomb_friction"}
    cases = [(robot, names) for robot in ROBOTS for names in (*((name,) for name in EFFECTS), *PAIRS)]
    for robot, names in cases:
        effects = {key: value for name in names for key, value in EFFECTS[name].items()}
        drives = [robot.recording(seed, effects) for seed in (1, 2, 3)]
        found = diagnose(drives[:2], drives[2:], without=others)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "corrections.py")
            path.write_text(exported(found)["corrections.py"])
            corrected = runpy.run_path(str(path))["corrected"]
        (simulator,), fit = found.holdout_simulators, found.decision.model.fit
        p, sent = simulator.prepared, drives[2].command
        pairs = np.array([corrected(a, b) for a, b in zip(sent.left, sent.right, strict=True)])
        like, errors = simulator.increments(fit.values[:1])[0], []
        for told in (Drive(sent.time, sent.left, sent.right), Drive(sent.time, *pairs.T)):
            seen = poses_at(robot.path(told, p.reference[0], p.time[-1]), p.time)
            errors.append(median_error([prediction_windows(p, fit.noise, increments_of(seen, like))]))
        world = median_error([prediction_windows(p, fit.noise, like)])
        named = ", ".join(effect.name for effect in found.verdict.effects) or found.verdict.verdict
        shares = [
            abs(getattr(errors[1], key) - getattr(world, key))
            / (getattr(errors[0], key) - getattr(world, key))
            for key in ("xy_m", "theta_rad")
        ]
        print(
            f"{robot.name}, {' and '.join(names)}: named {named}; xy {1e3 * errors[0].xy_m:.1f}, {1e3 * errors[1].xy_m:.1f}, {1e3 * world.xy_m:.1f} mm; "
            f"heading {errors[0].theta_rad:.4f}, {errors[1].theta_rad:.4f}, {world.theta_rad:.4f} rad; "
            f"apart by {shares[0]:.1%} and {shares[1]:.1%} of the gain",
            flush=True,
        )


if __name__ == "__main__":
    main()
