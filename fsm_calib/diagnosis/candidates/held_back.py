"""A robot that something holds back: where fits start beside a base robot that is weaker than others of its speed.

Where drives are slow or turn on the spot, strong friction is for the base robot a motor of a half or a tenth of its
strength. No step of a fit leads from there to a strong motor that friction holds, since on the way both explain the
drives worse. So the starts of effects are tried with stronger motors, too:

    gains = 2^i base's  up to MOST stated,    strength = null + s (declared - null)         i >= 1, s in LARGER

gains [m/s] rim speed at full command; stated [m/s] of the robot's manifest; strength in its own unit. (A scrubbing tyre
of 0.27 N m under a Duckiebot in 26 s of spins and slaloms: 188 units of evidence from the base robot's gain of
0.05 m/s, 663 from a stronger motor's; friction of 0.06 N m, base 0.32 m/s: 545 and 647.)
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import product

from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis, scaled
from fsm_calib.diagnosis.fitting.values import with_values
from fsm_calib.diagnosis.replay.simulator import Simulator
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

WEAK, MOST = 0.6, 1.5  # of the stated speed at full command: batteries and motors of one make differ by less
LARGER = (1.0, 2.0, 4.0, 8.0)


def motors_to_try(simulators: Sequence[Simulator], values: FloatArray) -> list[float]:
    """Return by how much [1] motors are to be stronger than those of a base robot (R, p); none where it is not weak.

    Measured wheels have no motor before them. Beside an effect motors may be weak because it is strong: those of a
    driver that lifts small commands have a quarter of their stated speed.
    """
    stated, now = simulators[0].full_speed, float(values[0, _gains()].mean())
    active = parameter_table().active_effects(values[0])
    explained = any(registry()[name].family != "base" for name in active)
    if simulators[0].measured_input or explained or now >= WEAK * stated:
        return []
    doublings = int(math.log2(MOST * stated / now))
    return [2.0**i for i in range(1, doublings + 1)]


def stronger(
    values: FloatArray, form: Hypothesis, choices: Sequence[Mapping[str, float]], motors: Sequence[float]
) -> list[FloatArray]:
    """Return parameters (R, p) of starts of a form with stronger motors and larger strengths than `values` (R, p)."""
    effect, tried = registry()[form.effect], []
    for choice, gain, size in product(choices, motors, LARGER):
        changed = with_values(values, scaled(effect, choice, size), form.run)
        changed[:, _gains()] *= gain
        tried.append(changed)
    return tried


def _gains() -> list[int]:
    table = parameter_table()
    return [table.place(f"gain_{side}") for side in ("left", "right")]
