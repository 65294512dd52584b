"""The next drive as files: commands to play, the plan as JSON, and a page with the plan view and the outcomes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from markupsafe import Markup

from fsm_calib.diagnosis.design.area import Area
from fsm_calib.diagnosis.design.foresight import PATH_STEP
from fsm_calib.diagnosis.design.plan import Plan
from fsm_calib.errors import InputError
from fsm_calib.recording.playable import Commands, Unit, write_playable
from fsm_calib.recording.recording import Recording
from fsm_calib.report.pages import page
from fsm_calib.report.palette import BOARD_COLOURS, INK, TEXT
from fsm_calib.report.plot import Axes, Box, figure
from fsm_calib.types import FloatArray

TEMPLATE = "next_drive.html.j2"
ARROW_EVERY = 1.0  # s between the arrows that show the heading
ROBOT = 0.10  # m: half a robot, around its path


def write_next_drive(
    plan: Plan, area: Area, recording: Recording, full_speed: float, folder: Path
) -> list[Path]:
    """Write ``index.html``, ``plan.json``, ``commands.csv`` and bags into a folder; return what was written.

    recording : of the robot that is to drive: what kind of command it takes. full_speed [m/s] at command 1.

    Raises
    ------
    InputError
        A file cannot be written.
    """
    commands = commands_of(plan, recording, full_speed)
    written = write_playable(commands, folder, f"/{recording.robot.name}".replace(" ", "_"))
    page = next_drive_page(plan, area, recording.robot.name, bags=len(written) > 1)
    texts = {"index.html": page, "plan.json": json.dumps(plan.as_json(), indent=1) + "\n"}
    try:
        for name, text in texts.items():
            (folder / name).write_text(text, encoding="utf-8")
    except OSError as error:
        raise InputError(f"the plan cannot be written: {error.strerror}", where=str(folder)) from error
    return [*(folder / name for name in texts), *written]


def commands_of(plan: Plan, recording: Recording, full_speed: float) -> Commands:
    """Return the plan in the robot's own unit of command: normalized, rad/s, or twists."""
    seconds, left, right = np.array(plan.holds).T
    time = np.concatenate([[0.0], np.cumsum(seconds)])
    pairs = np.vstack([np.column_stack([left, right]), np.zeros((1, 2))])
    unit, values = _in_unit(recording, pairs, full_speed)
    return Commands(time, values, unit)


def _in_unit(recording: Recording, pairs: FloatArray, full_speed: float) -> tuple[Unit, FloatArray]:
    robot = recording.robot
    if recording.twist is not None:
        v, turn = 0.5 * (pairs[:, 0] + pairs[:, 1]), pairs[:, 1] - pairs[:, 0]
        return "twist", full_speed * np.column_stack([v, turn / (robot.axle_length or 0.1)])
    if recording.command is not None and recording.command.unit == "normalized":
        return "normalized", pairs
    return "rad/s", pairs * full_speed / (robot.wheel_radius or 0.0318)


def next_drive_page(plan: Plan, area: Area, robot: str, bags: bool = True) -> str:
    """Return the page as HTML."""
    width, depth = area.size
    return page(
        TEMPLATE,
        plan=plan,
        robot=robot,
        bags=bags,
        size=f"{width:g} x {depth:g} m",
        margin=area.margin,
        figure=Markup(plan_view(plan, area)),
    )


def _words(name: str) -> str:
    """Return an effect's name as words."""
    return name.replace("_", " ")


def plan_view(plan: Plan, area: Area, label: str = "Plan of the next drive") -> str:
    """Return the drive seen from above, drawn to scale, as SVG."""
    xlim, ylim = (area.x_low, area.x_high), (area.y_low, area.y_high)
    box = Box(60.0, 40.0, 560.0, 480.0).shrunk(xlim, ylim)
    axes = Axes(box, xlim, ylim)
    edge = area.margin
    inner = [
        (area.x_low + edge, area.y_low + edge), (area.x_high - edge, area.y_low + edge),
        (area.x_high - edge, area.y_high - edge), (area.x_low + edge, area.y_high - edge),
    ]  # fmt: skip
    axes.areas([inner], "#f4f5f7", edge="#cccccc")
    turn = np.linspace(0.0, 2.0 * np.pi, 32)
    for disc in area.obstacles:
        rim = np.column_stack([disc.x + disc.radius * np.cos(turn), disc.y + disc.radius * np.sin(turn)])
        axes.areas([rim], "#d73027", 0.5)
    axes.line(plan.path[:, :2], BOARD_COLOURS[0], 2.2, label=f"expected if {_words(plan.outlooks[0].label)}")
    picked = plan.path[:: max(int(ARROW_EVERY / PATH_STEP), 1)]
    axes.arrows(picked[:, :2], picked[:, 2], 0.06, INK)
    for number, outlook in enumerate(plan.outlooks[1:4], start=1):
        end = np.array([[outlook.end.x, outlook.end.y]])
        axes.crosses(end, BOARD_COLOURS[number], label=f"ends here if {_words(outlook.label)}")
    start = np.array([[plan.start.x, plan.start.y]])
    axes.dots(start, INK, 8.0)
    axes.words(plan.start.x - 0.06, plan.start.y + 0.06, "begin here", TEXT)
    axes.frame("x [m]", "y [m]")
    return figure(680.0, box.top + box.height + 60.0, label, axes)
