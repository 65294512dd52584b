"""What a scenario file may say. Units are SI; every number that is not given has the default of its room."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, field_validator

from fsm_calib.scenario.section import Section

Phase = Literal["focus", "scan", "orientation", "wheels", "exit", "lane"]
PHASES: tuple[Phase, ...] = ("focus", "scan", "orientation", "wheels", "exit", "lane")
"""The phases in the order of the paper (chapters 6, 3.2, 3.3, 3.4, 5.1, 5.2)."""

NAME_PATTERN = r"^[A-Za-z][A-Za-z0-9_-]*$"


class RobotSection(Section):
    """The robot that is to be calibrated."""

    name: str = Field(
        default="duckiebot",
        pattern=NAME_PATTERN,
        max_length=64,
        description="Name of the robot and of its calibration files.",
    )
    source: Literal["nominal", "fleet"] = Field(
        default="fleet",
        description="`nominal`: equal wheels and the fleet's median camera; `fleet`: drawn with the seed "
        "from the statistics of real Duckiebots.",
    )
    wheel_ratio: float | None = Field(
        default=None,
        gt=0.5,
        lt=2.0,
        description="The true wheel ratio k (right command over left command) for straight driving.",
    )


class OutputSection(Section):
    """What a run leaves behind."""

    frames: int = Field(default=24, ge=0, le=500, description="Camera frames kept for the report.")
    recording: bool = Field(default=True, description="Write the drive as a recording.")
    report: bool = Field(default=True, description="Write report.html.")


class Scenario(Section):
    """One calibration run: who, where, which phases, with which settings and faults."""

    name: str = Field(..., pattern=NAME_PATTERN, max_length=64, description="Name of the scenario.")
    seed: int = Field(
        default=0, ge=0, lt=2**63, description="Seed of everything random; the same seed gives the same run."
    )
    robot: RobotSection = RobotSection()
    plan: tuple[Phase, ...] = Field(
        default=("scan", "orientation", "wheels", "exit", "lane"),
        min_length=1,
        description="Phases to run, in the paper's order.",
    )
    output: OutputSection = OutputSection()

    @field_validator("plan")
    @classmethod
    def _in_order(cls, plan: tuple[Phase, ...]) -> tuple[Phase, ...]:
        """Refuse a plan that repeats a phase or leaves the paper's order."""
        if [phase for phase in PHASES if phase in plan] != list(plan):
            raise ValueError(f"phases come once each and in the order {', '.join(PHASES)}")
        return plan
