"""Do commands come early or late at random? What carries them (a radio link, a control loop's tick) is never punctual.

A command that is late by d leaves the robot d times the change of its speed behind: 5 mm and 3 deg for 25 ms, an order
more than the noise of good poses. Taken for nothing else it looks like a push, or a noise that hides what is faint. So
the noise of lateness (`Noise.jitter`) is free where it has strong evidence.
"""

from __future__ import annotations

from dataclasses import replace

from fsm_calib.diagnosis.candidates.free_number import NEEDED, STEPS
from fsm_calib.diagnosis.candidates.ranked import evidence_of
from fsm_calib.diagnosis.fitting.base import SPEED_NOISE
from fsm_calib.diagnosis.fitting.fit import Engine, Fit

START = 0.01  # s
TOLD = 0.003  # s: below it no drive at a small robot's speeds is off by more than a millimetre
ROUNDS = 2  # of noise and numbers in turn


def with_jitter(engine: Engine, base: Fit) -> Fit:
    """Return the base with a jitter of its commands where that has strong evidence."""
    fit = _beginning_at(engine, base, START)
    return fit if evidence_of(fit, base, engine.count) >= NEEDED else base


def without_jitter(engine: Engine, fit: Fit) -> Fit:
    """Return the fit for commands that are punctual: what they leave is noise of the speeds again."""
    return _beginning_at(engine, fit, 0.0)


def _beginning_at(engine: Engine, fit: Fit, jitter: float) -> Fit:
    """Return the fit from a jitter [s] on, numbers and noise in turn; one of 0 stays."""
    fit = engine.fit(fit.values, fit.slots, replace(fit.noise, jitter=jitter), steps=STEPS)
    for _ in range(ROUNDS):
        fit = engine.refit_noise(fit, SPEED_NOISE, 4)
        fit = engine.fit(fit.values, fit.slots, fit.noise, steps=STEPS)
    return fit


def is_clear(fit: Fit) -> bool:
    """Return whether the jitter of a fit is large enough to be told, and for an effect to be hidden by it."""
    return fit.noise.jitter >= TOLD


def jitter_told(fit: Fit) -> list[str]:
    """Return a sentence where the robot answers as to commands that come clearly early or late."""
    if not is_clear(fit):
        return []
    late = 1e3 * fit.noise.jitter
    return [
        f"the robot answers as if its commands came early or late by {late:.0f} ms at random: that is counted as noise"
    ]
