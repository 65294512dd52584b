"""A planned drive: what to command, why, and what each outcome would mean."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from fsm_calib.diagnosis.design.belief import NOTHING
from fsm_calib.types import FloatArray, Pose2


@dataclass(frozen=True, slots=True)
class Waypoint:
    """One manoeuvre of the drive: when it begins [s], its name, how long it takes [s]."""

    start: float
    name: str
    duration: float


@dataclass(frozen=True, slots=True)
class Forecast:
    """What a drive promises: probability of the right answer before and after, information [nat] at least, doubt."""

    sureness_before: float
    sureness: float
    information: float
    doubt_before: float


@dataclass(frozen=True, slots=True)
class Outlook:
    """One possible outcome: the explanation, its probability now, and after the drive if it is right; where the robot
    would end; what it would still be taken for, most likely.
    """

    names: tuple[str, ...]
    probability: float
    if_right: float
    end: Pose2
    rival: str

    @property
    def label(self) -> str:
        """The names as one text."""
        return " + ".join(self.names) or NOTHING


@dataclass(frozen=True, eq=False)
class Plan:
    """A drive: holds (seconds, left, right [1]) in a row; manoeuvres; start; forecast; outlooks, likeliest first;
    path : (n, 3) of the likeliest explanation, every 0.05 s.
    """

    holds: tuple[tuple[float, float, float], ...]
    manoeuvres: tuple[Waypoint, ...]
    start: Pose2
    forecast: Forecast
    outlooks: tuple[Outlook, ...]
    path: FloatArray

    @property
    def unnamed(self) -> float:
        """Probability now that none of the outlooks is right; theirs are those among them."""
        likeliest = max((o.probability for o in self.outlooks), default=0.0)
        return max(1.0 - self.forecast.sureness_before / likeliest, 0.0) if likeliest > 0.0 else 1.0

    @property
    def seconds(self) -> float:
        """How long it takes [s]."""
        return sum(hold[0] for hold in self.holds)

    @property
    def why(self) -> str:
        """One sentence: what it is to settle."""
        first, *others = [o.label for o in self.outlooks[:4]]
        return f"tells {first} from {', '.join(others)}" if others else f"confirms {first}"

    @property
    def room(self) -> tuple[float, float]:
        """Width and depth that the path takes [m], without the robot."""
        span = self.path[:, :2].max(axis=0) - self.path[:, :2].min(axis=0)
        return float(span[0]), float(span[1])

    def as_json(self) -> dict[str, Any]:
        """Return plain values."""
        f = self.forecast
        return {
            "seconds": round(self.seconds, 2),
            "why": self.why,
            "expected": round(f.sureness, 4),
            "before": round(f.sureness_before, 4),
            "information_nat": round(f.information, 4),
            "manoeuvres": [{"at_s": w.start, "name": w.name, "seconds": w.duration} for w in self.manoeuvres],
            "outcomes": [
                {
                    "names": list(o.names),
                    "probability": round(o.probability, 4),
                    "if_right": round(o.if_right, 4),
                    "end": {"x": round(o.end.x, 3), "y": round(o.end.y, 3), "theta": round(o.end.theta, 3)},
                    "rival": o.rival or None,
                }
                for o in self.outlooks
            ],
        }
