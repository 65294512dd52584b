"""The sections of a scenario that mirror settings of other rooms, and the names those rooms declare."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from fsm_calib.actions.published import PUBLISHED as PUBLISHED_ACTIONS
from fsm_calib.actions.settings import ActionSettings
from fsm_calib.machines.limits import PUBLISHED as PUBLISHED_LIMITS
from fsm_calib.machines.limits import Limits
from fsm_calib.machines.supervisor import PHASES
from fsm_calib.scenario.section import mirror, mirror_of
from fsm_calib.types import BoardSpec
from fsm_calib.world2d.scene import BoardPlacement, MarkerField, Road, Wall

if TYPE_CHECKING:  # what a mirror holds is known when it is made, not before
    Phase: TypeAlias = str
    Published: TypeAlias = str
    LimitsSection: TypeAlias = Any
    ActionsSection: TypeAlias = Any
    FieldSection: TypeAlias = Any
    RoadSection: TypeAlias = Any
    PlacedBoard: TypeAlias = Any
    BoardSection: TypeAlias = Any
    WallSection: TypeAlias = Any
else:
    Phase = Literal[PHASES]
    Published = Literal[(*PUBLISHED_ACTIONS, *PUBLISHED_LIMITS)]
    LimitsSection = mirror(Limits, skip=("boards", "start_board"))
    ActionsSection = mirror(ActionSettings, skip=("board",))
    FieldSection = mirror_of(MarkerField)
    RoadSection = mirror(Road, skip=("start",))
    PlacedBoard = mirror_of(BoardPlacement)
    BoardSection = mirror_of(BoardSpec)
    WallSection = mirror_of(Wall)
