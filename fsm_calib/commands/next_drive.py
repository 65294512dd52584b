"""What `diagnose --plan` does: the next drive designed, told and written."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

import typer

from fsm_calib.errors import InputError

if TYPE_CHECKING:
    from fsm_calib.diagnosis.design.area import Area
    from fsm_calib.diagnosis.diagnose import Diagnosis

SMALLEST, LARGEST = 0.6, 50.0  # m: a side of the floor; below it a robot only turns on the spot


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


def write_plan(diagnosis: Diagnosis, area: Area, longest: float, folder: Path, seed: int) -> None:
    """Design the drive that would settle most, say what it promises, and write it."""
    import numpy as np

    from fsm_calib.diagnosis.design.belief_of import belief_of
    from fsm_calib.diagnosis.design.designer import NoDrive, design, played
    from fsm_calib.report.next_drive import write_next_drive

    belief = belief_of(diagnosis.decision)
    plan = design(belief, area, area.centre, np.random.default_rng(seed), played(longest))
    if isinstance(plan, NoDrive):
        typer.echo(f"next drive: none. {nothing_to_learn(belief.sureness)}")
        return
    recording = diagnosis.decision.engine.simulators[0].prepared.recording
    written = write_next_drive(plan, area, recording, belief.full_speed, folder)
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
