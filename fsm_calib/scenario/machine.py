"""What a scenario may say when another machine than the calibration runs: its phases, limits and published names."""

from __future__ import annotations

from dataclasses import fields
from functools import cache
from typing import Any, Literal

from pydantic import Field, create_model

from fsm_calib.actions.published import PUBLISHED as PUBLISHED_ACTIONS
from fsm_calib.machines.calibration import CALIBRATION
from fsm_calib.scenario.models import Scenario
from fsm_calib.scenario.section import mirror
from fsm_calib.statechart.machinery import Machinery

DRAWN = ("boards", "start_board")
"""Limits that are read off the scene and that no scenario gives."""


@cache
def scenario_model(machinery: Machinery) -> type[Scenario]:
    """Return the form of the scenarios of a machine; a scenario that names no phases means all of them."""
    if machinery is CALIBRATION:
        return Scenario
    phases = machinery.phases
    plan = tuple[Literal[phases], ...] if phases else tuple[()]  # type: ignore[valid-type]
    limits = mirror(machinery.limits, skip=drawn_limits(machinery))
    published = Literal[(*PUBLISHED_ACTIONS, *machinery.published)]  # type: ignore[valid-type]
    changed: dict[str, Any] = {
        "plan": (plan, Field(default=phases, description="Phases to run, in the machine's order.")),
        "limits": (limits, Field(default=limits(), description="The machine's limits.")),
        "published": (tuple[published, ...], Field(default=(), description="Named behaviours.")),
    }
    model = create_model("Scenario", __base__=Scenario, __doc__=Scenario.__doc__, **changed)
    model.phases = phases
    return model


def drawn_limits(machinery: Machinery) -> tuple[str, ...]:
    """Return the machine's limits that are read off the scene."""
    return tuple(item.name for item in fields(machinery.limits) if item.name in DRAWN)
