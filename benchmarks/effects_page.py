"""Make docs/effects.md and its pictures: `python3 benchmarks/effects_page.py` (about a minute)."""

from __future__ import annotations

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import least_squares

from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.effects.page import page
from fsm_calib.world2d.observation import predict
from fsm_calib.world2d.parameters import NUISANCE, null_parameters, parameter_table, typical_parameters
from fsm_calib.world2d.rollout import Drive

DOCS = Path(__file__).parent.parent / "docs"
STAMPS = np.arange(0.0, 24.0, 0.05)
START = (0.0, 0.0, 0.3)
NOISE = np.array([0.002, 0.002, 0.006])
UNITS = (("forward", "mm/s", 1e3), ("lateral", "mm/s", 1e3), ("turn", "deg/s", 180.0 / np.pi))


def drive() -> Drive:
    levels = [(0.1, 0.1), (0.3, 0.3), (0, 0), (-0.3, -0.3), (0.6, 0.6), (-0.2, 0.2), (0, 0), (0.35, -0.35), (0.5, 0.2),
              (0, 0), (-0.5, -0.5), (0.2, 0.5), (0.7, 0.7), (0, 0.3), (0, 0), (-0.6, -0.6), (0.4, 0.1), (0, 0)]  # fmt: skip
    return Drive(0.5 + np.arange(len(levels)) * 1.25, [a for a, _ in levels], [b for _, b in levels])


def speeds(vector: np.ndarray, track: np.ndarray) -> np.ndarray:
    """Body-frame pose increments over 0.1 s, per second."""
    poses = predict(vector, drive(), STAMPS, START, track).poses
    change, heading = poses[2:] - poses[:-2], poses[:-2, 2]
    c, s = np.cos(heading), np.sin(heading)
    rows = (c * change[:, 0] + s * change[:, 1], c * change[:, 1] - s * change[:, 0], change[:, 2])
    return np.column_stack(rows) / 0.1


def refitted(target: np.ndarray, track: np.ndarray) -> np.ndarray:
    """Speeds of the base robot that comes nearest."""
    places = [parameter_table().place(name) for name in NUISANCE]
    base = null_parameters()

    def vector(z: np.ndarray) -> np.ndarray:
        moved = base.copy()
        moved[places] *= 1.0 + z
        return moved

    fit = least_squares(
        lambda z: ((speeds(vector(z), track) - target) / NOISE).ravel(), np.zeros(5), diff_step=1e-4
    )
    return speeds(vector(fit.x), track)


def draw(name: str) -> None:
    vector = typical_parameters(registry()[name])
    states = predict(vector, drive(), STAMPS, START).states
    track = np.column_stack([STAMPS, states[:, :3]])
    target = speeds(vector, track)
    plain, hidden = target - speeds(null_parameters(), track), target - refitted(target, track)
    figure, axes = plt.subplots(1, 3, figsize=(9, 1.9), sharex=True, layout="constrained")
    for i, (axis, (channel, unit, scale)) in enumerate(zip(axes, UNITS, strict=True)):
        axis.plot(STAMPS[1:-1], plain[:, i] * scale, color="0.75", linewidth=0.8)
        axis.plot(STAMPS[1:-1], hidden[:, i] * scale, color="tab:red", linewidth=0.8)
        axis.set_title(f"{channel} [{unit}]", fontsize=8)
        axis.set_xlabel("time [s]", fontsize=7)
        axis.tick_params(labelsize=7)
    figure.savefig(DOCS / "effects" / f"{name}.png", dpi=70)
    plt.close(figure)


if __name__ == "__main__":
    (DOCS / "effects").mkdir(parents=True, exist_ok=True)
    (DOCS / "effects.md").write_text(page(), encoding="utf-8")
    for effect in registry():
        draw(effect)
