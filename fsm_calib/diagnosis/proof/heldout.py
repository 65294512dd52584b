"""The proof: errors over two seconds on recordings that took no part in the fit, before, after and the floor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

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


def squared_error(simulators: Sequence[Simulator], fit: Fit) -> float:
    """Return the median squared error over the horizon on the fitted recordings, position and heading each in units
    of its noise.
    """
    windows = [
        prediction_windows(s.prepared, fit.noise, simulated)
        for s, simulated in zip(simulators, fit.simulated, strict=True)
    ]
    errors, floors = median_error(windows), median_floor(windows)
    parts = ((errors.xy_m, floors.xy_m), (errors.theta_rad, floors.theta_rad))
    return float(sum((error / floor) ** 2 for error, floor in parts if floor > 0.0))
