"""`diagnose`: recordings in, verdict out. The one entry of this room for the command line."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from time import perf_counter

from fsm_calib.diagnosis.candidates.beyond_full import beyond_told, likelier_driven
from fsm_calib.diagnosis.candidates.charge import charges_told
from fsm_calib.diagnosis.candidates.jitter import jitter_told
from fsm_calib.diagnosis.candidates.late_sight import sight_told
from fsm_calib.diagnosis.candidates.speed_loop import loop_told
from fsm_calib.diagnosis.candidates.stiffness import stiffness_told
from fsm_calib.diagnosis.candidates.supply_end import supply_told
from fsm_calib.diagnosis.candidates.usual_loop import integral_told
from fsm_calib.diagnosis.fitting.bounds import at_bounds
from fsm_calib.diagnosis.intake import take_in
from fsm_calib.diagnosis.proof.gates import DEFAULT_GATES, Gates
from fsm_calib.diagnosis.proof.heldout import Comparison, compare
from fsm_calib.diagnosis.replay.prepared import prepare
from fsm_calib.diagnosis.replay.settings import DEFAULT_SETTINGS, Settings
from fsm_calib.diagnosis.replay.simulator import Simulator, make_simulator
from fsm_calib.diagnosis.verdict.coverage import Coverage, coverage_of
from fsm_calib.diagnosis.verdict.decide import Decision, decide
from fsm_calib.diagnosis.verdict.explain import verdict_of
from fsm_calib.diagnosis.verdict.recalled import Finding, findings_of
from fsm_calib.diagnosis.verdict.refute import refuted
from fsm_calib.diagnosis.verdict.verdict import Verdict
from fsm_calib.diagnosis.verdict.weight import untold_mass
from fsm_calib.recording.recording import Recording


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """A verdict with everything that it was drawn from, for reports; notes : what was done to the recordings first."""

    verdict: Verdict
    decision: Decision
    train: Comparison
    holdout: Comparison | None
    holdout_simulators: tuple[Simulator, ...]
    notes: tuple[str, ...] = ()


def told_by(decision: Decision, gates: Gates) -> Coverage:
    """Return what the drives of a decision can tell."""
    prepared = [s.prepared for s in decision.engine.simulators]
    return coverage_of(prepared, decision.bank.prober, decision.asked, gates.detect)


def diagnose(
    recordings: Sequence[Recording],
    holdouts: Sequence[Recording] = (),
    *,
    without: Iterable[str] = (),
    world: Mapping[str, float] | None = None,
    settings: Settings = DEFAULT_SETTINGS,
    gates: Gates = DEFAULT_GATES,
    progress: Callable[[str], None] = lambda part: None,
    seed: int = 0,
    earlier: Diagnosis | None = None,
) -> Diagnosis:
    """Compare recordings of one robot with the simulation and say what it leaves out.

    Parameters
    ----------
    recordings : what is fitted; holdouts : what is only predicted.
    without : names to leave out of the catalogue.
    world : physics that the simulation already has, values by full name (``motor_deadband.offset``); not re-fitted.
    seed : of the sign flips that give the location its significance.
    earlier : the answer to fewer of these recordings; what it had found is asked again from where it was found.

    Raises
    ------
    DataError
        A recording has no poses with headings, too few of them, or no input.
    """
    began = perf_counter()
    taken = take_in(recordings, holdouts, settings.processes)
    simulators = tuple(make_simulator(prepare(r, settings), world) for r in taken.train)
    new = tuple(make_simulator(prepare(r, settings), world) for r in taken.holdout)
    simulators, new = likelier_driven(simulators, new)
    read = perf_counter() - began
    found = _findings(earlier)
    decision = decide(simulators, without=without, gates=gates, progress=progress, seed=seed, earlier=found)
    decision.seconds["prepare"] = read
    began = perf_counter()
    progress("proof")
    train, holdout = _proof(decision, simulators, new)
    decision.seconds["proof"] = perf_counter() - began
    less = refuted(decision, train, holdout, new)
    if less.model.fit is not decision.model.fit:
        train, holdout = _proof(less, simulators, new)
    decision = less
    told = told_by(decision, gates)
    verdict = verdict_of(decision, train, holdout, horizon=settings.horizon, gates=gates)
    verdict = replace(verdict, drives=told)
    notes = (
        *taken.notes,
        *at_bounds(decision.base),
        *beyond_told(simulators),
        *loop_told(decision.model.fit),
        *supply_told(decision.model.fit),
        *integral_told(decision.model.fit),
        *sight_told(decision.model.fit),
        *stiffness_told(decision.model.fit),
        *charges_told(decision.model.fit),
        *jitter_told(decision.model.fit),
        *untold_mass(verdict.effects, simulators),
    )
    return Diagnosis(verdict, decision, train, holdout, new, notes)


def _findings(earlier: Diagnosis | None) -> tuple[Finding, ...]:
    """Return what an earlier answer had found, nothing where there is none."""
    if earlier is None:
        return ()
    decision = earlier.decision
    return findings_of(decision.model.effects, decision.model.fit, [b.name for b in decision.named])


def _proof(
    decision: Decision, simulators: Sequence[Simulator], new: Sequence[Simulator]
) -> tuple[Comparison, Comparison | None]:
    """Return the errors before and after, on the fitted recordings and on those held out, if any."""
    base, fit = decision.base, decision.model.fit
    return compare(simulators, base, fit, new=False), compare(new, base, fit, new=True) if new else None
