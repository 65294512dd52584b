"""Dry friction that holds at rest: a bristle that bends a little and then slides (Dahl 1968, with damping)."""

from __future__ import annotations

BEND = 0.004  # rad that a bristle bends before it slides
STABLE = 0.1  # of the stiffness and damping that a step can follow


class Bristle:
    """The dry friction of one shaft."""

    def __init__(self, usual: float, step: float, inertia: float, least: float, typical: float) -> None:
        """Take the shaft's inertia with the robot behind it and alone [kg m2], and a typical friction [N m].

        Stiffness and damping suit the usual step; a shorter one changes nothing.
        """
        self.step = step
        self.stiff = min(typical / BEND, STABLE * inertia / usual**2)
        self.damp = min(0.7 * (self.stiff * inertia) ** 0.5, 0.3 * least / usual)
        self.bent = 0.0

    def torque(self, rate: float, most: float) -> float:
        """Return the torque against the motion, at most `most`."""
        longest = most / self.stiff
        self.bent = min(max(self.bent + rate * self.step, -longest), longest)
        held = self.stiff * self.bent + self.damp * rate
        return min(max(held, -most), most)
