"""Numbers that each wheel has for itself, shared by effects (this module declares no effect)."""

from __future__ import annotations

from dataclasses import replace

from fsm_calib.world2d.effects.parameter import Parameter


def of_each_wheel(either: Parameter) -> tuple[Parameter, Parameter]:
    """Return a parameter of the left and of the right wheel, which change places in a mirrored robot.

    either : what is the same in both; the side is added to its name, and its first letter to the symbol.
    """
    left, right = (
        replace(
            either,
            name=f"{either.name}_{side}",
            symbol=f"{either.symbol}_{side[0]}",
            mirror=f"swap:{either.name}_{other}",
        )
        for side, other in (("left", "right"), ("right", "left"))
    )
    return left, right
