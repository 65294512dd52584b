"""Would a slippery spot do what a smaller grip of the whole floor does? Then tyres are as usual, and the spot is there.

Where other effects hide a spot, a grip of the whole floor may be free that stands in for it: on a Drake robot it was
worth 31 units of log-likelihood beside dry friction and a load, the spot 72 in its place and nothing beside it. So a
selection on tyres whose grip is free is asked once more with the usual grip and a spot, and grows on where that is
likelier.
"""

from __future__ import annotations

from dataclasses import replace

from fsm_calib.diagnosis.candidates.free_number import found_free, with_held
from fsm_calib.diagnosis.candidates.ranked import evidence_of, strongest
from fsm_calib.diagnosis.candidates.ranking import Bank
from fsm_calib.diagnosis.fitting.fit import Fit
from fsm_calib.diagnosis.verdict.selection import Selection, Selector
from fsm_calib.world2d.parameters import parameter_table

GRIP = "friction"


def likelier_if_gripping(selector: Selector, selection: Selection) -> tuple[Selector, Selection]:
    """Return the selection on usual tyres with a spot where that is likelier, with its selector; else both as given."""
    named = {e.name for e in selection.effects}
    spots = [e for e in selector.catalogue if e.acts_on == "grip" and e.name not in named]
    if not spots or len(named) >= selector.most or not found_free(selection.fit, GRIP):
        return selector, selection
    engine, held = selector.engine, _of_usual_grip(selector, selection.fit)
    spot = strongest(found for found in map(Bank.on(engine, held).best_of, spots) if found)
    if spot is None or evidence_of(spot.fit, selection.fit, engine.count) <= 0.0:
        return selector, selection
    usual = replace(selector, base=_of_usual_grip(selector, selector.base))
    other = usual.grown_from((*selection.effects, spot), spot.fit, selection.rankings)
    likelier = evidence_of(other.fit, selection.fit, engine.count) > 0.0
    return (usual, other) if likelier else (selector, selection)


def _of_usual_grip(selector: Selector, fit: Fit) -> Fit:
    """Return the fit with the usual grip of the tyres, everything else and the noise fitted again."""
    table = parameter_table()
    held = with_held(fit, GRIP, table.null[table.place(GRIP)])
    return selector.with_noise(selector.engine.fit(held.values, held.slots, fit.noise))
