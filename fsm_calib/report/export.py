"""What a diagnosis found, for other programs: the files of `diagnose --export DIR`."""

from __future__ import annotations

import math
from xml.sax.saxutils import escape

from fsm_calib.diagnosis.diagnose import Diagnosis
from fsm_calib.report.export_corrections import COMMAND_MAP, corrections_text
from fsm_calib.report.export_values import ExportValues, export_values
from fsm_calib.world2d.slots import GRAVITY

BODY = {
    "coulomb_friction": "frictionloss of the wheel joints (mujoco.xml), friction of their axis (SDF); no breakaway",
    "payload_offset": "pos of the body's inertial (mujoco.xml), its pose (SDF)",
    "floor_tilt": "direction of gravity (mujoco.xml, SDF)",
}
"""Where the effects of the body and the floor went."""

CONTROLLER = """\
# For the controller of the REAL robot (ros2_control, diff_drive_controller): with these it moves as it is told, and its
# odometry is right. A simulated robot that shall err as the real one does keeps multipliers of 1.
# {source}
diff_drive_controller:
  ros__parameters:
    wheel_separation: {axle:.6g}  # m, as stated{assumed_axle}
    wheel_radius: {radius:.6g}  # m, as stated{assumed_radius}
    wheel_separation_multiplier: {separation:.6g}
    left_wheel_radius_multiplier: {left:.6g}
    right_wheel_radius_multiplier: {right:.6g}
"""

GAZEBO = """\
<?xml version="1.0"?>
<!-- For a SIMULATED robot whose wheels have the stated size (radius {radius:.6g} m, {axle:.6g} m apart): with
     these it answers steady twists as the recorded robot did. The plugin knows one radius: that the wheels differ (they
     roll like wheels of {left:.6g} m left, {right:.6g} m right) needs corrections.py.
     Friction [N m] is that of {mass:.6g} kg: multiply it by your robot's mass over this one. -->
<sdf version="1.9">
  <model name="{name}">
    <plugin filename="gz-sim-diff-drive-system" name="gz::sim::systems::DiffDrive">
      <wheel_separation>{plugin_axle:.6g}</wheel_separation>
      <wheel_radius>{plugin_radius:.6g}</wheel_radius>
    </plugin>
{body}  </model>
{world}</sdf>
"""


def exported(diagnosis: Diagnosis) -> dict[str, str]:
    """Return the text of each file by its name."""
    values = export_values(diagnosis)
    return {
        "corrections.py": corrections_text(values),
        "diff_drive_controller.yaml": controller_text(values),
        "gazebo_diff_drive.sdf": gazebo_text(values),
        "mujoco.xml": mujoco_text(values),
        "README.md": readme_text(values, f"{diagnosis.verdict.verdict}: {diagnosis.verdict.reason}"),
    }


def controller_text(values: ExportValues) -> str:
    """Return parameters of ros2's diff_drive_controller: fitted axle and rolling radii over the stated ones."""
    left, right = (r / values.radius for r in values.rolling_radii)
    return CONTROLLER.format(
        source="A diagnosis of recorded drives; effects of the command map are not in these five numbers.",
        axle=values.axle,
        radius=values.radius,
        assumed_axle=_assumed(values, "axle length"),
        assumed_radius=_assumed(values, "wheel radius"),
        separation=values.fitted_axle / values.axle,
        left=left,
        right=right,
    )


def gazebo_text(values: ExportValues) -> str:
    """Return the DiffDrive plugin's values and the SDF fields of body and world.

    The plugin turns a twist into wheel rates with its radius r and separation s, the simulated wheels (R, b) turn
    these into v R / r and omega (R / r) s / b; the real robot makes v g and omega g b / b_fitted of it, with g the
    fitted over the stated gain, the mean of both wheels. Hence r = R / g and s = b^2 / b_fitted.
    """
    mean = 0.5 * sum(values.gains) / values.full_speed
    left, right = values.rolling_radii
    return GAZEBO.format(
        name=escape(values.robot, {'"': "&quot;"}),
        radius=values.radius,
        axle=values.axle,
        left=left,
        right=right,
        mass=values.mass,
        plugin_axle=values.axle**2 / values.fitted_axle,
        plugin_radius=values.radius / mean,
        body=_sdf_body(values),
        world=_sdf_world(values),
    )


def mujoco_text(values: ExportValues) -> str:
    """Return the MJCF fields of the effects that have one."""
    options, inertial, joints = "", "", ""
    if (pull := gravity(values)) is not None:
        options = f'  <option gravity="{_numbers(pull)}"/>\n'
    if (load := values.effects.get("payload_offset")) is not None:
        inertial = f'      <inertial pos="{load["x"]:.6g} {load["y"]:.6g} 0"/>\n'
    if (torques := wheel_friction(values)) is not None:
        joints = "".join(
            f'      <joint name="{side}_wheel" frictionloss="{torque:.6g}"/>\n'
            for side, torque in zip(("left", "right"), torques, strict=True)
        )
    body = f'  <worldbody>\n    <body name="base">\n{inertial}{joints}    </body>\n  </worldbody>\n'
    said = options + (body if inertial or joints else "") or "  <!-- no effect has a field here -->\n"
    return (
        "<!-- Fields to copy into the model of your robot; not a model by itself. Lengths [m] from the axle's middle,\n"
        "     x ahead, y left; its height and the body's inertia are your own. Friction [N m] is that of a robot of\n"
        f"     {values.mass:.6g} kg, which the fit assumes: multiply it by your robot's mass over this one. -->\n"
        f"<mujoco>\n{said}</mujoco>\n"
    )


def gravity(values: ExportValues) -> tuple[float, float, float] | None:
    """Return gravity [m/s2] in a world whose floor is level, for a floor that is not; None for one that is."""
    tilt = values.effects.get("floor_tilt")
    if tilt is None:
        return None
    x, y = -GRAVITY * tilt["slope_x"], -GRAVITY * tilt["slope_y"]
    return x, y, -math.sqrt(GRAVITY**2 - x**2 - y**2)


def wheel_friction(values: ExportValues) -> tuple[float, float] | None:
    """Return the dry friction [N m] of the left and the right wheel; None where there is none."""
    dry = values.effects.get("coulomb_friction")
    if dry is None:
        return None
    half = 0.5 * dry["difference"]
    return max(dry["friction"] + half, 0.0), max(dry["friction"] - half, 0.0)


def readme_text(values: ExportValues, answer: str) -> str:
    """Return what each file is, and where each effect of the diagnosis went."""
    rows = [
        f"| {name} | {'named' if name in values.named else 'fitted, not named'} | {_place(name)} |"
        for name in values.effects
    ]
    rows = rows or ["| none | | |"]
    events = [f"- {name}: an event of one recording, no part of the robot" for name in _events(values)]
    return "\n".join(
        [
            "# What the recordings showed, for other programs",
            "",
            "    " + " ".join(answer.split()),
            "",
            FILES,
            "| effect | | where it is |",
            "|---|---|---|",
            *rows,
            "",
            *events,
        ]
    )


FILES = """\
| file | for | what it does |
|---|---|---|
| `corrections.py` | any simulator | commands to the commands that make it drive as the recorded robot did; twists too |
| `diff_drive_controller.yaml` | the real robot's controller in ros2 | makes it move as told, its odometry right |
| `gazebo_diff_drive.sdf` | a simulated robot with the stated wheels | answers steady twists as the recorded robot did |
| `mujoco.xml` | an MJCF model | fields to copy, for the effects that have one |

Take one of them for a simulator, not two: `corrections.py` and the Gazebo plugin's values both hold the wheels' gains.
The first and the third make a simulation err as the robot does; the second takes the error from the robot.
"""


def _place(name: str) -> str:
    if name in COMMAND_MAP:
        return "`corrections.py`"
    return BODY.get(name, "no place here: it is in the `world.yaml` of `--world` or `--report` alone")


def _events(values: ExportValues) -> list[str]:
    return [name for name in values.named if name not in values.effects]


def _sdf_body(values: ExportValues) -> str:
    found = ""
    if (load := values.effects.get("payload_offset")) is not None:
        pose = f"{load['x']:.6g} {load['y']:.6g} 0 0 0 0"
        found += f'    <link name="base"><inertial><pose>{pose}</pose></inertial></link>\n'
    for side, torque in zip(("left", "right"), wheel_friction(values) or (), strict=False):
        friction = f"<dynamics><friction>{torque:.6g}</friction></dynamics>"
        found += f'    <joint name="{side}_wheel"><axis>{friction}</axis></joint>\n'
    return found


def _sdf_world(values: ExportValues) -> str:
    pull = gravity(values)
    return "" if pull is None else f'  <world name="floor"><gravity>{_numbers(pull)}</gravity></world>\n'


def _numbers(values: tuple[float, ...]) -> str:
    return " ".join(f"{value:.6g}" for value in values)


def _assumed(values: ExportValues, name: str) -> str:
    return " (nobody stated it: assumed)" if name in values.assumed else ""
