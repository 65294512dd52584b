"""What can go wrong in a run, each as a frozen value with the time from which it acts [s]."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from fsm_calib.world2d.scene import Wall


@dataclass(frozen=True, slots=True)
class DeadWheel:
    """One motor gets no command any more, as with a broken wire: its wheel stands or is braked as at command 0.

    Parameters
    ----------
    side : {'left', 'right'}
        Which motor.
    at : float
        Time from which it acts [s].
    """

    side: Literal["left", "right"]
    at: float = 0.0


@dataclass(frozen=True, slots=True)
class FrozenFrames:
    """The camera hands out the same picture again and again.

    Parameters
    ----------
    at : float
        Time from which it acts [s].
    """

    at: float = 0.0


@dataclass(frozen=True, slots=True)
class DroppedFrames:
    """The camera hands out nothing, for a share of the frames.

    Parameters
    ----------
    at : float
        Time from which it acts [s].
    share : float
        Share of the frames that are dropped [1].
    """

    at: float = 0.0
    share: float = 1.0


@dataclass(frozen=True, slots=True)
class MissingBoard:
    """A board is taken away.

    Parameters
    ----------
    board : int
        Number of the board [1], counted counter-clockwise from 0.
    at : float
        Time from which it acts [s].
    """

    board: int = 0
    at: float = 0.0


@dataclass(frozen=True, slots=True)
class MissingMarkers:
    """Markers of the field are taken away.

    Parameters
    ----------
    numbers : tuple of int or None
        Numbers of the markers [1]; by default all of them.
    at : float
        Time from which it acts [s].
    """

    numbers: tuple[int, ...] | None = None
    at: float = 0.0


@dataclass(frozen=True, slots=True)
class Obstacle:
    """A wall is put up.

    Parameters
    ----------
    wall : Wall
        The wall.
    at : float
        Time from which it acts [s].
    """

    wall: Wall
    at: float = 0.0


@dataclass(frozen=True, slots=True)
class BlurredCamera:
    """The lens is knocked out of focus.

    Parameters
    ----------
    defocus : float
        Standard deviation of the blur from then on [px].
    at : float
        Time from which it acts [s].
    """

    defocus: float = 4.0
    at: float = 0.0


Fault = DeadWheel | FrozenFrames | DroppedFrames | MissingBoard | MissingMarkers | Obstacle | BlurredCamera
"""Any of them."""

SCENE_FAULTS = (MissingBoard, MissingMarkers, Obstacle)
"""Those that change what stands in the area."""
