"""What a study file may say. Units are SI; what is not given has the default of its room."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from pydantic import Field

from fsm_calib.scenario.mirrors import Phase, Published
from fsm_calib.scenario.models import NAME_PATTERN, OutputSection, Scenario
from fsm_calib.scenario.section import Section, mirror_of
from fsm_calib.study.operator import OperatorSettings

Part = Literal["by_hand", "test_1", "test_2"]
PARTS: tuple[Part, ...] = ("by_hand", "test_1", "test_2")
"""by_hand: camera and wheels by a person; test_1: automatic wheels with the best camera by hand; test_2: all
automatic, each robot with its own new camera calibration (paper, section 4.2)."""
PAPER_PLAN = ("focus", "scan", "orientation", "wheels")
"""Phases that the paper's section 4 evaluates."""

if TYPE_CHECKING:  # what a mirror holds is known when it is made, not before
    OperatorSection: TypeAlias = Any
else:
    OperatorSection = mirror_of(OperatorSettings)


class RobotScenario(Scenario):
    """What every robot of the study goes through; name and seed are the study's business."""

    name: str = Field(
        default="robot", pattern=NAME_PATTERN, max_length=64, description="Name of the robots' scenario."
    )
    plan: tuple[Phase, ...] = Field(
        default=PAPER_PLAN,
        min_length=1,
        description="Phases of the automatic calibration, in the paper's order.",
    )
    output: OutputSection = OutputSection(frames=0, recording=False, report=False)


class SweepSection(Section):
    """One setting of the robots' scenario at several values, everything else as it is."""

    name: str = Field(..., pattern=NAME_PATTERN, max_length=64, description="Name of the sweep.")
    setting: str = Field(
        ..., description="Which setting, by its dotted path in `scenario`: scene.field.heading_sd."
    )
    values: tuple[float, ...] = Field(..., min_length=1, max_length=50, description="The values [`unit`].")
    unit: str = Field(default="", max_length=24, description="Unit of the values, for the figure.")
    whole: bool = Field(default=False, description="The setting counts something: values are whole numbers.")


class Study(Section):
    """One study: how many robots, what each goes through, what is compared."""

    name: str = Field(..., pattern=NAME_PATTERN, max_length=64, description="Name of the study.")
    title: str = Field(default="", max_length=200, description="A heading for the report.")
    seed: int = Field(default=0, ge=0, lt=2**63, description="Seed; robot i draws from (seed, i).")
    robots: int = Field(default=10, ge=1, le=1_000_000, description="How many robots.")
    variant_robots: int = Field(
        default=10,
        ge=1,
        le=1_000_000,
        description="How many of them go through each correction and each value of a sweep: the first ones.",
    )
    same_robot: bool = Field(
        default=False,
        description="One robot, calibrated again and again as in the paper, in place of a fleet: lens, mount "
        "and wheel ratio are drawn once.",
    )
    parts: tuple[Part, ...] = Field(default=PARTS, min_length=1, description="What each robot goes through.")
    operator: OperatorSection = OperatorSection()
    scenario: RobotScenario = RobotScenario()
    corrections: tuple[Published, ...] = Field(
        default=(),
        description="Corrections of the published method that are taken back one at a time, by name; test 2 "
        "is run for each, on the same robots.",
    )
    as_published: bool = Field(default=False, description="Test 2 once more with all of them taken back.")
    sweeps: tuple[SweepSection, ...] = Field(default=(), description="Sensitivity: test 2 at several values.")
