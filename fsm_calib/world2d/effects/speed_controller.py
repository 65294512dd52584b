r"""The robot's own controller holds each wheel's speed: proportional and integral, with a weight on the set point.

    T = weight w_s + z,        dz/dt = hold (w_s - w)

T [m/s] no-load rim speed that the motor is driven with, w_s [m/s] set point (gain times command), w [m/s] rim speed,
z [m/s] what the integral adds, hold [1/s] integral over proportional gain, weight [1] the share of the set point that
acts at once. With a motor F = D_m (duty w_0 - w), w_0 its free speed, and a controller that gives the duty
(c w_s + p (w_s - w) + i int (w_s - w) dt) / w_0, this is the base robot's motor with D = D_m (1 + p), and hold =
i / (1 + p), weight = (c + p) / (1 + p): the stiffness goes into its time constants, the integral remains. It overshoots
after each step of the set point, and no lasting load slows the wheels down: friction, slopes and drag show for a moment
only. Where a wheel that is told to rest is slower than `STILL`, the integral dies away within the time let_go [s] (over
1 - |w| / STILL, so that nothing jumps), as firmware lets its motors go so that nothing creeps (assumed); firmware that
drops its integral as soon as it is told to rest, however fast the wheel still is, is the choice drops = 1. The supply
ends at `ceiling` [1] of the no-load speed at full command (2: never), which cuts what a loop of the gain loop = p [1]
adds to speed up (`world2d.supply`); there the integral grows no further (Astrom & Hagglund, Advanced PID Control, 2006,
section 3.5). Below 1.05 set points may be out of reach, which is a finding (`command_saturation`). The integral's
memory is a way: z = hold (the way asked for - the way rolled). Firmware may hold it within bounds, |z| <= most K, K
[m/s] the no-load speed at full command and most [1] the bound (2: none): a load that asks for more slows the wheels.

No controller is at once: it counts ticks over a period, smooths them, and holds what it gives for a period. It sees the
speed late by `lag` t_f [s], about two periods, and set points act half as late, about one (`WAIT`). The loop's part
p (w_s - w) is then p (w_s - w_f), so that

    T = weight w_s(t - t_f / 2) + z + p / (1 + p) (w - w_f),        t_f dw_f/dt = w - w_f

which overshoots after every step of the set point, the more the stiffer the loop is.

Robots that are told velocities (ROS) have one; those that are told duties (a Duckiebot) have none. It is how a robot is
built, not what is wrong with it: of the base family, set free by `diagnosis.candidates.speed_loop`, `supply_end`,
`late_sight` and `usual_loop`.
Source: Astrom & Murray, Feedback Systems, 2nd ed. 2021, sections 11.1 and 11.5 (weights of the set point).
"""

from __future__ import annotations

import math

from numba import njit

from fsm_calib.world2d.decay import gone
from fsm_calib.world2d.dynamics import GAIN
from fsm_calib.world2d.effects.effect import Effect, Parameter
from fsm_calib.world2d.effects.speed_loop import NEVER, gain_of_the_loop
from fsm_calib.world2d.slots import ANGLE, CEILING, HELD, RADIUS, RIM, STEP, TARGET
from fsm_calib.world2d.supply import end_at, give_what_there_is

WAIT = 0.5
"""How late a set point acts, over how late a speed is seen [1]. A set point waits half a period until it is read and is
held for half of one; a speed is half a period old where ticks are counted, another half where it is held, and smoothing
it with those before takes a whole one more (assumed)."""
STILL, REST = 0.01, 1e-5
"""A wheel that is slower than the one [m/s] stands, one that is told less than the other is told to rest (assumed)."""


@njit(error_model="numpy")
def take_hold(P, o, W):
    """Tell that a controller holds the speeds, and where its supply ends if no weaker one was told of before."""
    W[HELD] = 1.0
    if P[o + 3] < NEVER and W[CEILING] == 0.0:
        end_at(P, W, P[o + 3], P[o + 4])


@njit(error_model="numpy")
def hold_speed(P, o, S, m, W):
    """Drive each motor by its set point and by how far it is behind the way that it should have rolled."""
    hold, step = P[o], W[STEP]
    for side in range(2):
        way, wanted, rim = m + side, W[TARGET + side], S[RIM + side]
        rolled = W[RADIUS + side] * S[ANGLE + side]
        if P[o + 7] < NEVER:
            reach = P[o + 7] * P[GAIN + side] / P[o]
            S[way] = min(max(S[way], rolled - reach), rolled + reach)
        if abs(wanted) < REST and P[o + 6] > 0.0:
            S[way] = rolled
        elif abs(wanted) < REST and abs(rim) < STILL:
            rate = (1.0 - abs(rim) / STILL) / P[o + 2]
            S[way] = rolled + (S[way] - rolled) * math.exp(-step * rate)
        W[TARGET + side] = P[o + 1] * wanted + hold * (S[way] - rolled + 0.5 * step * (wanted - rim))
        if P[o + 5] > 0.0:
            W[TARGET + side] += see_late(P, o, S, m + 4 + side, rim, step)
        grows = (wanted - rim) * (W[TARGET + side] - rim) > 0.0
        stays = give_what_there_is(S, W, side, m + 2) if W[CEILING + side] > 0.0 else 0.0
        S[way] += step * (wanted + stays * (rim - wanted) if grows else wanted)


@njit(error_model="numpy")
def see_late(P, o, S, m, rim, step):
    """Return what a loop that sees the speed late asks for beyond one that sees it at once; keep what it sees."""
    late = P[o + 4] / (1.0 + P[o + 4]) * (rim - S[m])
    S[m] += gone(step / P[o + 5]) * (rim - S[m])
    return late


@njit(error_model="numpy")
def wait(P, o):
    """Return how late the controller takes set points [s]."""
    return WAIT * P[o + 5]


EFFECT = Effect(
    name="speed_controller",
    family="base",
    summary="a controller holds the wheels' speeds (where the base's motors are driven with duties)",
    equation="T = weight w_s + z, dz/dt = hold (w_s - w)",
    parameters=(
        Parameter(
            "hold", "k_i/k_p", "1/s", 0.0, 0.0, 40.0, 4.0, "settles within a second: 1 to 20", starts=(4.0,)
        ),
        Parameter(
            "weight", "beta", "1", 1.0, 0.0, 1.5, 1.0, "0 to 1; 1 with a full feed-forward", strength=False
        ),
        Parameter(
            "let_go", "t_0", "s", 0.05, 0.001, 1000.0, 0.05, "assumed; firmware lets its motors go soon after a stop",
            strength=False, fitted=False,
        ),
        Parameter(
            "ceiling", "v_max", "1", NEVER, 0.05, 2.0, 2.0, "motors have a tenth to a half more than is asked of them",
            strength=False, starts=(1.3, 1.1), step=1e-3,
        ),
        gain_of_the_loop("loop", "p"),
        Parameter(
            "lag", "t_f", "s", 0.0, 0.0, 0.3, 0.0, "ticks of 10 to 50 ms, smoothed", strength=False,
            starts=(0.012, 0.04), step=1e-3,
        ),
        Parameter(
            "drops", "b", "1", 0.0, 0.0, 1.0, 0.0, "0: at a stand, 1: when told to rest (ROSArduinoBridge, resetPID)",
            strength=False, fitted=False,
        ),
        Parameter(
            "most", "z_max", "1", NEVER, 0.01, 2.0, 2.0, "bounds of integrals (ros_control's i_clamp): 0.1 to 0.5",
            strength=False, starts=(0.3, 0.1), step=1e-3,
        ),
    ),
    hooks={"delay": wait, "begin": take_hold, "step": hold_speed},
    memory=6,
    channels=("forward", "turn"),
    regimes=("transient", "starting", "stopping"),
    separates="the wheels overshoot after each step of the command, and no lasting load slows them down",
    rivals=("motor_asymmetric_lag", "command_delay", "motor_deadband"),
    manoeuvre="steps between speeds, and a pause after each",
    sentence="A controller holds the wheels' speeds, with an integral of {hold}.",
    source="Astrom & Murray, Feedback Systems, 2nd ed. 2021, section 11.5",
    input="command",
    order=47,
)  # fmt: skip
