"""`corrections.py` of an export: the robot's command map as a Python module that needs nothing else."""

from __future__ import annotations

from collections.abc import Mapping

from fsm_calib.report.export_values import ExportValues

COMMAND_MAP: Mapping[str, str] = {
    "command_saturation": '''\
def _command_saturation(u: float, side: int) -> float:
    """Cut the command at a limit, or let it give way softly."""
    limit, soft = {limit!r}, {soft!r}
    if soft > 0.0:
        return u / (1.0 + (u / limit) ** 4) ** 0.25
    return min(max(u, -limit), limit)
''',
    "pwm_steps": '''\
def _pwm_steps(u: float, side: int) -> float:
    """Round the command to whole PWM numbers; `share` of the rounding acts."""
    share, levels, nearest = {share!r}, {levels!r}, {nearest!r}
    whole = math.floor(abs(u) * levels + 0.5 * nearest + 1e-9) / levels
    return u + share * (math.copysign(whole, u) - u)
''',
    "motor_deadband": '''\
def _motor_deadband(u: float, side: int) -> float:
    """Take the same piece from every command; where it is negative, add it to all above 0.01."""
    size, lost = abs(u), {offset!r} + ({offset_left!r}, {offset_right!r})[side]
    if lost < 0.0 and size <= 0.01:
        return 0.0
    return math.copysign(max(size - lost, 0.0), u)
''',
    "motor_gain_curve": '''\
def _motor_gain_curve(u: float, side: int) -> float:
    """Bend the line from command to speed, or raise it to a power."""
    size, gamma = abs(u), {curvature!r} + ({curvature_left!r}, {curvature_right!r})[side]
    if gamma > 0.0:
        size = min(size, 0.5 / gamma)
    size *= 1.0 - gamma * size
    if size > 0.0:
        size **= 1.0 + {power!r}
    return math.copysign(size, u) if size > 0.0 else math.copysign(1.0, u) * size
''',
    "motor_reverse_asymmetry": '''\
def _motor_reverse_asymmetry(u: float, side: int) -> float:
    """Weaken the command backwards, one side more than the other."""
    return u if u >= 0.0 else u * (1.0 - {loss!r} - (0.5, -0.5)[side] * {difference!r})
''',
}
"""The effects of the command map in the order in which they act, each as the text of a function."""

HEAD = '''\
"""What the recordings showed of this robot's command map, for any program: plain Python, nothing to install.

Give a simulator that leaves these effects out `corrected(left, right)` in place of (left, right), and it drives as the
recorded robot did. Do not use it to steer the real robot: that has the effects already.

Commands [1]: 1 is a stated rim speed of FULL_SPEED [m/s]{note}.
Order: {order}, then the wheels' gains. Inertia, friction and floor are not in here; README.md says where they are.
"""

{imports}FULL_SPEED = {full!r}  # m/s: stated rim speed at command 1
GAINS = {gains!r}  # m/s: rim speeds at command 1 that were fitted, left and right
STATED_AXLE = {stated!r}  # m: that a commanded twist is turned into wheel commands with
FITTED_AXLE = {axle!r}  # m: with which the wheels turn the robot


'''

TAIL = '''\
def effective(u: float, side: int) -> float:
    """Return what one wheel makes of its command [1], before its gain; side 0 is left, 1 is right."""
{steps}    return u


def rim_speeds(left: float, right: float) -> tuple[float, float]:
    """Return the steady rim speeds [m/s] that commands [1] give."""
    return GAINS[0] * effective(left, 0), GAINS[1] * effective(right, 1)


def corrected(left: float, right: float) -> tuple[float, float]:
    """Return the commands [1] that make a robot with the stated wheels drive as the recorded one did."""
    a, b = rim_speeds(left, right)
    return a / FULL_SPEED, b / FULL_SPEED


def twist(left: float, right: float) -> tuple[float, float]:
    """Return the steady forward speed [m/s] and yaw rate [rad/s] that commands [1] give."""
    a, b = rim_speeds(left, right)
    return 0.5 * (a + b), (b - a) / FITTED_AXLE


def corrected_twist(v: float, omega: float) -> tuple[float, float]:
    """Return the twist [m/s, rad/s] that the recorded robot makes of a commanded one."""
    half = 0.5 * STATED_AXLE * omega
    return twist((v - half) / FULL_SPEED, (v + half) / FULL_SPEED)
'''


def corrections_text(values: ExportValues) -> str:
    """Return the module: constants, the fitted effects of the command map, and the functions that apply them."""
    acting = [name for name in COMMAND_MAP if name in values.effects]
    text = HEAD.format(
        note=_note(values),
        order=", ".join(acting) or "no effect of the command map was found",
        imports="from __future__ import annotations\n\nimport math\n\n"
        if acting
        else "from __future__ import annotations\n\n",
        full=values.full_speed,
        gains=values.gains,
        stated=values.axle,
        axle=values.fitted_axle,
    )
    for name in acting:
        text += COMMAND_MAP[name].format(**values.effects[name]) + "\n\n"
    return text + TAIL.format(steps="".join(f"    u = _{name}(u, side)\n" for name in acting))


def _note(values: ExportValues) -> str:
    return (
        ".\nMeasured wheel speeds stood in for commands: what the motors make of theirs is not known"
        if values.measured_input
        else ""
    )
