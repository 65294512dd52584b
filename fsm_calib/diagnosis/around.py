r"""What the real robot has and a simulator lacks, applied around the simulator, and what that does to its errors.

The simulator S is driven by the real robot's commands. Two of our models are beside it: of the simulator, M_s, and of
the real robot, M_r, both fitted (`against.py`). The motion from one event to the next, in the body's frame, becomes

    d(t) = d_S(t) + d_{M_r}(t) - d_{M_s}(t)

so that what the simulator has beyond our equations stays, and only the remainder comes from them. Assumes that the
remainder does not depend on the path from which it was taken; places are taken from the real path.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from fsm_calib.diagnosis.against import Against
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.own_simulator import OwnSimulator, driven, poses_at
from fsm_calib.diagnosis.proof.transfer import on_new_recording
from fsm_calib.diagnosis.proof.windows import (
    HorizonError,
    Windows,
    median_error,
    median_floor,
    prediction_windows,
)
from fsm_calib.diagnosis.replay.prepared import prepare
from fsm_calib.diagnosis.replay.simulator import Simulator, make_simulator
from fsm_calib.recording.recording import Recording
from fsm_calib.types import FloatArray


@dataclass(frozen=True, slots=True)
class Around:
    """Errors of the user's simulator over the horizon: as it is, with the remainder around it, of the noise alone.

    on : the recordings that were predicted, held-out ones where there are any.
    """

    on: Literal["holdout", "train"]
    before: HorizonError
    after: HorizonError
    floor: HorizonError

    def as_json(self) -> dict[str, Any]:
        """Return plain values, as `fit.holdout` of a verdict."""
        rows = {"before": self.before, "after": self.after, "floor": self.floor}
        return {"on": self.on} | {
            name: {"xy_m": float(f"{e.xy_m:.6g}"), "theta_rad": float(f"{e.theta_rad:.6g}")}
            for name, e in rows.items()
        }


def simulated_recordings(
    simulate: OwnSimulator, recordings: Sequence[Recording], seed: int = 0
) -> list[Recording]:
    """Return what a simulator's robot does by the commands of real recordings, seen by the same tracker."""
    rng = np.random.default_rng(seed)
    return [driven(simulate, r, rng)[0] for r in recordings]


def around(found: Against, simulate: OwnSimulator, seed: int = 0) -> Around:
    """Apply the remainder around the simulator; predict the held-out recordings, or the fitted ones if none is.

    Raises
    ------
    DataError
        The simulator fails on one of them.
    """
    new = bool(found.real.holdout_simulators)
    simulators = found.real.holdout_simulators or found.real.decision.engine.simulators
    real, own = found.real.decision.model.fit, found.simulated.decision.model.fit
    cut = found.simulated.decision.engine.simulators[0].cut
    rng = np.random.default_rng(seed)
    before: list[Windows] = []
    after: list[Windows] = []
    for run, simulator in enumerate(simulators):
        p = simulator.prepared
        values = on_new_recording(Engine((simulator,)), real) if new else real.values[run : run + 1]
        with_all = simulator.increments(values)[0]
        seen, path = driven(simulate, p.recording, rng)
        exact = increments_of(poses_at(path, p.time), with_all)
        without = simulator.increments(_described(seen, simulator, own, cut))[0]
        before.append(prediction_windows(p, real.noise, exact))
        after.append(prediction_windows(p, real.noise, exact + with_all - without))
    return Around(
        "holdout" if new else "train", median_error(before), median_error(after), median_floor(after)
    )


def increments_of(poses: FloatArray, like: FloatArray) -> FloatArray:
    """Return the motion (n, 5) from pose to pose (n, 3) in the body's frame; the wheels' turns are those of `like`."""
    out = like.copy()
    step, c, s = np.diff(poses, axis=0), np.cos(poses[:-1, 2]), np.sin(poses[:-1, 2])
    out[0, :3] = 0.0
    out[1:, 0], out[1:, 1] = c * step[:, 0] + s * step[:, 1], c * step[:, 1] - s * step[:, 0]
    out[1:, 2] = step[:, 2]
    return out


def _described(seen: Recording, real: Simulator, fit: Fit, cut: bool) -> FloatArray:
    """Return our model of the simulator (1, p) for one drive: its own phases are found in what it drove, by commands
    that end at full command or not, as its own drives told.
    """
    own = make_simulator(prepare(seen, real.prepared.settings), real.world, cut=cut)
    return on_new_recording(Engine((own,)), fit)
