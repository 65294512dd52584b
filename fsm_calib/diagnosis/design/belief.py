"""What is believed before a drive: explanations with probabilities, numbers and their spread."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from fsm_calib.diagnosis.design.odds import TEMPER, counted
from fsm_calib.diagnosis.likelihood.noise import Noise
from fsm_calib.recording.recording import RobotFacts
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table

NOTHING = "nothing is missing"
HARDLY = 0.01  # probability of all that may hide beside an answer: drives have ruled out nine tenths of it


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """One explanation: its effects (none: the base robot is all there is), and the numbers it would have.

    probability : before the drive. values : (p,) parameters of the roll-out. places : (m,) which of them are not
    known exactly, those of the base robot first; covariance : (m, m) of them; steps : (m,) finite differences.
    over : the names that it holds one more beside; room : evidence over those (none: over nothing at all) that it may
    still win in full (`odds`).
    """

    names: tuple[str, ...]
    probability: float
    values: FloatArray
    places: tuple[int, ...]
    covariance: FloatArray
    steps: FloatArray
    room: float = 0.0
    over: tuple[str, ...] = ()

    @property
    def label(self) -> str:
        """The names as one text."""
        return " + ".join(self.names) or NOTHING

    @property
    def lasting(self) -> set[str]:
        """The effects that another drive would show, too: all but those that happen once."""
        return {name for name in self.names if registry()[name].scan != "time"}

    @property
    def needs_place(self) -> bool:
        """Whether it acts differently at another place or heading."""
        return any(depends_on_place(name) for name in self.names)


@dataclass(frozen=True, eq=False)
class Belief:
    """All explanations that are kept, the likeliest first.

    hypotheses : the first `base` places of each are the base robot's, the same in all. plain : (p,) the base robot
    re-fitted alone. unnamed : probability that none of them is right; no drive can be rolled out for it. noise; robot;
    frame_rate [Hz]; full_speed [m/s] at command 1.
    """

    hypotheses: tuple[Hypothesis, ...]
    base: int
    plain: FloatArray
    noise: Noise
    robot: RobotFacts = field(default_factory=RobotFacts)
    frame_rate: float = 15.0
    full_speed: float = 0.636
    unnamed: float = 0.0

    @property
    def probabilities(self) -> FloatArray:
        """Probabilities of the named explanations among themselves, shape (h,), summing to one."""
        p = np.array([h.probability for h in self.hypotheses])
        return np.asarray(p / p.sum())

    @property
    def doubt(self) -> float:
        """Entropy of the named explanations [nat]."""
        p = self.probabilities
        return float(-np.sum(p * np.log(np.maximum(p, 1e-300))))

    @property
    def within(self) -> FloatArray:
        """1 where an explanation (column) is another (row), or that with one more beside it; shape (h, h)."""
        h = self.hypotheses
        beside = [[bool(other.over) and other.over == one.names for other in h] for one in h]
        return np.asarray(np.eye(len(h)) + np.array(beside))

    @property
    def sureness(self) -> float:
        """Probability that the likeliest explanation is right, whatever hides beside it; the un-named ones counted."""
        p = self.probabilities
        return float(self.within[p.argmax()] @ p * (1.0 - self.unnamed))

    @property
    def completeness(self) -> float:
        """Probability that nothing hides beside the likeliest explanation, if that is right."""
        p = self.probabilities
        return float(p.max() / (self.within[p.argmax()] @ p))

    def log_weights(self, log_likelihood: FloatArray) -> FloatArray:
        """Return log odds, up to what all share, after a drive whose log-likelihoods are (n, h) under the explanations.

        They are weighed as a diagnosis of that drive weighs them: each against what it is said to be beside, where that
        is among them.
        """
        over = [self._rival(h) for h in self.hypotheses]
        won = 2.0 * (log_likelihood - log_likelihood[:, over])
        grown = counted(won, np.array([h.room for h in self.hypotheses]))
        further = [k for k, h in enumerate(self.hypotheses) if h.over]
        grown[:, further] += grown[:, [over[k] for k in further]]
        return np.asarray(np.log(np.maximum(self.probabilities, 1e-300)) + grown)

    def _rival(self, hypothesis: Hypothesis) -> int:
        """Return which explanation the evidence of another is counted over."""
        return next((k for k, h in enumerate(self.hypotheses) if h.names == hypothesis.over), 0)

    @property
    def tempers(self) -> FloatArray:
        """By how much evidence between two explanations is divided, (h, h): not where one is the other and one name
        more, which has won less than detection asks for.
        """
        nested = np.array(
            [[h.names == g.over and g.room > 0.0 for g in self.hypotheses] for h in self.hypotheses]
        )
        return np.asarray(np.where(nested | nested.T, 1.0, TEMPER))

    @property
    def leader(self) -> Hypothesis:
        """The likeliest explanation."""
        return max(self.hypotheses, key=lambda h: h.probability)


def without_unlikely_more(belief: Belief, sure: float) -> Belief:
    """Return a belief without what may hide beside its answers, where none of them is sure and hardly anything hides.

    A drive then tells the answers apart, or none can. sure : probability from which an answer is sure.
    """
    found = tuple(h for h in belief.hypotheses if not h.over)
    shares = np.array([h.probability for h in found])
    is_sure = shares.max(initial=0.0) >= sure * shares.sum()
    return belief if is_sure or _hides(belief) > HARDLY else replace(belief, hypotheses=found)


def beside_the_leader(belief: Belief) -> Belief | None:
    """Return what is believed of one effect more beside the likeliest answer; None where hardly anything hides."""
    chosen = belief.within[belief.probabilities.argmax()] > 0.0
    rows = tuple(h for h, is_one in zip(belief.hypotheses, chosen, strict=True) if is_one)
    return replace(belief, hypotheses=rows) if len(rows) > 1 and _hides(belief) > HARDLY else None


def _hides(belief: Belief) -> float:
    """Return the probability that something hides beside an answer."""
    beside = [bool(h.over) for h in belief.hypotheses]
    return float(belief.probabilities @ np.array(beside))


def depends_on_place(name: str) -> bool:
    """Return whether an effect acts differently at another place or heading."""
    effect = registry()[name]
    return bool(effect.scan == "place" or {"place", "heading"} & set(effect.regimes))


def place_of(hypothesis: Hypothesis) -> tuple[float, float] | None:
    """Return the centre of the place that a hypothesis names [m], None where it names none."""
    table = parameter_table()
    for name in hypothesis.names:
        if registry()[name].scan == "place" and f"{name}.x" in table.index:
            return tuple(float(hypothesis.values[table.place(f"{name}.{axis}")]) for axis in "xy")  # type: ignore[return-value]
    return None


def drawn_values(h: Hypothesis, count: int, rng: np.random.Generator) -> FloatArray:
    """Return parameter vectors (count, p) drawn from a hypothesis' spread, inside the physical bounds."""
    table = parameter_table()
    vectors, values = np.tile(h.values, (count, 1)), np.linalg.eigh(h.covariance)
    root = values[1] * np.sqrt(np.maximum(values[0], 0.0))
    moved = vectors[:, list(h.places)] + rng.standard_normal((count, len(h.places))) @ root.T
    low = [table.entries[place].low for place in h.places]
    high = [table.entries[place].high for place in h.places]
    vectors[:, list(h.places)] = np.clip(moved, low, high)
    return vectors


def kept(hypotheses: list[Hypothesis], most: int) -> tuple[Hypothesis, ...]:
    """Return the `most` likeliest, the likeliest first; what is as good as impossible is left out."""
    ordered = sorted(hypotheses, key=lambda h: -h.probability)[:most]
    total = sum(h.probability for h in ordered)
    if not total > 0.0 or not math.isfinite(total):
        return tuple(ordered)
    return tuple(h for h in ordered if h.probability > 1e-6 * total)
