"""Does a controller hold the wheels' speeds? Robots that are told velocities have one, those told duties have none.

Nobody logs it, every velocity-controlled robot does it: the wheels overshoot after each step of the command, for some
tenths of a second, and no lasting load slows them down. Left out, it costs 90 to 5,600 units of log-likelihood on such
robots and buries what is to be found (an eccentric wheel, play in the gears) in noise of turning that is five times as
large; lags, batteries and dead zones then take the blame. On robots that are told duties an integral this fast has no
evidence. A slow one would have up to 70 units there, for dry friction; but no robot settles over many seconds, so that
its speed has bounds. As every number of the base it is free where it has strong evidence, and gives way to an effect
that does its whole job: a delay of half a second rings in the same way.
"""

from __future__ import annotations

from dataclasses import replace

from fsm_calib.diagnosis.candidates.free_number import (
    NEEDED,
    evidence_of_freed,
    found_free,
    unless_stood_in,
    with_free,
)
from fsm_calib.diagnosis.candidates.ranked import evidence_of
from fsm_calib.diagnosis.candidates.rivals import Rivals
from fsm_calib.diagnosis.fitting.base import settled, slot_of
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.fitting.slot import Slot
from fsm_calib.world2d.effects.speed_controller import EFFECT
from fsm_calib.world2d.parameters import parameter_table

HOLD, WEIGHT, DROPS = (f"{EFFECT.name}.{name}" for name in ("hold", "weight", "drops"))
SLOWEST = 0.8  # 1/s: what is missing of the speed is made up for within some seconds, or nobody would call it control
CLEARLY = 1.05  # times the slowest, or the fastest: what ends at its bound is something else
START, BARE = 4.0, 0.5  # 1/s; 1: the set point's weight of a controller without feed-forward


def with_speed_loop(engine: Engine, base: Fit, rivals: Rivals) -> Fit:
    """Return the base with the integral of a speed controller, where that has strong evidence.

    rivals : effects that are asked whether one does as well.
    """
    return unless_stood_in(engine, base, lambda fit: with_free_loop(engine, fit), rivals)


def with_free_loop(engine: Engine, fit: Fit) -> Fit:
    """Return a fit with the controller's integral free, and with the weight of its set point where that is better.

    The weight has its say only where the integral alone has: both together make a delay, a dead zone or a lag of two
    stages out of robots that are told duties (10 to 3,400 units on 16 of 36; alone it ended at its bound in all).
    Without the integral what it does counts as noise, so that noise and numbers are fitted in turn from then on.
    """
    alone = with_free(engine, fit, [_hold_slot()], (START,))
    if not is_clear(engine, alone, fit):
        return fit
    tried = alone, _with_weight(engine, fit)
    free = max(
        (settled(engine, free) for free in tried), key=lambda free: evidence_of(free, fit, engine.count)
    )
    return with_likelier_rest(engine, free)


def with_likelier_rest(engine: Engine, fit: Fit) -> Fit:
    """Return a fit of a robot that holds its speeds, with another law of its integral at rest where that is likelier.

    Firmware keeps it until the wheel stands, or drops it as soon as it is told to rest. Kept, it drives the wheel back
    over the stop for half a second, against dry friction that holds it: a clean robot was said to have been pushed
    (external_push 0.87). Beside friction that is not in the model yet a kept one may seem likelier, and is not.
    """
    place = parameter_table().place(DROPS)
    values = fit.values.copy()
    values[:, place] = 1.0 - values[:, place]
    other = settled(engine, replace(fit, values=values))
    return other if evidence_of(other, fit, engine.count) >= NEEDED else fit


def with_bare_loop(engine: Engine, fit: Fit, rivals: Rivals) -> Fit:
    """Return a fit with the integral of a controller that has no feed-forward, where that has strong evidence.

    Asked beside the first effect: against dry friction such a controller winds up before the wheels turn, so that
    neither shows without the other (on one robot 48 units of log-likelihood without friction, 1,040 beside it; 90 to
    2,500 on seven robots of three engines).

    rivals : effects that are asked whether one does as well.
    """

    def freed(fit: Fit) -> Fit:
        free = _with_weight(engine, fit)
        return with_likelier_rest(engine, settled(engine, free)) if is_clear(engine, free, fit) else fit

    return unless_stood_in(engine, fit, freed, rivals)


def _hold_slot() -> Slot:
    return replace(slot_of(HOLD), low=SLOWEST)


def _with_weight(engine: Engine, fit: Fit) -> Fit:
    """Return a fit with the integral and the weight of the set point free."""
    return with_free(engine, fit, [_hold_slot(), slot_of(WEIGHT)], ((START, BARE),))


def is_clear(engine: Engine, free: Fit, fit: Fit) -> bool:
    """Return whether a freed integral has strong evidence, and is none that would take many seconds, or no time."""
    slot = slot_of(HOLD)
    is_usual = CLEARLY * SLOWEST <= float(free.values[0, slot.place]) <= slot.high / CLEARLY
    return is_usual and evidence_of_freed(engine, free, fit) >= NEEDED


def loop_told(fit: Fit) -> list[str]:
    """Return a sentence where the robot turned out to hold its wheels' speeds by a controller."""
    drops = fit.values[0, parameter_table().place(DROPS)] > 0.0
    rest = ", which it drops as soon as it is told to rest" if drops else ""
    return [
        f"a controller holds the wheels' speeds (integral {value:.2g} +- {sd:.1g} 1/s{rest}, found from how the wheels "
        "overshoot): lasting loads do not slow this robot down"
        for _, value, sd in found_free(fit, HOLD)
    ]
