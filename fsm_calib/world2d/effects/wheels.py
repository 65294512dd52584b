"""Numbers that each wheel has for itself, shared by effects (this module declares no effect)."""

from __future__ import annotations

from dataclasses import replace

from numba import njit

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


def of_one_driver_or_both(name: str, symbol: str) -> Parameter:
    """Return the choice of whose driver it is: -1 the left motor's, 1 the right one's, 0 both."""
    return Parameter(
        name, symbol, "1", 0.0, -1.0, 1.0, 0.0, "-1 the left motor's driver, 1 the right one's, 0 both",
        strength=False, fitted=False, starts=(0.0, -1.0, 1.0), mirror="negate",
    )  # fmt: skip


@njit(error_model="numpy")
def is_the_others(whose, side):
    """Return whether a choice of `of_one_driver_or_both` leaves the driver of `side` (0 left, 1 right) as it is."""
    return whose * (2 * side - 1) < 0.0
