"""What a drive is composed of: straights, spins, arcs, pivots, slaloms, steps, stop-and-go, rests."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product

REST = 0.6  # s at zero after a manoeuvre: three time constants of the wheels, and the robot stands
LEVELS = (
    0.12,
    0.25,
    0.5,
    0.85,
)  # of the command limit: dead zones show below a tenth, saturation near the limit
REACH = 0.55  # m: longest way of one manoeuvre, so that four headings fit into 2 x 2 m
TURN = 4.5  # rad: three quarters of a turn
SHORTEST, LONGEST = 0.5, 2.6  # s of one command
LONG_REST = 5.0  # s: slow changes recover in it, or do not


@dataclass(frozen=True, slots=True)
class Primitive:
    """Held commands in a row: (seconds, left, right [1]); ends at rest."""

    name: str
    holds: tuple[tuple[float, float, float], ...]

    @property
    def duration(self) -> float:
        """Seconds."""
        return sum(seconds for seconds, _, _ in self.holds)


@dataclass(frozen=True, slots=True)
class Pace:
    """How fast the robot is likely to be: speed(u) [m/s] of a straight at command u, turn(u) [rad/s] of a spin.

    share : of the full reach that manoeuvres have; less where there is little room.
    """

    speed: Callable[[float], float]
    turn: Callable[[float], float]
    share: float = 1.0

    def straight(self, command: float) -> float:
        """Return for how long [s] a straight stays within `REACH`."""
        return _clipped(self.share * REACH / max(self.speed(command), 0.02), self.share)

    def spin(self, command: float) -> float:
        """Return how long [s] `TURN` takes."""
        return _clipped(self.share * TURN / max(self.turn(command), 0.1), self.share)


def menu(limit: float, pace: Pace) -> tuple[Primitive, ...]:
    """Return the manoeuvres for commands up to `limit` [1], in both directions and to both sides."""
    levels = [round(limit * share, 3) for share in LEVELS]
    return (
        *(p for u in levels for p in _straights(u, pace)),
        *(p for u in levels for p in _turns(u, pace)),
        *(p for u in levels[1:] for p in _arcs(u, pace)),
        *_changes(levels, pace),
        Primitive(f"rest for {LONG_REST:g} s", ((LONG_REST, 0.0, 0.0),)),
    )


def _straights(u: float, pace: Pace) -> Iterator[Primitive]:
    t = pace.straight(u)
    yield Primitive(f"straight ahead at {u:g}", _row((t, u, u)))
    yield Primitive(f"straight back at {u:g}", _row((t, -u, -u)))
    yield Primitive(f"ahead and back at {u:g}", (*_row((t, u, u)), *_row((t, -u, -u))))


def _turns(u: float, pace: Pace) -> Iterator[Primitive]:
    t = pace.spin(u)
    for side, way in ((1, "left"), (-1, "right")):
        yield Primitive(f"spin {way} at {u:g}", _row((t, -side * u, side * u)))
    yield Primitive(f"pivot on the left wheel at {u:g}", _row((t, 0.0, u)))
    yield Primitive(f"pivot on the right wheel at {u:g}", _row((t, u, 0.0)))


def _arcs(u: float, pace: Pace) -> Iterator[Primitive]:
    t = pace.straight(u)
    for share, way in product((0.5, 0.75), (1, -1)):
        yield Primitive(f"arc left at {way * u:g}, inner {share:g}", _row((t, way * share * u, way * u)))
        yield Primitive(f"arc right at {way * u:g}, inner {share:g}", _row((t, way * u, way * share * u)))


def _changes(levels: list[float], pace: Pace) -> Iterator[Primitive]:
    """Yield what changes its command often."""
    for u, t in product(levels[2:], (0.25, 0.5)):
        bends = [(t, u, 0.5 * u), (t, 0.5 * u, u)] * 2
        yield Primitive(f"slalom at {u:g}, {t:g} s each", _row(*bends))
    for u in levels[1:]:
        t = min(0.4, pace.straight(u) / 3.0)
        starts = [(t, u, u), (0.4, 0.0, 0.0), (t, -u, -u), (0.4, 0.0, 0.0)] * 2
        yield Primitive(f"stop and go at {u:g}", _row(*starts[:-1]))
    yield Primitive("steps up and down", _row(*((0.5, u, u) for u in (*levels[:3], *levels[1::-1]))))
    yield Primitive("steps of a spin", _row(*((0.6, -u, u) for u in levels)))
    yield Primitive("steps of a spin, other way", _row(*((0.6, u, -u) for u in levels)))


def _row(*holds: tuple[float, float, float]) -> tuple[tuple[float, float, float], ...]:
    rounded = tuple((round(t, 3), round(left, 4), round(right, 4)) for t, left, right in holds)
    return (*rounded, (REST, 0.0, 0.0))


def _clipped(seconds: float, share: float) -> float:
    return min(max(seconds, share * SHORTEST), LONGEST)
