"""The noise of a recording: what blurs a pose, and what shoves the robot about.

Tag noise is white or an AR(1) sequence. Random forces make the robot's speeds differ from the equations' by an
Ornstein-Uhlenbeck process in forward, sideways and turning speed, which acts only while the robot moves. Both are
estimated, for every hypothesis anew: tag noise sets the error of one frame, speed noise what grows with time.
Source: Kristensen, Madsen & Jorgensen, Comput. Chem. Eng. 28 (2004) 1431 (process and measurement noise apart).
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from fsm_calib.types import FloatArray

LONGEST_MEMORY = 0.6  # s: a longer memory of the speed noise swallows missing physics
SHORTEST_MEMORY = 0.08  # s


@dataclass(frozen=True, slots=True)
class Noise:
    """Standard deviations of the noise.

    position [m], heading [rad]: of one measured pose. forward, sideways [m/s], turning [rad/s]: of the speed
    error. memory [s]: its correlation time. encoder [rad]: of one wheel angle. slip [rad/sqrt(s)]: random walk of
    a wheel against the floor. colour: correlation of the tag noise from frame to frame (0 = white). jitter [s]: of
    the time at which commands are followed; 0 = they are punctual, until a fit finds that they are not.
    """

    position: float = 0.003
    heading: float = 0.01
    forward: float = 0.01
    sideways: float = 0.003
    turning: float = 0.1
    memory: float = 0.3
    encoder: float = 0.02
    slip: float = 0.02
    colour: float = 0.05
    jitter: float = 0.0

    def vector(self) -> FloatArray:
        """Return the values in the order of the fields, shape (10,)."""
        return np.array([getattr(self, field.name) for field in fields(self)])

    @staticmethod
    def of(vector: FloatArray) -> Noise:
        """Return the noise with the values of `vector`, shape (10,)."""
        return Noise(*(float(value) for value in vector))


NOISE_NAMES = tuple(field.name for field in fields(Noise))
JITTER = NOISE_NAMES.index("jitter")
SMALLEST_NOISE = np.array(
    [2e-4, 5e-4, 5e-4, 3e-4, 5e-3, SHORTEST_MEMORY, 2e-3, 1e-3, 0.02, 1e-4]
)  # by field, same units
LARGEST_NOISE = np.array([0.3, 0.5, 0.5, 0.5, 5.0, LONGEST_MEMORY, 0.5, 2.0, 0.9, 0.1])
