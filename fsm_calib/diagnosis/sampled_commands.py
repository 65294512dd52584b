r"""Commands that a logger sampled: each change happened somewhere between a row and the row before.

A log with a row every 50 ms holds what the robot was told *last*, so that its commands stand there late, by half a row
in the mean, and the poses seem as much early. No robot answers early. So where rows are regular and most repeat the one
before, commands that the poses follow early are laid as much earlier, by a row at most. Commands of a robot whose own
loop wrote the log stand there when they were given, and stay.

A robot that is not quite the one that is fitted seems early, too: one whose motors are slower backwards by up to 50 of
80 ms. What tells is how it moves before a row that changes its command, after a quiet spell. With c the change of the
whitened innovations there that earlier commands make, r what the base robot leaves, w the robust weights,

    L = h sum w c r - h^2 / 2 sum w c^2,    h = 1/2

is the log-likelihood of half of that change (each row is late by its own) over none, summed over the recordings. Where
it tells nothing either way, only half a row is believed, which is what a logger with a clock of its own leaves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.fitting.fit import Engine
from fsm_calib.diagnosis.late_commands import fitted_delay, with_commands_moved
from fsm_calib.diagnosis.likelihood.robust import robust_weights
from fsm_calib.diagnosis.replay.prepared import prepare
from fsm_calib.diagnosis.replay.simulator import make_simulator
from fsm_calib.recording.channels import CommandTrack, TwistTrack
from fsm_calib.recording.recording import Recording
from fsm_calib.types import FloatArray
from fsm_calib.workers import each

FEWEST_ROWS = 50
LEAST_REGULAR, LEAST_REPEATED = 0.9, 0.5  # shares of the rows of a log that was sampled
SAME_STEP = 0.1  # of the usual step between rows
SURELY_EARLY = 3.0  # standard deviations of the fitted delay
QUIET = 0.4  # s without a change, after which what the robot does next is the next command's
HALF = 0.5
TOLD = 2.0  # log-likelihood units: two standard deviations
NEAR_HALF = 0.15  # of a row: a hundred changes have a mean within 0.03, the fit of a delay is off by as much


@dataclass(frozen=True)
class Early:
    """A log with a row every `step` [s] whose commands the poses follow `early` [s], surely or not; told : L above."""

    step: float
    early: float
    surely: bool
    told: float = 0.0

    @property
    def moved(self) -> float:
        """How much earlier [s] its commands are laid."""
        return float(np.clip(self.early, 0.0, self.step))


def with_changes_placed(
    recordings: Sequence[Recording], others: Sequence[Recording] = (), processes: int = 1
) -> tuple[list[Recording], list[Recording], list[str]]:
    """Return both lists with sampled commands where the poses follow them, and a sentence for each.

    recordings, others : drives of one robot with one logger; only `recordings` decide whether it sampled.
    processes : so many are worked on side by side.
    """
    both = [*recordings, *others]
    found = each(_early, both, processes)
    if not _were_sampled([early for early in found[: len(recordings)] if early is not None]):
        return list(recordings), list(others), []
    pairs = list(zip(both, found, strict=True))
    laid = [r if early is None else with_commands_moved(r, -early.moved) for r, early in pairs]
    told = [
        f"{r.source}: its commands were sampled every {1e3 * early.step:.0f} ms; they are laid "
        f"{1e3 * early.moved:.0f} ms earlier, where the poses follow them"
        for r, early in pairs
        if early is not None
    ]
    return laid[: len(recordings)], laid[len(recordings) :], told


def row_step(track: CommandTrack | TwistTrack) -> float | None:
    """Return the time [s] between the rows of a log that may be sampled; None of commands as they were sent."""
    if len(track) < FEWEST_ROWS:
        return None
    step = np.diff(track.time)
    usual = float(np.median(step))
    regular = float(np.mean(np.abs(step - usual) < SAME_STEP * usual))
    repeated = float(np.mean(~_changed(track)))
    return usual if regular >= LEAST_REGULAR and repeated >= LEAST_REPEATED else None


def _were_sampled(found: Sequence[Early]) -> bool:
    """Return whether early answers are a logger's: seen before the rows, or unseen and half a row in the mean."""
    if not any(early.surely for early in found):
        return False
    told = sum(early.told for early in found)
    share = float(np.mean([early.early / early.step for early in found]))
    return told > TOLD or (told > -TOLD and abs(share - HALF) < NEAR_HALF)


def _early(recording: Recording) -> Early | None:
    """Return how early the commands of a log that may be sampled are followed; None of others."""
    track = recording.commands
    step = row_step(track) if track is not None else None
    found = fitted_delay(recording) if step is not None and recording.pose is not None else None
    if track is None or step is None or found is None:
        return None
    delay, sd = found
    early = Early(step, -delay, -delay > SURELY_EARLY * sd)
    if not early.surely:
        return early
    return replace(early, told=_seen_before(recording, early.moved, _quiet_before(track), step))


def _seen_before(recording: Recording, early: float, changes: FloatArray, step: float) -> float:
    """Return L: what the rows' times before `changes` (k,) [s], each a `step` [s] long, say for earlier commands."""
    if not len(changes):
        return 0.0
    as_logged, moved = (
        make_simulator(prepare(r)) for r in (recording, with_commands_moved(recording, -early))
    )
    engine = Engine((as_logged,))
    base = fit_base(engine)
    (simulated,) = base.simulated
    time = as_logged.prepared.time
    ahead = changes[np.minimum(np.searchsorted(changes, time), len(changes) - 1)] - time
    before = (ahead >= 0.0) & (ahead < step)
    change = (moved.increments(base.values)[0] - simulated) * before[:, None]
    whiteners = engine.whiteners(base.noise)
    c = engine.white_columns(whiteners, [change[:, :, None]])[:, 0]
    r = engine.residual(whiteners, base.simulated)
    w = robust_weights(r, as_logged.prepared.settings.degrees_of_freedom)
    there = np.repeat(before, as_logged.prepared.scored.sum(axis=1))
    score, power = (float(np.sum((w * c * x)[there])) for x in (r, c))
    return HALF * score - 0.5 * HALF**2 * power


def _quiet_before(track: CommandTrack | TwistTrack) -> FloatArray:
    """Return the times (k,) [s] of the changes that follow a quiet spell."""
    changes = track.time[1:][_changed(track)]
    return np.asarray(changes[np.diff(changes, prepend=-np.inf) > QUIET])


def _changed(track: CommandTrack | TwistTrack) -> np.ndarray:
    """Return which rows (n - 1,) tell something else than the row before."""
    sides = (track.left, track.right) if isinstance(track, CommandTrack) else (track.v, track.omega)
    return np.asarray((np.diff(sides[0]) != 0.0) | (np.diff(sides[1]) != 0.0))
