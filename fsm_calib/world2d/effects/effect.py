"""What an effect declares: its equation, parameters, hooks, where it shows and what it can be taken for.

An effect is one module of this package with a constant `EFFECT`. Its hooks are small compiled functions;
`kernel` weaves those of all effects into one program, so that any combination runs without compiling again:

    begin(P, o, W)             once per roll-out: masses, geometry, loads
    shape(P, o, u, side) -> u  static map of a held command [1] of one wheel (side 0 left, 1 right)
    delay(P, o) -> seconds     how much later a command acts
    step(P, o, S, m, W)        once per step, before the wheels meet the ground; may keep memory in S[m:]

P is the parameter vector and o the place of the effect's first parameter; S, W are the arrays of `slots`. Two
hooks work on whole recordings, with NumPy:

    clock(p, t) -> t           time stamps of the pose sensor [s] to the robot's time [s]
    observe(p, poses, places)  the sensor's poses, shape (n, 3), from the robot's; `places`, shape (n, 2), is
    where the
                               robot is known to be, for effects of places
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Literal

Channel = Literal["forward", "lateral", "turn", "sensor"]
FORCE_DOUBT = 0.2  # of a force told by speeds: mass to 10 %, rotating inertia to a factor of two
LEAST_DELAY = 0.004  # s: the base's tyres lag by 2 to 3 ms (assumed), its motors are of first order
HOOKS = ("begin", "shape", "delay", "step", "clock", "observe")


@dataclass(frozen=True, slots=True)
class Parameter:
    """One number of an effect or of the base robot.

    Parameters
    ----------
    name, symbol, unit : str
        Name in files and reports; symbol in the equation; unit (``"1"`` for none).
    null : float
        The value that changes nothing.
    low, high : float
        Physical bounds, in `unit`.
    typical : float
        A size worth finding, for examples and tests.
    source : str
        Where bounds and typical size come from.
    strength : bool
        Whether the effect is off while this has its null value (and all other strengths too). The others say
        where, when or how and mean nothing while the strengths are null.
    per_recording : bool
        Whether the value belongs to one recording (a phase, the time of an event) and not to the robot.
    fitted : bool
        Whether a fit moves it. The others serve the world only, or, with `starts`, are choices that a diagnosis
        tries.
    mirror : str
        What becomes of the value when left and right change places: ``same``, ``negate``, ``complement`` (of
        a full difference) or ``swap:NAME`` with the value of another parameter.
    starts : tuple of float
        Values from which a fit should be started when the null value does not lead to the truth.
    step : float
        A sensible finite-difference step, in `unit`; 0 means a thousandth of the typical size.
    natural_end : bool
        Whether nature ends at the high bound (a dead motor has lost all), so that a fit may rest there. At another
        bound the fit asks for more of the effect than there can be.
    doubt : float
        By how much the equation itself may be off, where it is not what the unit lets expect: a share of a strength,
        in `unit` of a place.
    least : float
        A smaller distance from the null value, in `unit`, is within what the base robot's own equations leave open,
        and no size to be named.
    """

    name: str
    symbol: str
    unit: str
    null: float
    low: float
    high: float
    typical: float
    source: str
    strength: bool = True
    per_recording: bool = False
    fitted: bool = True
    mirror: str = "same"
    starts: tuple[float, ...] = ()
    step: float = 0.0
    natural_end: bool = False
    doubt: float = 0.0
    least: float = 0.0

    @property
    def difference_step(self) -> float:
        """The finite-difference step [unit]."""
        return self.step or 1e-3 * max(abs(self.typical - self.null), 1e-6)


@dataclass(frozen=True, eq=False)
class Effect:
    """One piece of physics that a simulation may leave out.

    `equation` is one line of text (the module's docstring explains it); `channels` and `regimes` say where it
    shows; `family` groups effects that a report may name together when it cannot decide; `rivals` are the
    names it is easily taken for, `separates` says what tells them apart and `manoeuvre` which drive shows it;
    `sentence` is the report's line, with ``{parameter}`` for fitted values; `variants` are the sets of
    parameters worth fitting (empty: all); `scan` tells the diagnosis to look for a ``place`` or a ``time``;
    `memory` counts the state slots that the step hook keeps; `order` sorts hooks within a stage (small
    first); `input` says which drives can show it: any, commands (measured wheel speeds have their motors
    behind them), commanded twists, or drives whose wheels were measured by us or
    by the robot's own controller; `jumps` says that the pose itself jumps at the edge of a place.
    """

    name: str
    family: str
    equation: str
    parameters: tuple[Parameter, ...]
    hooks: Mapping[str, Callable[..., Any]]
    channels: tuple[Channel, ...]
    regimes: tuple[str, ...]
    separates: str
    rivals: tuple[str, ...]
    manoeuvre: str
    sentence: str
    source: str
    scan: Literal["", "place", "time"] = ""
    variants: tuple[tuple[str, ...], ...] = ()
    memory: int = 0
    order: int = 50
    dissipative: bool = False
    jumps: bool = False
    input: Literal["any", "command", "twist", "wheels"] = "any"
    summary: str = field(default="")

    def __post_init__(self) -> None:
        """Freeze the hooks and refuse unknown stages."""
        unknown = set(self.hooks) - set(HOOKS)
        if unknown:
            raise ValueError(
                f"effect {self.name}: unknown hooks {sorted(unknown)}; known: {', '.join(HOOKS)}"
            )
        object.__setattr__(self, "hooks", MappingProxyType(dict(self.hooks)))

    @property
    def strengths(self) -> tuple[str, ...]:
        """Names of the parameters that switch the effect on."""
        return tuple(p.name for p in self.parameters if p.strength)

    @property
    def choices(self) -> tuple[Parameter, ...]:
        """Parameters that are tried at their start values instead of fitted."""
        return tuple(p for p in self.parameters if not p.fitted and p.starts)

    def parameter(self, name: str) -> Parameter:
        """Return the parameter of that name; KeyError when there is none."""
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        raise KeyError(name)
