"""A match must hold, in the tails too, a name must not make the prediction worse, and what stays beside it is told."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from fsm_calib.diagnosis.proof.heldout import Comparison
from fsm_calib.diagnosis.proof.holds import Breach, breach_of
from fsm_calib.diagnosis.replay.simulator import Simulator
from fsm_calib.diagnosis.shapes.locate import Location
from fsm_calib.diagnosis.verdict.decide import Decision
from fsm_calib.diagnosis.verdict.model import bare_model

WORSE = 1.1  # times the base robot's error over the horizon in one channel, with the other no better: that is no cure
ABOVE_FLOOR = 1.5  # times the noise's floor: a model that lacks nothing errs within a tenth of the floor


def refuted(
    decision: Decision, train: Comparison, holdout: Comparison | None, new: Sequence[Simulator]
) -> Decision:
    """Return the decision, `unexplained` where it was a match that some stretch of a recording contradicts.

    So is a decision whose names make the prediction of held-out recordings worse; its model is then the base robot.
    Names that hold but leave errors far above the noise's are told to be not all.
    new : the simulators of the held-out recordings.
    """
    if decision.outcome == "explained":
        kept = _unless_worse(decision, holdout) if holdout is not None else decision
        return _with_what_stays(kept, holdout or train) if kept.outcome == "explained" else kept
    if decision.outcome != "match":
        return decision
    fitted = decision.engine.simulators
    breach, of = breach_of(train.windows_before, fitted), fitted
    advice = "drive there again, slowly and on several headings"
    if breach is None and holdout is not None:
        breach, of = breach_of(holdout.windows_before, new), tuple(new)
        advice = "fit that recording, too"
    if breach is None:
        return decision
    name = of[breach.recording].prepared.name
    reason = (
        f"the re-fitted base robot explains the drives but for one stretch: {name} from {breach.start:.0f} to "
        f"{breach.end:.0f} s near ({breach.x:.2f} m, {breach.y:.2f} m), where its errors are {breach.ratio:.1f} times "
        f"the noise; {advice}"
    )
    return replace(
        decision, outcome="unexplained", reason=reason, location=_located(decision.location, breach)
    )


def _unless_worse(decision: Decision, seen: Comparison) -> Decision:
    """Return the decision; `unexplained` by the base robot where the model's errors are larger than the base's."""
    pairs = (
        ("cm", 100.0, seen.before.xy_m, seen.after.xy_m),
        ("rad", 1.0, seen.before.theta_rad, seen.after.theta_rad),
    )
    ratios = [after / before for _, _, before, after in pairs if before > 0.0]
    if not ratios or max(ratios) < WORSE or min(ratios) < 1.0:
        return decision
    unit, scale, before, after = max(pairs, key=lambda pair: pair[3] / pair[2] if pair[2] > 0.0 else 0.0)
    names = " and ".join(b.name for b in decision.named)
    reason = (
        f"{names} would be named, but with it the errors on the held-out recordings rise from {scale * before:.3g} to "
        f"{scale * after:.3g} {unit}: what it explains there is something else"
    )
    model = bare_model(decision.engine, decision.base, decision.location)
    return replace(decision, outcome="unexplained", reason=reason, named=(), model=model)


def _with_what_stays(decision: Decision, seen: Comparison) -> Decision:
    """Return the decision; where its model errs far above the noise's floor, the reason says that more is missing."""
    pairs = ((seen.after.xy_m, seen.floor.xy_m), (seen.after.theta_rad, seen.floor.theta_rad))
    times = max((after / floor for after, floor in pairs if floor > 0.0), default=0.0)
    if times < ABOVE_FLOOR:
        return decision
    said = f"{decision.reason}, but errors stay at {times:.1f} times the noise's floor: more is missing"
    return replace(decision, reason=said)


def _located(location: Location, breach: Breach) -> Location:
    """Return the location with the stretch as its time, and the place where the robot was."""
    where = {"x": breach.x, "y": breach.y, "radius": breach.radius}
    return replace(location, when=((breach.start, breach.end),), where=where)
