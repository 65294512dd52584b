"""Where on the floor, or when, could it be? Scans that give place and event effects their starts.

Where the effect on the increments is nearly linear (drag inside an area, a weak motor during a span: `scan_spans.py`)
it is written down to first order, all candidates pass the whitening filter as columns, and what each could win is one
small projection. Slides, turned markers and kicks are not: they have scans of their own (`scan_slides.py`,
`scan_markers.py`, `scan_pushes.py`). Scans are chosen by what an effect declares (`where`, `when`, `acts_on`), and
what has none of its own is tried out by simulation (`scan_default.py`). The winners, kept apart from each other, become
starts of full fits.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import product

import numpy as np

from fsm_calib.diagnosis.candidates.candidate import FAINT, GROWTH, Candidate
from fsm_calib.diagnosis.candidates.distinct import apart
from fsm_calib.diagnosis.candidates.fault_search import FaultSearch
from fsm_calib.diagnosis.candidates.outstanding import MOMENTS, by_chance
from fsm_calib.diagnosis.candidates.push_search import PushSearch
from fsm_calib.diagnosis.candidates.scan_areas import Area, boxes, drag_columns, settled, strips, wide_boxes
from fsm_calib.diagnosis.candidates.scan_default import (
    MOMENTS_APART,
    Trial,
    tried_moments,
    tried_places,
    tried_span,
)
from fsm_calib.diagnosis.candidates.scan_markers import (
    FROM_ONE_SIDE,
    HEADING,
    SHIFTED,
    TURNED,
    Jumps,
    Wrong,
    jumps_of,
    likely_discs,
)
from fsm_calib.diagnosis.candidates.scan_pushes import STEP
from fsm_calib.diagnosis.candidates.scan_slides import Slides
from fsm_calib.diagnosis.candidates.scan_tried import tried_out
from fsm_calib.diagnosis.fitting.fit import Fit
from fsm_calib.diagnosis.fitting.side_by_side import side_by_side
from fsm_calib.diagnosis.replay.passage import Passages, passages_of
from fsm_calib.diagnosis.replay.robot_size import robot_size
from fsm_calib.diagnosis.replay.simulator import Simulator, scale_of
from fsm_calib.diagnosis.replay.situation import Situation
from fsm_calib.diagnosis.shapes.features import place_centres
from fsm_calib.diagnosis.shapes.score_tests import NO_POWER, Residual
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import Effect
from fsm_calib.world2d.parameters import parameter_table

PITCH = 0.12  # m between candidate centres: a third of a common patch's diameter
KEEP = 3
KEEP_WIDE = 2  # of the rugs and lawns, beside the spots and strips
MARKERS_TRIED = 30  # discs by their jumps, of which the poses then choose
SHIFTED_TRIED = 120  # the same of shifted ones, where three numbers make jumps of chance larger
ONE_SIDE_TRIED = 6  # the same of those that are seen from one side, for each
CHUNK = 32
RIDGE = 1e-9  # of its power, added to a candidate's own


@dataclass(frozen=True, eq=False)
class Scanner:
    """Scans against one parent fit; worth : log-likelihood below which nobody will ask for a candidate.

    It remembers what it found: whether an effect is worth asking for is told by the scan that gives its starts.
    """

    simulators: tuple[Simulator, ...]
    situations: list[Situation]
    parent: Fit
    residual: Residual
    worth: float = 0.0
    _found: dict[str, list[Candidate]] = field(default_factory=dict, init=False, repr=False)

    @cached_property
    def passages(self) -> list[Passages]:
        """The parent model in each recording, ready to be rolled out for some seconds."""
        return passages_of(self.simulators, self.parent.values, self.parent.simulated)

    def candidates(self, effect: Effect) -> list[Candidate]:
        """Return the places or times of an effect that promise most; none where it acts anywhere and always."""
        scan = scan_of(effect)
        if scan is None:
            return []
        if effect.name not in self._found:
            self._found[effect.name] = scan(self, effect)
        return self._found[effect.name]

    def look_for(self, effects: Sequence[Effect]) -> None:
        """Look for several effects at once, each in a process of its own, and remember what is found."""
        new = [e for e in effects if scan_of(e) is not None and e.name not in self._found]
        engine = self.residual.engine
        if len(new) > 1 and engine.processes > 1:
            self.passages  # noqa: B018  # made once, for all of them
            self._found.update(
                zip([e.name for e in new], side_by_side(engine, self.candidates, new), strict=True)
            )

    def hopeless(self, promise: float) -> bool:
        """Return whether a candidate promises too little even if it still grows."""
        return GROWTH * promise < self.worth

    def scores(self, blocks: Sequence[FloatArray]) -> tuple[FloatArray, FloatArray]:
        """Return promise (c,) and amplitude (c,) of candidates with a column each."""
        total = blocks[0].shape[2]
        parts = [slice(i, min(total, i + CHUNK)) for i in range(0, total, CHUNK)]
        found = [self._scores([b[:, :, part] for b in blocks]) for part in parts]
        return np.concatenate([p for p, _ in found]), np.concatenate([a for _, a in found])

    def _scores(self, blocks: Sequence[FloatArray]) -> tuple[FloatArray, FloatArray]:
        """Return `scores` of a chunk; projected products come from the products of what is projected out."""
        r = self.residual
        white = r.engine.white_columns(r.whiteners, blocks)
        inside = r.basis.T @ white
        score = white.T @ r.psi - inside.T @ r.psi_inside
        power = np.sum(white * white, axis=0) - np.sum(inside * inside, axis=0)
        amplitude = score / ((1.0 + RIDGE) * np.maximum(power, NO_POWER))
        return 0.5 * score * amplitude, amplitude

    def places(self) -> FloatArray:
        """Return candidate centres (m, 2) [m]."""
        return place_centres(self.situations, self.size * PITCH)

    @property
    def size(self) -> float:
        """How large the robot is beside a small one [1]."""
        return robot_size(self.situations[0].half)

    def drag_areas(self, effect: Effect) -> list[Candidate]:
        """Return areas of rough floor, by what a drag in them changes to first order.

        Where a controller holds the speeds a drag shows for a moment only, and a column of a lasting loss tells
        little: a mat that wins 313 units as it stands promised 2. There areas are tried by simulation, too; the two
        promise by other measures, so that the best of each promises as much as any.
        """
        by_columns = self._dragging_areas(effect)
        if "speed_controller" not in parameter_table().active_effects(self.parent.values[0]):
            return by_columns
        tried = self.tried_places(effect)
        all_of_them = [*tried, *by_columns]
        most = max((found.promise for found in all_of_them), default=0.0)
        best = [max(some, key=lambda found: found.promise) for some in (tried, by_columns) if some]
        rest = [found for found in all_of_them if found not in best]
        return [*(replace(found, promise=most) for found in best), *rest]

    def _dragging_areas(self, effect: Effect) -> list[Candidate]:
        """Return areas of rough floor, felt under each wheel or under the body's middle, moved and resized uphill.

        Wide ones are kept beside small ones: about the middle of a wide one a small one promises much, too, and the
        other way round.
        """
        places = self.places()
        usual = [*boxes(places, self.size), *strips(self.situations)]
        kept = [*self._best_areas(usual, KEEP), *self._best_areas(wide_boxes(places, self.size), KEEP_WIDE)]
        found = [Candidate(area.numbers(effect), promise) for area, promise in kept]
        return sorted(found, key=lambda candidate: -candidate.promise)

    def _best_areas(self, shapes: Sequence[Area], keep: int) -> list[tuple[Area, float]]:
        """Return the best of some areas that are apart, moved and resized uphill, and what they promise."""
        areas = [replace(area, spread=spread) for area in shapes for spread in (0.0, 1.0)]
        promise = self._drags(areas)
        found: list[tuple[Area, float]] = []
        centres = np.array([(area.x, area.y) for area in areas])
        for i in apart(promise, centres, keep, 1.5 * self.size * PITCH):
            if self.hopeless(float(promise[i])):
                continue
            best, gain = settled(areas[i], self._drags, self.size)
            if not any(best.is_like(other, self.size) for other, _ in found):
                found.append((best, gain))
        return found

    def _drags(self, areas: Sequence[Area]) -> FloatArray:
        """Return what a drag in each area promises (c,); a rough floor never pushes."""
        parts = [areas[i : i + CHUNK] for i in range(0, len(areas), CHUNK)]  # all at once: 100 MB
        found = [self.scores([drag_columns(s, part) for s in self.situations]) for part in parts]
        return np.concatenate([np.where(amplitude > 0, promise, 0.0) for promise, amplitude in found])

    def slippery_areas(self, effect: Effect) -> list[Candidate]:
        """Return discs of low friction: there the robot neither starts, stops nor turns as told."""
        centres = place_centres(self.situations, self.size * PITCH, beside=True)
        found = Slides(self.parent, self.residual, effect, self.passages, self.size).best(centres)
        return [Candidate(changes, promise) for changes, promise in found if not self.hopeless(promise)]

    def markers(self, effect: Effect) -> list[Candidate]:
        """Return discs inside which poses are turned, headings alone are, or poses are turned and shifted, where any
        stands out also of boards that are seen from one side.
        """
        jumps = [
            jumps_of(simulator.prepared, simulated)
            for simulator, simulated in zip(self.simulators, self.parent.simulated, strict=True)
        ]
        turned = [
            found
            for wrong in (TURNED, HEADING)
            for found in self._markers(effect, jumps, wrong, MARKERS_TRIED)
        ]
        shifted = self._markers(effect, jumps, SHIFTED, SHIFTED_TRIED)
        cost = float(np.log(self.residual.engine.count))  # of two numbers more
        best = max((candidate.promise for candidate in turned), default=0.0)
        found = turned + [candidate for candidate in shifted if candidate.promise > best + cost]
        if max((candidate.promise for candidate in found), default=0.0) > FAINT:
            found += self._from_one_side(effect, jumps)
        return [candidate for candidate in found if not self.hopeless(candidate.promise)]

    def _from_one_side(self, effect: Effect, jumps: Sequence[Jumps]) -> list[Candidate]:
        """Return the best discs of boards that count only while the robot looks their way."""
        found = [
            one for wrong in FROM_ONE_SIDE for one in self._markers(effect, jumps, wrong, ONE_SIDE_TRIED)
        ]
        return sorted(found, key=lambda candidate: -candidate.promise)[:KEEP]

    def _markers(self, effect: Effect, jumps: Sequence[Jumps], wrong: Wrong, count: int) -> list[Candidate]:
        """Return the best discs by their jumps or by what they win as they are, and the best of these alone.

        Jumps alone miss a faint turn that the poses inside show together, and where the robot's own errors jump, too,
        discs with jumps enough lose hundreds of units beside one that wins as it is: that one promises as much as any.
        """
        discs = likely_discs(jumps, wrong, count, self.size)
        wins = tried_out(self.parent, self.residual, [disc.changes(effect) for disc in discs])
        promise = np.maximum([disc.promise for disc in discs], wins)
        surest = np.argsort(-wins)[:1]
        promise[surest[wins[surest] > 0.0]] = promise.max(initial=0.0)
        return [Candidate(discs[i].changes(effect), float(promise[i])) for i in np.argsort(-promise)[:KEEP]]

    def spans(self, effect: Effect) -> list[Candidate]:
        """Return spans of one recording in which a wheel's motor is weaker, and where one blinks."""
        return FaultSearch(effect, self.parent, self.residual).candidates(KEEP)

    def pushes(self, effect: Effect) -> list[Candidate]:
        """Return pushes of one recording, and several at once where they stand out together."""
        scale = scale_of(self.simulators[0])
        return PushSearch(effect, self.residual, self.situations, self.passages, scale).candidates(KEEP)

    def tried_places(self, effect: Effect) -> list[Candidate]:
        """Return places where any effect of a place promises most, tried by simulation."""
        found = tried_places(Trial(effect, self.parent, self.residual), self.places(), self.size)
        return [Candidate(changes, promise) for changes, promise in found if not self.hopeless(promise)]

    def tried_spans(self, effect: Effect) -> list[Candidate]:
        """Return spans of one recording in which any effect of a span promises most, tried by simulation."""
        trial, found = Trial(effect, self.parent, self.residual), []
        for strength, run in product(trial.strengths(), range(len(self.simulators))):
            span = tried_span(trial, run, strength)
            changes = {f"{effect.name}.start": span.begin, f"{effect.name}.duration": span.end - span.begin}
            found.append(Candidate(changes, span.promise, run))
        return sorted(found, key=lambda c: -c.promise)[:KEEP]

    def tried_moments(self, effect: Effect) -> list[Candidate]:
        """Return moments at which any effect of a moment promises most, each with how it stands out."""
        trial, found = Trial(effect, self.parent, self.residual), []
        for strength in trial.strengths():
            tried = [tried_moments(trial, run, strength) for run in range(len(self.simulators))]
            best = [_apart(promise, starts, MOMENTS + 1) for starts, promise in tried]
            for run, (starts, promise) in enumerate(tried):
                others = [*best[:run], *best[run + 1 :]]
                for b in apart(promise, starts[:, None], KEEP, 2 * STEP):
                    free = np.abs(starts - starts[b]) > MOMENTS_APART
                    rest = np.sort(
                        np.concatenate([_apart(promise[free], starts[free], MOMENTS + 1), *others])
                    )
                    chance = by_chance([float(promise[b]), *rest[::-1].tolist()])
                    changes = {f"{effect.name}.start": float(starts[b])}
                    found.append(Candidate(changes, float(promise[b]), run, chance))
        return sorted(found, key=lambda c: -c.promise)[:KEEP]


def _apart(promise: FloatArray, starts: FloatArray, keep: int) -> FloatArray:
    """Return the largest promises of moments that are apart in time."""
    return promise[apart(promise, starts[:, None], keep, MOMENTS_APART)]


Scan = Callable[[Scanner, Effect], list[Candidate]]

SCANS: dict[tuple[str, str], Scan] = {
    ("place", "drag"): Scanner.drag_areas,
    ("place", "grip"): Scanner.slippery_areas,
    ("place", "pose"): Scanner.markers,
    ("span", "motor"): Scanner.spans,
    ("moment", "push"): Scanner.pushes,
}
"""What is looked for, and on what it acts, to the scan that is made for it."""

DEFAULTS: dict[str, Scan] = {
    "place": Scanner.tried_places,
    "span": Scanner.tried_spans,
    "moment": Scanner.tried_moments,
}
"""What is looked for to the scan that finds whatever acts there."""


def scan_of(effect: Effect) -> Scan | None:
    """Return the scan that looks for an effect's place or time; None for one that acts anywhere and always."""
    if not effect.scan:
        return None
    kind = effect.when if effect.scan == "time" else "place"
    return SCANS.get((kind, effect.acts_on), DEFAULTS[kind])
