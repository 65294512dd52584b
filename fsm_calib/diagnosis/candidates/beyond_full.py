"""Do commands beyond full command drive the robot faster? Duties end there; speeds that a controller holds need not.

A logger notes what was asked for. Of a duty a bridge gives no more than all, whatever was asked, so that shares of full
command are cut at 1. A controller follows a set point of 1.15 as long as its supply has some to spare, as most have
(`candidates/supply_end.py`). Two robots of another engine that were told 1.14 and 1.15 of their full speed for 2 to 3 s
were said to have a motor that gains 14 % meanwhile (0.78), and to have been pushed (0.95). So where recordings have
such commands the base robot is fitted both ways, and what was asked drives it where that is clearly likelier; both
have the same numbers. Where neither is, all that a base robot may have decides: a controller that sees late won 5 units
as a plain base robot by 1.15 of full command for 2.4 s, and 413 with its loop; cut, it was said to have been pushed
(0.94). Of 48 robots of that engine the plain base robot is clear of 26: uncut it wins 8 to 441 units of log-likelihood
under ten controllers (-570 under one), and -8 to -211 where duties are told (17 of one). Of the others the whole one
wins 413, 35, 26 and no more than 2.3 under a controller, and 6.4 at most where duties are told.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from fsm_calib.diagnosis.candidates.whole_base import fit_whole_base
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.replay.simulator import Simulator, make_simulator
from fsm_calib.recording.channels import CommandTrack
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.rollout import Drive

BEYOND = 1.005  # share of full command: less is a logger's rounding
CLEARLY = (
    7.0  # log-likelihood units that an uncut drive must win: as evidence, twice that, what an effect needs
)

Simulators = tuple[Simulator, ...]


def likelier_driven(
    simulators: Sequence[Simulator], new: Sequence[Simulator]
) -> tuple[Simulators, Simulators]:
    """Return simulators, and those of recordings held out, driven by what was asked beyond full command or cut there,
    as the first ones tell.
    """
    cut = tuple(simulators), tuple(new)
    if not any(asks_beyond(s) for s in simulators):
        return cut
    uncut = tuple(map(_uncut, simulators)), tuple(map(_uncut, new))
    won = _won(uncut[0], cut[0], fit_base)
    if abs(won) <= CLEARLY:
        won = _won(uncut[0], cut[0], _whole)
    return uncut if won > CLEARLY else cut


def _won(simulators: Simulators, others: Simulators, fitted: Callable[[Engine], Fit]) -> float:
    """Return the log-likelihood that a robot of some simulators wins over that of others."""
    return fitted(Engine(simulators)).score - fitted(Engine(others)).score


def _whole(engine: Engine) -> Fit:
    """Return the base robot with all that it may have."""
    return fit_whole_base(engine, list(registry().values()))


def asks_beyond(simulator: Simulator) -> bool:
    """Return whether a recording has shares of full command beyond it."""
    track = simulator.prepared.recording.command
    if track is None or track.unit != "normalized":
        return False
    return _largest(track) > BEYOND


def _uncut(simulator: Simulator) -> Simulator:
    """Return a simulator that is driven by all that was asked."""
    return make_simulator(simulator.prepared, simulator.world, cut=False)


def beyond_told(simulators: Sequence[Simulator]) -> list[str]:
    """Return a sentence where robots were driven by what was asked beyond full command."""
    most = max((_largest(s.drive) for s in simulators if asks_beyond(s)), default=0.0)
    if most <= BEYOND:
        return []
    return [f"commands beyond full command (up to {most:.2f}) drive this robot faster: they are not cut"]


def _largest(commands: CommandTrack | Drive) -> float:
    """Return the size [share of full command] of the largest command of either wheel."""
    return float(np.abs([commands.left, commands.right]).max(initial=0.0))
