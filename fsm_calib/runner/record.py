"""What the run report is made of: the settings, the events, what was found, what the world says."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from fsm_calib.actions.notebook import Notebook
from fsm_calib.perception.calibration import CameraCalibration
from fsm_calib.runner.gallery import Picture
from fsm_calib.scenario.models import Scenario
from fsm_calib.types import BoardSpec, FloatArray
from fsm_calib.world2d.scene import SceneSpec


@dataclass(frozen=True)
class RunRecord:
    """A finished run.

    Parameters
    ----------
    directory : Path
        Where the run left its files.
    scenario : Scenario
        What was asked for.
    scene : SceneSpec
        The calibration area.
    board : BoardSpec
        The form of the chessboards.
    result : mapping
        The content of result.json.
    events : sequence of mapping
        The journal.
    notebook : Notebook
        What the actions found.
    calibration : CameraCalibration or None
        The camera's solution, with its residuals; None when there is none.
    pictures : sequence of Picture
        Kept frames.
    settings : mapping
        Every setting that was used, by group.
    track : array, shape (n, 4)
        Time [s], x, y [m], theta [rad] of the robot in the world, for drawing.
    paths : mapping of str to array, shape (n, 2)
        Paths of the 2 m test drive [m], by name.
    """

    directory: Path
    scenario: Scenario
    scene: SceneSpec
    board: BoardSpec
    result: Mapping[str, Any]
    events: Sequence[Mapping[str, Any]]
    notebook: Notebook
    calibration: CameraCalibration | None
    pictures: Sequence[Picture]
    settings: Mapping[str, Mapping[str, Any]]
    track: FloatArray
    paths: Mapping[str, FloatArray]

    @cached_property
    def spans(self) -> list[tuple[str, float, float]]:
        """(path, begin, end) of every stay in a state [s]; neighbouring stays in one state are joined."""
        spans: list[tuple[str, float, float]] = []
        begin = 0.0
        for event in self.events:
            end = float(event["time"])
            if spans and spans[-1][0] == event["path"]:
                spans[-1] = (event["path"], spans[-1][1], end)
            else:
                spans.append((event["path"], begin, end))
            begin = end
        return spans

    def data_url(self, picture: Picture) -> str:
        """Return a kept frame as a URL that holds the picture itself."""
        content = (self.directory / picture.file).read_bytes()
        return "data:image/jpeg;base64," + base64.b64encode(content).decode("ascii")
