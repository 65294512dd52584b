"""The bench: what the actions share in one run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fsm_calib.actions.notebook import Notebook
from fsm_calib.actions.settings import ActionSettings
from fsm_calib.perception.calibration import CameraCalibration
from fsm_calib.ports import Robot
from fsm_calib.types import WheelCommand


@dataclass(frozen=True, eq=False)
class KeptFrame:
    """A frame kept for the report: the image (uint8), its time [s], the activity, the points found in it
    [px].
    """

    image: NDArray[np.uint8]
    time: float
    activity: str
    points_image: NDArray[np.float64]


@dataclass(slots=True)
class Bench:
    """What every action gets.

    Parameters
    ----------
    robot : Robot
        The port: wheels, camera, clock.
    settings : ActionSettings
    notebook : Notebook
        Results so far.
    briefing : mapping
        What the machine tells the action: the state's path, the board's number, counts.
    frames : list of KeptFrame
        Frames for the report, at most `most_frames`, one in `keep_every`; not part of a checkpoint.
    calibration : CameraCalibration or None
        The last solution of the camera with its residuals, for the report; not part of a checkpoint.
    steered : list of (float, WheelCommand)
        The last commands in the lane with their times [s]; not part of a checkpoint.
    """

    robot: Robot
    settings: ActionSettings = field(default_factory=ActionSettings)
    notebook: Notebook = field(default_factory=Notebook)
    briefing: Mapping[str, Any] = field(default_factory=dict)
    frames: list[KeptFrame] = field(default_factory=list)
    most_frames: int = 48
    keep_every: int = 6
    seen_frames: int = 0
    calibration: CameraCalibration | None = None
    steered: list[tuple[float, WheelCommand]] = field(default_factory=list)

    @property
    def ratio(self) -> float:
        """The wheel ratio k in use [1]."""
        return self.notebook.wheel_ratio

    def keep(
        self, image: NDArray[np.uint8], time: float, activity: str, points_image: NDArray[np.float64]
    ) -> None:
        """Keep a frame for the report when it is its turn."""
        self.seen_frames += 1
        if self.seen_frames % self.keep_every == 1 and len(self.frames) < self.most_frames:
            self.frames.append(KeptFrame(image, time, activity, np.asarray(points_image, dtype=float)))

    def to_state(self) -> dict[str, Any]:
        """Return the checkpoint: the notebook as plain JSON values."""
        return self.notebook.to_state()

    def from_state(self, state: Mapping[str, Any]) -> None:
        """Take the notebook from a checkpoint."""
        self.notebook = Notebook.from_state(state)
