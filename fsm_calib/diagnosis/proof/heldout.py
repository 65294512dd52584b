"""The proof: errors over two seconds on recordings that took no part in the fit, before, after and the floor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.proof.transfer import on_new_recording
from fsm_calib.diagnosis.proof.windows import (
    HorizonError,
    Windows,
    median_error,
    median_floor,
    prediction_windows,
)
from fsm_calib.diagnosis.replay.simulator import Simulator
from fsm_calib.types import FloatArray

KEPT = 0.95  # of the windows, smallest errors first: the rest are outliers of the poses


@dataclass(frozen=True, eq=False)
class Comparison:
    """Median errors of the re-fitted base robot, of the model with the effects, and of the noise alone.

    gain : log predictive density that the effects win on these recordings.
    """

    before: HorizonError
    after: HorizonError
    floor: HorizonError
    gain: float
    windows_before: tuple[Windows, ...]
    windows_after: tuple[Windows, ...]


def compare(simulators: Sequence[Simulator], base: Fit, fit: Fit, *, new: bool) -> Comparison:
    """Return errors on recordings; `new` says that they took no part in the fit (own numbers are found first)."""
    before: list[Windows] = []
    after: list[Windows] = []
    gain = 0.0
    for run, simulator in enumerate(simulators):
        alone = Engine((simulator,))
        values_before = on_new_recording(alone, base) if new else base.values[run : run + 1]
        values_after = on_new_recording(alone, fit) if new else fit.values[run : run + 1]
        simulated_before = simulator.increments(values_before)[0]
        simulated_after = simulator.increments(values_after)[0]
        before.append(prediction_windows(simulator.prepared, base.noise, simulated_before))
        after.append(prediction_windows(simulator.prepared, fit.noise, simulated_after))
        gain += alone.log_likelihood(alone.whiteners(fit.noise), [simulated_after])
        gain -= alone.log_likelihood(alone.whiteners(base.noise), [simulated_before])
    return Comparison(
        median_error(before), median_error(after), median_floor(after), gain, tuple(before), tuple(after)
    )


def noise_floor(simulators: Sequence[Simulator], fit: Fit) -> HorizonError:
    """Return the errors over the horizon that a fit's noise alone would make on the fitted recordings."""
    return median_floor(_windows(simulators, fit))


def squared_error(simulators: Sequence[Simulator], fit: Fit, unit: HorizonError) -> float:
    """Return the mean squared error over the horizon on the fitted recordings, but for outliers.

    Position and heading each in units of `unit`, one for all fits that are compared: a poor fit's own noise is wide.
    """
    errors = np.vstack([w.error for w in _windows(simulators, fit)])
    parts = ((np.hypot(errors[:, 0], errors[:, 1]), unit.xy_m), (errors[:, 2], unit.theta_rad))
    return sum(_trimmed(np.square(part / floor)) for part, floor in parts if floor > 0.0)


def _windows(simulators: Sequence[Simulator], fit: Fit) -> list[Windows]:
    return [
        prediction_windows(s.prepared, fit.noise, simulated)
        for s, simulated in zip(simulators, fit.simulated, strict=True)
    ]


def _trimmed(values: FloatArray) -> float:
    """Return the mean of what is finite and below the largest twentieth; 0 of nothing."""
    kept = np.sort(values[np.isfinite(values)])
    kept = kept[: int(np.ceil(KEPT * len(kept)))]
    return float(kept.mean()) if len(kept) else 0.0
