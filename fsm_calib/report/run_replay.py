"""The replay on a run's page: what the robot saw, where it was and what it was doing at any moment of the run."""

from __future__ import annotations

import json
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup

from fsm_calib.report.palette import INK
from fsm_calib.report.plot import Axes, Box, figure
from fsm_calib.report.plot_scale import limits
from fsm_calib.report.run_plan import LABEL, draw_scene, draw_track
from fsm_calib.runner.record import RunRecord
from fsm_calib.types import FloatArray
from fsm_calib.world2d.outlines import scene_corners

SIZE = (400.0, 380.0)
PLAN = Box(46.0, 14.0, 344.0, 318.0)
"""Size of the plan and the place of its axes [px]."""
MOST_POSES = 1500
"""Places of the robot that the page holds: more would not be seen on a slider."""
BODY = ((-0.08, -0.065), (0.06, -0.065), (0.13, 0.0), (0.06, 0.065), (-0.08, 0.065))
"""Outline of the robot that moves over the plan, in `base` [m]."""
SMALLEST = 9.0
"""Half the length at which it is drawn at least [px]: in a large area it could not be seen."""


@dataclass(frozen=True)
class Replay:
    """What the page needs: the plan as SVG with an element `replay-robot`, and times and places as JSON."""

    plan: Markup
    data: Markup
    duration: float


def replay(record: RunRecord) -> Replay | None:
    """Return the replay of a run; None for one that has no path or no event."""
    if len(record.track) < 2 or not record.events:
        return None
    axes = plan_axes(record)
    scale = abs(float(axes.x(1.0)) - float(axes.x(0.0)))
    size = scale * max(1.0, SMALLEST / (0.1 * scale))
    outline = "L".join(f"{size * x:.1f} {-size * y:.1f}" for x, y in BODY)
    robot = f'<path id="replay-robot" d="M{outline}Z" fill="{INK}" stroke="#fff" stroke-width="1.2"/>'
    plan = figure(*SIZE, "Where the robot is at the moment shown", axes, extra=[robot])
    data = {
        "poses": _places(axes, thinned_track(record.track)),
        "events": [[round(float(e["time"]), 3), e["path"], e["sentence"]] for e in record.events],
        "frames": [round(picture.time, 3) for picture in record.pictures],
    }
    text = json.dumps(data, separators=(",", ":")).replace("<", "\\u003c")
    return Replay(Markup(plan), Markup(text), float(record.events[-1]["time"]))


def plan_axes(record: RunRecord) -> Axes:
    """Return the plan of the whole area with the driven path, without the robot."""
    corners = np.vstack([*scene_corners(record.scene), record.track[:, 1:3]])
    xlim, ylim = limits(corners[:, 0]), limits(corners[:, 1])
    xlim = (xlim[0], xlim[1] + LABEL)
    axes = Axes(PLAN.shrunk(xlim, ylim), xlim, ylim)
    draw_scene(axes, record.scene)
    draw_track(axes, record, is_named=False, has_robot=False)
    axes.frame("x [m]", "y [m]")
    return axes


def thinned_track(track: FloatArray) -> FloatArray:
    """Return at most `MOST_POSES` rows of a track, evenly spread, with the first and the last."""
    kept = np.linspace(0, len(track) - 1, min(len(track), MOST_POSES)).round().astype(int)
    return track[kept]


def _places(axes: Axes, track: FloatArray) -> list[list[float]]:
    """Return time [s], place [px] and turn [deg], clockwise as SVG counts, of each row."""
    columns = (track[:, 0], axes.x(track[:, 1]), axes.y(track[:, 2]), -np.degrees(track[:, 3]))
    return np.column_stack(columns).round(2).tolist()
