"""What a scenario file may say. Units are SI; every number that is not given has the default of its room."""

from __future__ import annotations

from typing import ClassVar, Literal

import numpy as np
from pydantic import Field, field_validator, model_validator

from fsm_calib.machines.supervisor import PHASES
from fsm_calib.robots.address import VEHICLE_PATTERN
from fsm_calib.scenario.mirrors import (
    ActionsSection,
    BaseSection,
    BoardSection,
    EffectsSection,
    FaultSection,
    FieldSection,
    InvestigateSection,
    LimitsSection,
    LinkSection,
    MountSection,
    Phase,
    PlacedBoard,
    PoseSection,
    Published,
    RoadSection,
    SensorSection,
    ServeSection,
    TrackerSection,
    WallSection,
    WearSection,
    WorldSection,
    beyond_size,
)
from fsm_calib.scenario.section import Section
from fsm_calib.types import CameraModel

NAME_PATTERN = r"^[A-Za-z][A-Za-z0-9_-]*$"
"""Names become file names."""


class CameraSection(Section):
    """A lens: pinhole and plumb_bob distortion [px, 1]; `k4` to `k6` make it a rational one."""

    fx: float = Field(..., gt=50, lt=5000, description="Focal length along x [px].")
    fy: float = Field(..., gt=50, lt=5000, description="Focal length along y [px].")
    cx: float = Field(..., gt=0, lt=5000, description="Principal point along x [px].")
    cy: float = Field(..., gt=0, lt=5000, description="Principal point along y [px].")
    k1: float = Field(default=0.0, description="First radial coefficient [1].")
    k2: float = Field(default=0.0, description="Second radial coefficient [1].")
    p1: float = Field(default=0.0, description="First tangential coefficient [1].")
    p2: float = Field(default=0.0, description="Second tangential coefficient [1].")
    k3: float = Field(default=0.0, description="Third radial coefficient [1].")
    k4: float | None = Field(
        default=None, description="First coefficient of the rational model's denominator [1]."
    )
    k5: float | None = Field(
        default=None, description="Second coefficient of the rational model's denominator [1]."
    )
    k6: float | None = Field(
        default=None, description="Third coefficient of the rational model's denominator [1]."
    )

    def build(self) -> CameraModel:
        """Return the camera model, 640 x 480."""
        matrix = np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])
        plumb_bob = [self.k1, self.k2, self.p1, self.p2, self.k3]
        if self.k4 is None and self.k5 is None and self.k6 is None:
            return CameraModel(matrix, np.array(plumb_bob))
        rational = [value or 0.0 for value in (self.k4, self.k5, self.k6)]
        return CameraModel(matrix, np.array([*plumb_bob, *rational]), model="rational_polynomial")


class KnownSection(Section):
    """What the robot knows from an earlier calibration."""

    camera: bool = Field(default=False, description="It knows its lens and how the camera is mounted.")
    wheel_ratio: float | None = Field(
        default=None, gt=0.5, lt=2.0, description="The wheel ratio k in use [1]."
    )
    ratio_drift: float | None = Field(
        default=None,
        gt=-0.5,
        lt=0.5,
        description="The wheel ratio was calibrated, and the true one has since drifted by this share [1]: "
        "k in use = true k / (1 + ratio_drift).",
    )
    errors: float = Field(
        default=1.0,
        ge=0.0,
        le=20.0,
        description="How wrong this knowledge is, as a multiple of what a calibration leaves [1]: camera 0.15 px, "
        "tilt 0.1 deg, yaw 0.5 deg, wheel ratio 0.1 % (not of `wheel_ratio`, which is taken as given).",
    )


class RobotSection(Section):
    """The robot that is to be calibrated."""

    name: str = Field(
        default="duckiebot",
        pattern=NAME_PATTERN,
        max_length=64,
        description="Name of the robot and of its calibration files.",
    )
    connect: Literal["simulated", "ros1", "dtps"] = Field(
        default="simulated",
        description="`simulated`: in the world of this file; `ros1`: a real robot with Duckietown's daffy; `dtps`: "
        "with ente. What describes a simulated robot is then without effect; the scene is the real area's drawing.",
    )
    vehicle: str | None = Field(
        default=None,
        pattern=f"^{VEHICLE_PATTERN}$",
        max_length=64,
        description="What a real robot's topics begin with; by default `name`.",
    )
    host: str | None = Field(
        default=None,
        min_length=1,
        max_length=253,
        description="Where a real robot is reached; by default `VEHICLE.local`.",
    )
    port: int | None = Field(
        default=None,
        gt=0,
        lt=65536,
        description="Port of the ROS master (11311) or DTPS switchboard (11511).",
    )
    link: LinkSection = LinkSection()
    serve: ServeSection = ServeSection()
    source: Literal["nominal", "fleet"] = Field(
        default="fleet",
        description="`nominal`: equal wheels and the fleet's median camera; `fleet`: drawn with the seed "
        "from the statistics of real Duckiebots.",
    )
    camera: CameraSection | None = Field(
        default=None, description="The true lens, in place of the drawn one."
    )
    mount: MountSection | None = Field(
        default=None, description="Where the camera truly sits, in place of the drawn mount."
    )
    known: KnownSection = Field(
        default=KnownSection(), description="What the robot knows from an earlier calibration."
    )
    start: PoseSection | None = Field(
        default=None,
        description="Where the robot begins, in the area's frame; by default between the boards.",
    )
    start_in_lane: float | None = Field(
        default=None,
        ge=0.0,
        le=20.0,
        description="Begin in the middle of the lane instead, this far along it [m].",
    )
    speed: float | None = Field(
        default=None, gt=0.1, lt=5.0, description="All motor gains, as a share of the nominal ones [1]."
    )
    base: BaseSection = Field(default=BaseSection(), description="Physics of the base robot.")
    effects: EffectsSection = Field(
        default=EffectsSection(), description="Physics beyond the nominal robot, switched on by name."
    )
    wheel_ratio: float | None = Field(
        default=None,
        gt=0.5,
        lt=2.0,
        description="The true wheel ratio k (right command over left command) for straight driving [1].",
    )

    @model_validator(mode="after")
    def _physical(self) -> RobotSection:
        if said := beyond_size(self.base, self.effects, self.speed):
            raise ValueError(said)
        return self


class BoardsSection(Section):
    """The chessboards around the robot."""

    layout: Literal["mixed", "upright"] = Field(
        default="mixed",
        description="`mixed`: leaned, turned and one flat on the floor; `upright`: as in the paper.",
    )
    count: int = Field(default=3, ge=1, le=6, description="How many [1].")
    board: BoardSection = Field(default=BoardSection(), description="Form of the chessboards.")
    placed: tuple[PlacedBoard, ...] | None = Field(
        default=None, min_length=1, max_length=12, description="Boards one by one, in place of a layout."
    )
    start_board: int | None = Field(
        default=None,
        ge=0,
        description="Number of the board ahead of the robot at the start [1]; by default found from the layout.",
    )


class SceneSection(Section):
    """The calibration area: chessboards ahead, floor markers behind, the marked lane beyond them."""

    boards: BoardsSection = Field(default=BoardsSection(), description="The chessboards around the robot.")
    field: FieldSection = Field(
        default=FieldSection(), description="The field of floor markers behind the robot."
    )
    road: RoadSection = Field(default=RoadSection(), description="The lane beyond the field.")
    walls: tuple[WallSection, ...] = Field(
        default=(), description="Walls in the area, beside those of the hall."
    )


class OutputSection(Section):
    """What a run leaves behind."""

    frames: int = Field(default=24, ge=0, le=500, description="Camera frames kept for the report [1].")
    recording: bool = Field(
        default=True, description="Write the drive as a recording (fsm-calib/recording@1)."
    )
    bag: Literal["none", "ros1", "mcap"] = Field(
        default="mcap", description="Write the drive as a ROS 1 bag or as a ROS 2 bag of MCAP, too."
    )
    pose_noise: float = Field(
        default=0.001,
        ge=0.0,
        le=1.0,
        description="Noise of the recorded poses, standard deviation of x and y [m].",
    )
    heading_noise: float = Field(
        default=0.005, ge=0.0, le=1.0, description="Noise of the recorded headings, standard deviation [rad]."
    )
    report: bool = Field(default=True, description="Write report.html.")


class Scenario(Section):
    """One calibration run: who, where, which phases, with which settings and faults."""

    phases: ClassVar[tuple[str, ...]] = PHASES

    name: str = Field(..., pattern=NAME_PATTERN, max_length=64, description="Name of the scenario.")
    seed: int = Field(
        default=0,
        ge=0,
        lt=2**63,
        description="Seed of everything random [1]; the same seed gives the same run.",
    )
    robot: RobotSection = Field(default=RobotSection(), description="The robot that is to be calibrated.")
    scene: SceneSection = Field(default=SceneSection(), description="The calibration area.")
    sensor: SensorSection = Field(
        default=SensorSection(), description="How the camera turns light into a file."
    )
    world: WorldSection = Field(default=WorldSection(), description="How the world is simulated.")
    wear: WearSection = Field(
        default=WearSection(), description="How the true wheel ratio drifts while driving."
    )
    faults: tuple[FaultSection, ...] = Field(
        default=(), max_length=20, description="What goes wrong, and when."
    )
    plan: tuple[Phase, ...] = Field(
        default=PHASES, min_length=1, description="Phases to run, in the paper's order."
    )
    limits: LimitsSection = Field(
        default=LimitsSection(), description="How often, how long and how well the machines try."
    )
    actions: ActionsSection = Field(
        default=ActionsSection(), description="Settings of what the machines' states do."
    )
    published: tuple[Published, ...] = Field(
        default=(), description="Behaviours of the published method that replace the corrected ones, by name."
    )
    output: OutputSection = Field(default=OutputSection(), description="What a run leaves behind.")
    investigate: InvestigateSection = Field(
        default=InvestigateSection(), description="Where `fsm-calib investigate` may drive, and how long."
    )
    tracker: TrackerSection = Field(
        default=TrackerSection(),
        description="The camera at the ceiling that `investigate` gets its poses from.",
    )

    @field_validator("plan")
    @classmethod
    def _in_order(cls, plan: tuple[str, ...]) -> tuple[str, ...]:
        """Refuse a plan that repeats a phase or leaves the paper's order."""
        if [phase for phase in cls.phases if phase in plan] != list(plan):
            raise ValueError(f"phases come once each and in the order {', '.join(cls.phases)}")
        return plan
