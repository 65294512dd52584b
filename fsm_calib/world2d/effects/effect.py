"""What an effect declares: its equation, parameters, hooks, where it shows and what it can be taken for.

An effect is one module with a constant `EFFECT` (or a tuple `EFFECTS`): of this package, or from outside
(`outside`; docs/own-effect.md shows one whole). Its hooks are small compiled functions; `kernel` weaves those of all
effects into one program, so that any combination runs without compiling again:

    begin(P, o, W)             once per roll-out: masses, geometry, loads
    shape(P, o, u, side) -> u  static map of a held command [1] of one wheel (side 0 left, 1 right)
    delay(P, o) -> seconds     how much later a command acts
    set_point(P, o, S, m, W)   once per step, before all steps: what becomes of the set points W[TARGET:]
    step(P, o, S, m, W)        once per step, before the wheels meet the ground; both may keep memory in S[m:]

P is the parameter vector and o the place of the effect's first parameter; S, W are the arrays of `slots`. Four
hooks work on whole recordings, with NumPy:

    clock(p, t) -> t           time stamps of the pose sensor [s] to the robot's time [s]
    smooth(p, t, poses)        what a filter makes of the robot's poses, shape (n, 3), at increasing times t (n,) [s]
    mount(p, t, poses)         the poses, shape (n, 3), of a sensor by where it sits on the robot at times t (n,) [s]
    observe(p, poses, places)  the sensor's poses, shape (n, 3), from the robot's; `places`, shape (n, 2), is where the
                               robot is known to be, for effects of places

One phenomenon, several closures
--------------------------------
What happens (`phenomenon`: a wheel off its centre) and by which equation (`closures`: the left wheel, the right one,
both) are declared apart. A `Closure` names the parameters that it frees, one line that says what it is, its own
sentence and source where they differ from the effect's, and the values at which it holds choices (`fixes`):

    closures=(
        Closure("left wheel", ("left", "phase_left"), "the left wheel alone"),
        Closure("both wheels", ("left", "right", "phase_left", "phase_right"), "each by its own amount",
                sentence="Both wheels sit off their centres, by {left} and {right}."),
        Closure("by the clock", ("change_left",), "electronics heat it", fixes={"idle": 1.0}, source="..."),
    )

An effect that declares none has one that frees every fitted parameter. Each closure is one hypothesis of the
diagnosis. `variants` are the closures' parameter names alone.

What it is, in words that steer the diagnosis
---------------------------------------------
where     ``anywhere``, a ``disc`` (parameters x, y, radius [m]) or an ``area`` (x, y, half_x, half_y [m])
when      ``always``, a ``moment`` or a ``span`` (both: start, duration [s]; a moment's duration is not fitted)
acts_on   what a faster scan than trying out looks for: ``drag``, ``grip``, ``pose``, ``motor``, ``push`` or nothing
reads     what a step takes of the whereabouts: ``place``, ``heading``, ``wheel_angle``
inexact   how far the equation itself may be off, as a share of a strength; 0 means by its unit: 20 % of what holds
          mass (a force told by speeds), 3 % of anything else. `Parameter.doubt` overrules it for one number
prior     of a parameter: standard deviation about its null value that is expected before any data
universal no robot is without it (its mass is never quite over the axle): a little of it needs less proof than a fault
family    ``resistance``: every robot has some of it, too, and no ``sensor`` that acts everywhere sits quite where it
          should; of such effects and universal ones (`usual`) too little to matter is modelled without being said

A place or a time is searched by the scan for what it `acts_on`, or by simulation where none is declared. All words
(`vocabulary`) are checked, and an unknown one is refused with the nearest.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Literal

from fsm_calib.world2d.effects.closure import Closure
from fsm_calib.world2d.effects.declaration import check_declaration
from fsm_calib.world2d.effects.parameter import FORCE_DOUBT, Parameter
from fsm_calib.world2d.effects.vocabulary import HOOKS, Acts, Channel, Input, Reads, When, Where

__all__ = ["FORCE_DOUBT", "HOOKS", "Channel", "Closure", "Effect", "Parameter"]


@dataclass(frozen=True, eq=False)
class Effect:
    """One piece of physics that a simulation may leave out.

    `equation` is one line of text (the module's docstring explains it); `channels` and `regimes` say where it
    shows; `family` groups effects that a report may name together when it cannot decide; `rivals` are the
    names it is easily taken for, `separates` says what tells them apart and `manoeuvre` which drive shows it;
    `sentence` is the report's line, with ``{parameter}`` for fitted values, ``{parameter:ahead|behind}`` where a word
    says the sign; `where`, `when`, `acts_on`, `reads`, `inexact`,
    `universal`, `phenomenon` and `closures`: see the module's text; `memory` counts the state slots that its hooks
    keep; `order` sorts hooks within a stage (small first); `input` says which drives can show it: any,
    commands (measured wheel speeds have their motors behind them), commanded twists, or drives whose wheels were
    measured by us or by the robot's own controller; `jumps` says that the pose itself jumps at the edge of a place;
    `excludes` names what a robot cannot have that has this; `phenomenon` defaults to the name in words.

    Raises
    ------
    InputError, UnknownNameError
        For a declaration that contradicts itself, or a word that is not in the vocabulary.
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
    where: Where = "anywhere"
    when: When = "always"
    acts_on: Acts = ""
    reads: tuple[Reads, ...] = ()
    inexact: float = 0.0
    phenomenon: str = ""
    closures: tuple[Closure, ...] = ()
    memory: int = 0
    order: int = 50
    dissipative: bool = False
    jumps: bool = False
    universal: bool = False
    input: Input = "any"
    excludes: tuple[str, ...] = ()
    summary: str = field(default="")

    @property
    def usual(self) -> bool:
        """Whether every robot has a little of it, which is no finding."""
        mounting = self.family == "sensor" and not self.scan
        return self.universal or self.family == "resistance" or mounting

    def __post_init__(self) -> None:
        """Freeze the hooks, complete the closures, and check the declaration."""
        object.__setattr__(self, "hooks", MappingProxyType(dict(self.hooks)))
        if not self.phenomenon:
            object.__setattr__(self, "phenomenon", self.name.replace("_", " "))
        if not self.closures:
            fitted = tuple(p.name for p in self.parameters if p.fitted)
            object.__setattr__(self, "closures", (Closure("full", fitted, self.summary),))
        check_declaration(self)

    @property
    def strengths(self) -> tuple[str, ...]:
        """Names of the parameters that switch the effect on."""
        return tuple(p.name for p in self.parameters if p.strength)

    @property
    def choices(self) -> tuple[Parameter, ...]:
        """Parameters that are tried at their start values, or searched, instead of fitted."""
        return tuple(p for p in self.parameters if not p.fitted and (p.starts or p.searched))

    @property
    def rugged(self) -> tuple[Parameter, ...]:
        """Fitted parameters whose fits stay near where they start."""
        return tuple(p for p in self.parameters if p.rugged)

    @property
    def competing(self) -> tuple[Closure, ...]:
        """The closures that compete for a name from the start.

        All but those that refine it, extend others, or come alike in every recording, which are left to a scan.
        """
        return tuple(c for c in self.closures if not c.refines and not c.extends and not c.alike)

    @property
    def alike(self) -> tuple[Closure, ...]:
        """The closures of an event that comes alike in every recording."""
        return tuple(closure for closure in self.closures if closure.alike)

    @property
    def extending(self) -> tuple[Closure, ...]:
        """The closures that compete where a smaller one wins something."""
        return tuple(closure for closure in self.closures if closure.extends)

    @property
    def refining(self) -> tuple[Closure, ...]:
        """The closures that are tried once the effect is in a model."""
        return tuple(closure for closure in self.closures if closure.refines)

    @property
    def variants(self) -> tuple[tuple[str, ...], ...]:
        """The sets of parameters that the closures free."""
        return tuple(closure.frees for closure in self.closures)

    @property
    def scan(self) -> Literal["", "place", "time"]:
        """What the diagnosis has to look for: a ``place``, a ``time``, or neither."""
        if self.where != "anywhere":
            return "place"
        return "time" if self.when != "always" else ""

    def closure(self, name: str) -> Closure:
        """Return the closure of that name; KeyError when there is none."""
        for closure in self.closures:
            if closure.name == name:
                return closure
        raise KeyError(name)

    def parameter(self, name: str) -> Parameter:
        """Return the parameter of that name; KeyError when there is none."""
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        raise KeyError(name)
