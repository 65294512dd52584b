"""The words that an effect may use to say what it is; any other is refused with the nearest of these."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

from fsm_calib.errors import UnknownNameError

Channel = Literal["forward", "lateral", "turn", "sensor"]
Where = Literal["anywhere", "disc", "area"]
When = Literal["always", "moment", "span"]
Acts = Literal["", "drag", "grip", "pose", "motor", "push"]
Input = Literal["any", "command", "twist", "wheels"]
Reads = Literal["place", "heading", "wheel_angle"]

CHANNELS = ("forward", "lateral", "turn", "sensor")
"""Where a mismatch shows: speed ahead, speed sideways, turning, or in the sensor alone."""

INPUTS = ("any", "command", "twist", "wheels")
"""Which drives can show an effect."""

STEPPED = ("set_point", "step")
"""What acts once a step, in this order: on what each motor is asked for, and on all that follows."""

COMPILED_HOOKS = ("begin", "shape", "delay", *STEPPED)
"""Where an equation acts on the robot: what `kernel` weaves into the compiled program."""

POSE_HOOKS = ("clock", "smooth", "mount", "observe")
"""Where one acts on what a pose sensor makes of the robot's poses, in this order; these are NumPy."""

HOOKS = (*COMPILED_HOOKS, *POSE_HOOKS)
"""Where an effect's equation acts (`effect`)."""

WHERE: dict[str, tuple[str, ...]] = {
    "anywhere": (),
    "disc": ("x", "y", "radius"),
    "area": ("x", "y", "half_x", "half_y"),
}
"""Where on the floor an effect acts, and the parameters [m] that say so."""

WHEN: dict[str, tuple[str, ...]] = {
    "always": (),
    "moment": ("start", "duration"),
    "span": ("start", "duration"),
}
"""When an effect acts, and the parameters [s] that say so: a moment's duration is not fitted."""

ACTS: dict[str, tuple[str, ...]] = {
    "": (),
    "drag": (),
    "grip": ("loss", "spread"),
    "pose": ("turn", "shift_x", "shift_y"),
    "motor": ("loss_left", "loss_right"),
    "push": ("impulse_x", "impulse_y", "impulse_turn"),
}
"""What an effect of a place or a time acts on, where the diagnosis has a faster scan than trying it out, and the
parameters that the scan speaks of. Empty: it is tried out by simulation."""

READS: dict[str, tuple[str, ...]] = {
    "place": ("PLACE_X", "PLACE_Y"),
    "heading": ("COS", "SIN"),
    "wheel_angle": ("ROLL",),
}
"""What a step's equation may read of the robot's whereabouts, and the slots of the workbench that hold it."""

FAMILIES = (
    *("base", "body", "command map", "drift", "event", "floor"),
    *("patch", "resistance", "sensor", "timing", "tyre", "wheel"),
)
"""Groups of effects that a report may name together when it cannot decide."""

REGIMES = (
    *("driving", "standstill", "starting", "stopping", "transient", "reverse", "after_reversal"),
    *("slow", "small_command", "large_command", "turning", "fast_turn", "one_wheel", "wheel_phase"),
    *("early", "late", "once", "span", "place", "heading"),
)
"""What an effect depends on."""


def require(kind: str, words: Iterable[str], known: Iterable[str], effect: str) -> None:
    """Refuse words that are not among the known ones (UnknownNameError with the nearest)."""
    allowed = tuple(known)
    for word in words:
        if word not in allowed:
            raise UnknownNameError(kind, word, allowed, where=f"effect {effect}")
