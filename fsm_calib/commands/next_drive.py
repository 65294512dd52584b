"""What `diagnose --plan` does: the next drive designed, told and written."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from fsm_calib.errors import InputError

if TYPE_CHECKING:
    from fsm_calib.diagnosis.design.area import Area
    from fsm_calib.diagnosis.diagnose import Diagnosis

SMALLEST, LARGEST = 0.6, 50.0  # m: a side of the floor; below it a robot only turns on the spot
USUAL_FLOOR, USUAL_LONGEST = "2x2", 40.0
"""Free floor [m] and longest drive [s] where nobody says otherwise."""


@dataclass(frozen=True)
class Wanted:
    """The next drive that is asked for: the free floor, its longest time [s], the folder that it goes to."""

    area: Area
    longest: float
    folder: Path


def next_drive_of(plan: Path | None, area: str | None, longest: float | None) -> Wanted | None:
    """Return the next drive that the options ask for; None where none is.

    Raises
    ------
    InputError
        The floor is none (`area_of`), or something is said of a drive that nobody asked for.
    """
    if plan is not None:
        return Wanted(area_of(area or USUAL_FLOOR), longest or USUAL_LONGEST, plan)
    for option, value in (("--area", area), ("--longest", longest)):
        if value is not None:
            raise InputError("this is of the next drive", where=option, cure="Give --plan DIR, too.")
    return None


def area_of(text: str) -> Area:
    """Return the free floor ``WxD`` [m] around the origin.

    Raises
    ------
    InputError
        The text is no size, or one that no robot can use.
    """
    from fsm_calib.diagnosis.design.area import Area

    found = re.fullmatch(r"\s*(\d+(?:\.\d+)?)\s*x\s*(\d+(?:\.\d+)?)\s*", text)
    sides = tuple(map(float, found.groups())) if found else ()
    if len(sides) != 2 or not all(SMALLEST <= side <= LARGEST for side in sides):
        cure = f"Give width and depth in metres, {SMALLEST:g} to {LARGEST:g}, such as 2x2."
        raise InputError(f"{text!r} is no free floor", where="--area", cure=cure)
    width, depth = sides
    return Area(-0.5 * width, 0.5 * width, -0.5 * depth, 0.5 * depth)


def write_plan(diagnosis: Diagnosis, wanted: Wanted, seed: int) -> None:
    """Design the drive that would settle most, say what it promises, and write it."""
    import numpy as np

    from fsm_calib.diagnosis.design.belief_of import belief_of
    from fsm_calib.diagnosis.design.designer import NoDrive, design, played
    from fsm_calib.report.next_drive import write_next_drive

    belief = belief_of(diagnosis.decision)
    area = wanted.area
    plan = design(belief, area, area.centre, np.random.default_rng(seed), played(wanted.longest))
    if isinstance(plan, NoDrive):
        typer.echo(f"next drive: none. {nothing_to_learn(belief.sureness)}")
        return
    recording = diagnosis.decision.engine.simulators[0].prepared.recording
    written = write_next_drive(plan, area, recording, belief.full_speed, wanted.folder)
    width, depth = area.size
    promise = plan.forecast
    typer.echo(
        f"next drive: {width:g} x {depth:g} m, {plan.seconds:.0f} s; {plan.why}; "
        f"sure now {promise.sureness_before:.2f}, expected after it {promise.sureness:.2f}"
    )
    typer.echo(f"  {written[0]}")


def nothing_to_learn(sureness: float) -> str:
    """Return why no drive is proposed."""
    if sureness > 0.9:
        return "The answer is as sure as a drive could make it."
    return (
        "No drive on this floor would tell the explanations apart. "
        "Encoders, another floor or a load would, or a larger area."
    )
