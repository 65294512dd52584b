"""A machine of one's own: turn to floor markers one after the other, and look whether the picture is bright enough."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from fsm_calib.actions.bench import Bench
from fsm_calib.actions.looking import look
from fsm_calib.machines.activities import CAMERA, CONTRACT
from fsm_calib.machines.losses import LOSS_ACTIONS, LOSS_GUARDS, STREAKS, camera_losses, motion_losses
from fsm_calib.outcome import Outcome
from fsm_calib.statechart.activity import Activity, Returned, contract_of
from fsm_calib.statechart.books import Books
from fsm_calib.statechart.machinery import Machinery, Small
from fsm_calib.statechart.spec import Chart, State, always, choose, otherwise, when

Evidence = Mapping[str, Any]


# What is counted, and what it is compared with.
@dataclass(slots=True)
class Counts(Books):
    """What the machine has counted."""

    turns: int = 0
    places: int = 0
    lost_frames: int = 0


@dataclass(frozen=True, slots=True)
class Limits:
    """What a round may spend, and what is good enough.

    Parameters
    ----------
    turns : int
        Turning steps before the first or next marker must be in sight.
    places : int
        Pictures with a marker whose brightness is measured.
    frame_retries : int
        Missing or frozen frames in a row.
    darkest : float
        Mean grey value below which a picture is too dark [0 to 255].
    """

    turns: int = 60
    places: int = 3
    frame_retries: int = 3
    darkest: float = 40.0


# What the robot does: one activity of its own beside those of the calibration.
LIGHT = Activity(
    "measure_light",
    "Take a frame at rest and measure its mean grey value.",
    (
        Returned("light_measured", "The mean grey value is known.", ("grey: mean of the frame, 0 to 255",)),
        *CAMERA,
    ),
)


def measure_light(bench: Bench) -> Outcome:
    """Take a frame and measure its mean grey value."""
    frame = look(bench)
    if isinstance(frame, Outcome):
        return frame
    grey = round(float(frame.image.mean()), 1)
    return Outcome("light_measured", {"grey": grey}, f"The mean grey value is {grey}.")


# Guards ask, actions count; both get the books, the limits and the outcome's evidence.
def is_dark(books: Counts, limits: Limits, evidence: Evidence) -> bool:
    """Whether the picture is too dark."""
    return bool(evidence["grey"] < limits.darkest)


def has_turns_left(books: Counts, limits: Limits, evidence: Evidence) -> bool:
    """Whether one more step is within the budget."""
    return books.turns + 1 < limits.turns


def has_places_left(books: Counts, limits: Limits, evidence: Evidence) -> bool:
    """Whether more places are to be measured than this one."""
    return books.places + 1 < limits.places


def count_turn(books: Counts, limits: Limits, evidence: Evidence) -> None:
    """One more turning step."""
    books.turns += 1


def count_place(books: Counts, limits: Limits, evidence: Evidence) -> None:
    """One more place; the turns to the next begin anew."""
    books.places += 1
    books.turns = 0


# The machine: states with what is done in them, and what each outcome leads to.
FAILURES = (
    State(
        "no_marker",
        "No floor marker came into sight.",
        reason="No floor marker came into sight in {turns} turning steps.",
        cure="Put the robot on the field of floor markers.",
    ),
    State(
        "too_dark",
        "A picture was too dark.",
        reason="After {places} bright places a picture was darker than {darkest:.0f}.",
        cure="Switch on the light.",
    ),
    State("no_picture", "The camera failed.", reason="The camera failed.", cure="Check the camera's cable."),
    State(
        "held", "The robot did not move.", reason="The robot did not move.", cure="Clear its surroundings."
    ),
)
ROUND = Chart(
    name="light_round",
    about="Turn from marker to marker and look whether each picture is bright enough.",
    states=(
        State("resting", "Put the wheels to zero.", do="stop_wheels"),
        State("turning", "Turn one step to the next marker.", do="turn_to_marker"),
        State("measuring", "Measure how bright the picture is.", do="measure_light"),
        State("done", "Every place was bright enough."),
        State("aborted", "The operator stopped the round."),
        State("failed", "The round ended with a reason and a cure.", children=FAILURES),
    ),
    transitions=(
        *always("wheels_stopped", "resting", "turning"),
        *always("marker_seen", "turning", "measuring"),
        *choose("marker_missed", "turning",
                when("has_turns_left", "turning", "count_turn"),
                otherwise("failed/no_marker")),
        *choose("light_measured", "measuring",
                when("is_dark", "failed/too_dark"),
                when("has_places_left", "turning", "count_place"),
                otherwise("done", "count_place")),
        *camera_losses("turning", "measuring", silent="failed/no_picture", frozen="failed/no_picture"),
        *motion_losses("turning", stalled="failed/held", blocked="failed/held"),
        *always("abort", ("resting", "turning", "measuring"), "aborted"),
    ),
)  # fmt: skip


def named(*functions: Any) -> dict[str, Any]:
    """Return the functions by the names that the table uses."""
    return {function.__name__: function for function in functions}


MACHINE = Machinery(
    root=ROUND,
    guards=LOSS_GUARDS | named(is_dark, has_turns_left, has_places_left),
    actions=LOSS_ACTIONS | named(count_turn, count_place),
    contract=CONTRACT | contract_of(LIGHT),
    does=named(measure_light),
    books=Counts,
    limits=Limits,
    streaks=STREAKS,
    # for the exhaustive check: grey values on both sides of `darkest`, and budgets small enough to visit everything
    samples={"grey": (10.0, 200.0)},
    small=(Small(Limits(turns=2, places=2, frame_retries=1)),),
)
