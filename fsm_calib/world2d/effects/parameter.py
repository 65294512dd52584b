"""One number of an effect or of the base robot: its unit, its bounds, what it means and how a fit treats it."""

from __future__ import annotations

import math
from dataclasses import dataclass

FORCE_DOUBT = 0.2  # of a force told by speeds: mass to 10 %, rotating inertia to a factor of two


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
    without_encoders : bool
        Whether a diagnosis tries this choice only where nobody measured the wheels; else its null value is the truth.
    with_encoders : bool
        Whether it tries this choice only where somebody did; else it says nothing.
    mirror : str
        What becomes of the value when left and right change places: ``same``, ``negate``, ``complement`` (of
        a full difference) or ``swap:NAME`` with the value of another parameter.
    starts : tuple of float
        Values from which a fit should be started when the null value does not lead to the truth.
    along : str
        Name of the effect's angle [rad] along whose direction it is a distance from the origin, its starts then being
        shares of the stretch that the drives cover that way.
    searched : tuple of float
        Values of a number that is not fitted, each of which is tried by simulation: of how many steps a driver knows no
        derivative tells. Tried where no closure holds it at a value.
    step : float
        A sensible finite-difference step, in `unit`; 0 means a thousandth of the typical size.
    natural_end : bool
        Whether nature ends at the high bound (a dead motor has lost all), so that a fit may rest there. At another
        bound the fit asks for more of the effect than there can be.
    floor : bool
        Whether a fit that rests at the low bound is of something else, though this is no strength: what warms within
        a moment is a lag.
    doubt : float
        By how much the equation itself may be off, where it is not what the unit lets expect: a share of a strength,
        in `unit` of a place.
    of_axle : float
        The share [1] of the axle's length that the null value is at least: a length of the chassis that no manifest
        states and that a larger robot has larger.
    prior : float
        Standard deviation of a normal prior about the null value, in `unit`; 0 for none: the bounds alone.
    least : float
        A smaller distance from the null value, in `unit`, is within what the base robot's own equations leave open,
        and no size to be named.
    as_built : float
        A value that robots are built with: a fit between it and the null value stays in the model, where it may be
        needed beside another effect, and has no name where the closure's other numbers rest at their least; nan for
        none.
    rugged : bool
        Whether a fit stays on the hill where this number starts, so that one that has ended is tried from the other
        starts, too.
    edge : float
        Width about the value, in `unit` of a command, over which the equation goes over from one law to another so that
        a fit can feel it; nature's edge has none, and hardly any command may pass by a part.
    in_series : bool
        Whether it is a time constant in series with the motors' own. Lags in series commute, so that a fit that takes
        one for the other stands on a hill of its own.
    cyclic : bool
        Whether it is an angle of which a whole turn [2 pi rad] more is the same: half a turn more is the opposite.
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
    without_encoders: bool = False
    with_encoders: bool = False
    mirror: str = "same"
    starts: tuple[float, ...] = ()
    along: str = ""
    searched: tuple[float, ...] = ()
    step: float = 0.0
    natural_end: bool = False
    floor: bool = False
    doubt: float = 0.0
    least: float = 0.0
    of_axle: float = 0.0
    prior: float = 0.0
    in_series: bool = False
    rugged: bool = False
    edge: float = 0.0
    cyclic: bool = False
    as_built: float = math.nan

    @property
    def typical_size(self) -> float:
        """How far the typical value is from none [unit]."""
        return abs(self.typical - self.null)

    @property
    def difference_step(self) -> float:
        """The finite-difference step [unit]."""
        return self.step or 1e-3 * max(self.typical_size, 1e-6)
