"""A closure: one way in which a phenomenon may act, with the numbers that it frees.

A phenomenon (a warming motor) says what happens; a closure (the left motor alone, both with one time constant, a
change that follows the clock) says by which equation. The closures of an effect share its hooks and parameters; each
frees some of them, and may hold choices at values of its own. A verdict names the effect and tells the closure.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType


@dataclass(frozen=True, eq=False)
class Closure:
    """One of an effect's alternative equations.

    Parameters
    ----------
    name : str
        A word or two, unique among the effect's closures: ``left wheel``, ``both wheels``, ``by the clock``.
    frees : tuple of str
        Names of the parameters that a fit moves; all others stay at their null value.
    summary : str
        One line: what it says beyond the effect's own summary.
    sentence : str
        The report's line, as that of an effect (`Effect`); empty: the effect's.
    source : str
        Where its equation comes from; empty: the effect's.
    fixes : mapping of str to float
        Values at which it holds choices (`Parameter.fitted` false); choices that it does not hold are tried.
    refines : bool
        It makes the equation of the others more exact and says nothing of the name: a diagnosis tries it once the
        effect is in the model, not while names compete.
    extends : tuple of str
        Names of smaller closures of the effect: it is asked for where one of these wins something, and from where that
        one's fit has ended. For closures of many numbers and choices, which would cost more than all others together.
    alike : tuple of str
        Of an event, those of its freed numbers of a recording that all recordings share, for one that comes alike in
        each of them at a time of its own; empty: an event of one recording.
    has_twin : callable, optional
        Takes the closure's numbers by name, and all numbers of the model by full name; whether something that is no
        effect of the catalogue does the very same with these. No drive tells the two apart, so that the name is even
        odds.
    """

    name: str
    frees: tuple[str, ...]
    summary: str
    sentence: str = ""
    source: str = ""
    fixes: Mapping[str, float] = field(default_factory=dict)
    refines: bool = False
    extends: tuple[str, ...] = ()
    alike: tuple[str, ...] = ()
    has_twin: Callable[[Mapping[str, float]], bool] | None = None

    def __post_init__(self) -> None:
        """Freeze what it fixes."""
        object.__setattr__(self, "fixes", MappingProxyType(dict(self.fixes)))
