r"""The motor driver knows whole PWM numbers only, and rounds every command to one.

    u_effective = u + share (sgn(u) floor(levels |u| + nearest / 2) / levels - u)

u [1] command, levels [1] PWM numbers between none and full command, share [1] of the rounding that acts: 1 without
dithering, 0 where the sender spreads its commands so that their mean is right; nearest [1]: 0 rounds down, as a cast to
an integer does, 1 to the nearest. Assumes that the driver's fixed part (60 of 255) cancels the motor's own dead zone;
what is left of that is `motor_deadband`. Duckietown's driver sends floor(195 |u| + 60): one step is 2 % of a command of
0.23. Others know fewer steps, and nobody states how many: timers of few counts, port expanders, commands of whole
centimetres a second. Source: dagu_wheels_driver.py (dt-duckiebot-interface).
"""

from __future__ import annotations

import math

from numba import njit

from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter

FEWEST, FEW, MANY = 4.0, 40.0, 64.0
"""Steps from none to full command: fewer are a switch, and of more only the usual numbers are tried."""
APART = 0.6
"""Steps between numbers of steps that are tried: the largest command is off by a third of a step at most."""
USUAL = (100.0, 127.0, 128.0, 200.0, 255.0)
"""Of more, those that drivers are written with; that of Duckietown has a closure of its own."""
SEARCHED = (
    *(FEWEST + APART * i for i in range(round((FEW - FEWEST) / APART))),
    *(float(i) for i in range(int(FEW), int(MANY) + 1)),
    *USUAL,
)
ON_A_STEP = 1e-9
"""Of a step: a command that is a whole number but for rounding is that number."""


@njit(error_model="numpy")
def floor_to_step(P, o, u, side):
    """Return the command that the driver makes of it."""
    whole = math.floor(abs(u) * P[o + 1] + 0.5 * P[o + 2] + ON_A_STEP) / P[o + 1]
    return u + P[o] * (math.copysign(whole, u) - u)


FEW_STEPS = (
    "The driver knows {{levels}} steps up to full command and rounds commands {} "
    "(share {{share}} of the rounding acts)."
)


EFFECT = Effect(
    name="pwm_steps",
    family="command map",
    summary="commands are rounded to whole PWM numbers",
    equation="u_eff = u + share (sgn(u) floor(levels |u| + nearest/2)/levels - u)",
    parameters=(
        Parameter(
            "share",
            "q",
            "1",
            0.0,
            0.0,
            1.0,
            1.0,
            "1 as Duckietown's driver does, 0 with dithering",
            natural_end=True,
            starts=(1.0,),
        ),
        Parameter(
            "levels",
            "N",
            "1",
            195.0,
            1.0,
            65535.0,
            195.0,
            "Duckietown: 255 - 60; other drivers 100, 255 or 1023, software PWM 10 to 100",
            strength=False,
            fitted=False,
            searched=SEARCHED,
        ),
        Parameter(
            "nearest",
            "b",
            "1",
            0.0,
            0.0,
            1.0,
            0.0,
            "0: a cast to an integer, 1: rounded",
            strength=False,
            fitted=False,
        ),
    ),
    hooks={"shape": floor_to_step},
    channels=("forward", "turn"),
    regimes=("small_command", "one_wheel"),
    separates="what is missing is less than one step, and goes up and down with the command; a dead zone does not",
    rivals=("motor_deadband", "motor_gain_curve"),
    manoeuvre="slow straights at ten commands that lie a tenth of a step apart",
    sentence="The driver rounds commands down to whole PWM numbers (share {share} of the rounding acts).",
    source="Duckietown dagu_wheels_driver.py",
    input="command",
    closures=(
        Closure(
            "full",
            ("share",),
            "down to one of 195, as Duckietown's driver has them",
            fixes={"levels": 195.0, "nearest": 0.0},
        ),
        Closure(
            "few steps",
            ("share",),
            "down to one of few, of a number that nobody states",
            sentence=FEW_STEPS.format("down to one"),
            fixes={"nearest": 0.0},
        ),
        Closure(
            "few steps, rounded",
            ("share",),
            "to the nearest of few, of a number that nobody states",
            sentence=FEW_STEPS.format("to the nearest"),
            fixes={"nearest": 1.0},
        ),
    ),
    order=20,
)
