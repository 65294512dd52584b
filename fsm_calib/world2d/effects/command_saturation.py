r"""Commands above a limit are cut.

    u_effective = min(max(u, -limit), limit)
    u_effective = u / (1 + (|u| / limit)^n)^(1/n)       soft: a supply that gives way before it gives no more
    u_effective = u limit / max(|u_left|, |u_right|)    both at once where one is too large: the curve is kept
    |u_right - u_left| / 2 <= turn                      a largest rate of turning; the mean of both is kept
    |F| <= current D K                                  a driver that limits the motors' current
    |V| <= voltage K                                    a supply that ends, behind a speed loop (`supply`)

limit [1]: a setting of the kinematics node (`limit`, 0.1 to 1) or a supply that gives no more, softly with n = 4 / knee
[1]: 4 as is usual, down to 2 where it gives way early; of both drivers, or of the one that limit_side tells. turn [1]:
half the largest difference of the commands, as a base's largest angular speed allows it. current
[1]: the motor's largest force F [N] as a share of its stall force at full command, D K with the slope D [N s/m] of its
torque-speed line and the gain K [m/s]: the speed is reached, but late, and a slope is climbed with less. voltage [1]:
where the supply ends, as a share of the no-load speed at full command; on a robot that is told speeds (and has a weak
battery) it also cuts what the loop adds to speed up, `loop` [1] being the loop's gain over the motor's slope. Above
1.05 every set point is reached: so robots with a speed loop are built, and it is no finding. Null is 2 for all four:
never reached. Sources: Duckietown kinematics_node.py; ROS diff_drive_controller (angular.z.max_velocity), Kobuki and
Create drivers, mixers that scale both wheels alike; current regulation of H-bridges, e.g. TI DRV8871 data sheet,
section 7.3.2; Astrom & Hagglund, Advanced PID Control, 2006, section 3.5.
"""

from __future__ import annotations

from numba import njit

from fsm_calib.world2d.dynamics import CHARGE, GAIN
from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter
from fsm_calib.world2d.effects.speed_loop import AMPLE, NEVER, gain_of_the_loop
from fsm_calib.world2d.effects.wheels import is_the_others, of_one_driver_or_both
from fsm_calib.world2d.slots import CEILING, COMMAND, DRIVE, HELD, RIM, TARGET
from fsm_calib.world2d.supply import end_at, give_what_there_is

MIXERS = "ROS diff_drive_controller, parameter angular.z.max_velocity; base controllers that keep the curve"
OF_BOTH = {"limit_side": 0.0}
"""Where no command is cut the side is told by nothing."""
SOFTLY = "Commands beyond about {limit} give less and less more speed."


@njit(error_model="numpy")
def clip(P, o, u, side):
    """Return the command cut to the limit, if it is this driver's."""
    if is_the_others(P[o + 6], side) or P[o + 8] > 0.0:
        return u
    if P[o + 1] > 0.0:
        power = 4.0 / P[o + 3]
        return u / (1.0 + abs(u / P[o]) ** power) ** (1.0 / power)
    return min(max(u, -P[o]), P[o])


@njit(error_model="numpy")
def end_supply(P, o, W):
    """Tell where the supply ends, if it does."""
    if P[o + 4] < NEVER:
        end_at(P, W, P[o + 4], P[o + 5])


@njit(error_model="numpy")
def mix(P, o, W):
    """Cut both commands at once: alike where one is beyond the limit, and their difference to the largest turning."""
    left, right = W[COMMAND], W[COMMAND + 1]
    largest = max(abs(left), abs(right))
    if P[o + 8] > 0.0 and largest > P[o]:
        left, right = left * P[o] / largest, right * P[o] / largest
    mean, half = 0.5 * (left + right), 0.5 * (right - left)
    half = min(max(half, -P[o + 7]), P[o + 7])
    W[TARGET] += P[CHARGE] * P[GAIN] * (mean - half - W[COMMAND])
    W[TARGET + 1] += P[CHARGE] * P[GAIN + 1] * (mean + half - W[COMMAND + 1])
    W[COMMAND], W[COMMAND + 1] = mean - half, mean + half


@njit(error_model="numpy")
def give_no_more(P, o, S, m, W):
    """Cut the commands that are cut together; the motors' forces to what the limited current gives: their slope falls
    to the secant; and to what the supply gives, but where a controller with an integral does so itself
    (`speed_controller`).
    """
    if P[o + 8] > 0.0 or P[o + 7] < NEVER:
        mix(P, o, W)
    for side in range(2):
        if W[CEILING + side] > 0.0 and W[HELD] == 0.0:
            give_what_there_is(S, W, side, m)
        short, most = abs(W[TARGET + side] - S[RIM + side]), P[o + 2] * P[GAIN + side]
        if short > most:
            W[DRIVE + side] *= most / short


EFFECT = Effect(
    name="command_saturation",
    family="command map",
    summary="commands above a limit are cut",
    equation="u_eff = clip(u, -limit, limit)",
    parameters=(
        Parameter(
            "limit", "u_max", "1", NEVER, 0.05, 2.0, 0.4, "kinematics node: limit 0.1 to 1",
            starts=(0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.75, 0.9), step=1e-3,
        ),
        Parameter(
            "soft", "s", "1", 0.0, 0.0, 1.0, 0.0, "0 a hard limit, 1 a soft one", strength=False, fitted=False,
        ),
        Parameter(
            "current", "i_max", "1", NEVER, 0.02, 2.0, 2.0, "drivers: 0.2 to 0.6 of the stall current",
            starts=(0.08, 0.15, 0.3, 0.5), step=1e-3,
        ),
        Parameter(
            "knee", "k", "1", 1.0, 0.2, 2.0, 1.0, "2 gives way early, 0.2 nearly at once", strength=False, step=1e-2,
        ),
        Parameter(
            "voltage", "v_max", "1", NEVER, 0.05, 2.0, 2.0, "batteries lose a tenth to a third of their voltage",
            starts=(0.3, 0.45, 0.6, 0.75, 0.9, 1.0), step=1e-3, least=NEVER - AMPLE,
            as_built=1.0,  # no bridge gives more: it cuts what a motor stronger one way, or a driver that adds, is told
        ),
        gain_of_the_loop("loop", "p"),
        of_one_driver_or_both("limit_side", "d"),
        Parameter(
            "turn", "w_max", "1", NEVER, 0.02, 2.0, 2.0, "a base's largest angular speed",
            starts=(0.08, 0.15, 0.25, 0.4, 0.6), step=1e-3,
        ),
        Parameter(
            "together", "m", "1", 0.0, 0.0, 1.0, 0.0, "1 both are scaled alike, 0 each is cut", strength=False,
            fitted=False,
        ),
    ),
    hooks={"begin": end_supply, "shape": clip, "step": give_no_more},
    memory=2,
    channels=("forward", "turn"),
    regimes=("large_command",),
    separates="commands below the limit are untouched, those above all give the same speed",
    rivals=("motor_gain_curve", "motor_deadband"),
    manoeuvre="straights at five speeds up to full command",
    sentence="Commands beyond {limit} give no more speed.",
    source="Duckietown kinematics_node.py, parameter limit",
    input="command",
    closures=(
        Closure("hard limit", ("limit",), "cut at once", fixes={"soft": 0.0}),
        Closure(
            "soft limit", ("limit",), "gives way before it gives no more", fixes={"soft": 1.0},
            sentence=SOFTLY,
        ),
        Closure(
            "soft limit, own knee", ("limit", "knee"), "gives way as early as it does", fixes={"soft": 1.0},
            sentence=SOFTLY,
        ),
        Closure(
            "curve kept", ("limit",), "both wheels are scaled down alike",
            fixes={"soft": 0.0, "together": 1.0, **OF_BOTH},
            sentence="Where a command is beyond {limit} both are scaled down alike.", source=MIXERS,
        ),
        Closure(
            "turn limit", ("turn",), "the difference of the commands is cut, their mean is kept", fixes=OF_BOTH,
            sentence="The robot turns by no more than {turn} of half the commands' difference.", source=MIXERS,
        ),
        Closure(
            "current limit", ("current",), "the driver limits the current: speeds are reached late", fixes=OF_BOTH,
            sentence="The motors give no more than {current} of their stall force.",
            source="TI DRV8871 data sheet, section 7.3.2",
        ),
        Closure(
            "end of supply", ("voltage", "loop"), "a speed loop gets no more voltage than there is", fixes=OF_BOTH,
            sentence="The motors' supply ends at {voltage} of the speed at full command.",
            source="Astrom & Hagglund 2006, section 3.5",
        ),
    ),
    order=10,
    dissipative=True,
)  # fmt: skip
