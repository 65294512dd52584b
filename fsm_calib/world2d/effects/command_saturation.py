r"""Commands above a limit are cut.

    u_effective = min(max(u, -limit), limit)
    u_effective = u / (1 + (|u| / limit)^4)^(1/4)       soft: a supply that gives way before it gives no more

limit [1]: a setting of the kinematics node (`limit`, 0.1 to 1) or a supply that gives no more. Null is 2:
never reached. Source: Duckietown kinematics_node.py.
"""

from __future__ import annotations

from numba import njit

from fsm_calib.world2d.effects.effect import Closure, Effect, Parameter


@njit(error_model="numpy")
def clip(P, o, u, side):
    """Return the command cut to the limit."""
    if P[o + 1] > 0.0:
        size = u / P[o]
        return u / (1.0 + size**4) ** 0.25
    return min(max(u, -P[o]), P[o])


EFFECT = Effect(
    name="command_saturation",
    family="command map",
    summary="commands above a limit are cut",
    equation="u_eff = clip(u, -limit, limit)",
    parameters=(
        Parameter(
            "limit", "u_max", "1", 2.0, 0.05, 2.0, 0.4, "kinematics node: limit 0.1 to 1",
            starts=(0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.6, 0.75, 0.9), step=1e-3,
        ),
        Parameter(
            "soft", "s", "1", 0.0, 0.0, 1.0, 0.0, "0 a hard limit, 1 a soft one", strength=False, fitted=False,
        ),
    ),
    hooks={"shape": clip},
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
            sentence="Commands beyond about {limit} give less and less more speed.",
        ),
    ),
    order=10,
    dissipative=True,
)  # fmt: skip
