"""Numbers of which no derivative tells: each value is simulated, and the one that promises most is where a form starts.

The likelihood of how many steps a driver knows leaps: one step more moves some commands by a whole one. A number that
is half a step off at the largest command has another pattern altogether, so that values are tried as near as that, and
then nearer about the best. A value that is nearly right puts a few commands on the wrong step, and may win less than
nothing as it stands; with a smaller strength it promises something (a secant).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis, declared_starts
from fsm_calib.diagnosis.candidates.starts import Probe, Prober
from fsm_calib.world2d.effects import registry

FOLLOWED = (2, 1)  # of the values, about which nearer ones are tried, round by round
NEARER = 10  # values between the neighbours of one


def likeliest_values(prober: Prober, form: Hypothesis) -> dict[str, float]:
    """Return the values of a form's searched numbers that promise most, by full name."""
    found: dict[str, float] = {}
    for parameter in registry()[form.effect].choices:
        full = f"{form.effect}.{parameter.name}"
        values: Sequence[float] = parameter.searched
        if values and full not in form.held:
            for followed in FOLLOWED:
                in_order = np.argsort(_promises(prober, form, found, full, values))[::-1]
                values = [value for at in in_order[:followed] for value in _about(values, int(at))]
            found[full] = values[int(np.argmax(_promises(prober, form, found, full, values)))]
    return found


def _promises(
    prober: Prober, form: Hypothesis, given: dict[str, float], full: str, values: Sequence[float]
) -> list[float]:
    """Return the log-likelihood that a form promises with each value of a number."""
    start = declared_starts(form, given)[0]
    return [_promise(probe) for probe in prober.probes(form, [{**start, full: value} for value in values])]


def _promise(probe: Probe) -> float:
    return max(probe.declared.promise, probe.scaled.promise if probe.scaled else 0.0)


def _about(values: Sequence[float], at: int) -> list[float]:
    """Return values from one's lower to its upper neighbour, itself among them."""
    below, above = values[max(at - 1, 0)], values[min(at + 1, len(values) - 1)]
    return sorted({float(values[at]), *np.linspace(below, above, NEARER + 1).tolist()})
