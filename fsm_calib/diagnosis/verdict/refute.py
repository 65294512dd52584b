"""A match must hold: on the fitted recordings and on those that took no part in the fit, in their tails."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from fsm_calib.diagnosis.proof.heldout import Comparison
from fsm_calib.diagnosis.proof.holds import Breach, breach_of
from fsm_calib.diagnosis.replay.simulator import Simulator
from fsm_calib.diagnosis.shapes.locate import Location
from fsm_calib.diagnosis.verdict.decide import Decision


def refuted(
    decision: Decision, train: Comparison, holdout: Comparison | None, new: Sequence[Simulator]
) -> Decision:
    """Return the decision, `unexplained` where it was a match that some stretch of a recording contradicts.

    new : the simulators of the held-out recordings.
    """
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


def _located(location: Location, breach: Breach) -> Location:
    """Return the location with the stretch as its time, and the place where the robot was."""
    where = {"x": breach.x, "y": breach.y, "radius": breach.radius}
    return replace(location, when=((breach.start, breach.end),), where=where)
