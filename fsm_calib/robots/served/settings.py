"""How a served robot differs from the simulated one: delays, losses, whole numbers."""

from __future__ import annotations

from dataclasses import dataclass

from fsm_calib.errors import InputError


@dataclass(frozen=True, slots=True)
class ServeSettings:
    """A served robot's camera, wheel driver and clock.

    Parameters
    ----------
    rate : float
        Frames and encoder readings in a second [Hz]; Duckietown: 30.
    camera_latency, camera_jitter : float
        From the exposure of a frame to its publication and stamp: mean and standard deviation [s].
    command_latency, command_jitter : float
        From the arrival of a command to the motors: mean and standard deviation [s]; their order is kept.
    dropped : float
        Share of frames that are lost [1].
    late, late_by : float
        Share of frames that arrive late [1], and by how much [s]: after newer ones.
    clock_offset : float
        The robot's clock minus this computer's [s].
    pwm_steps : bool
        The driver floors commands to whole PWM numbers, as Duckietown's does.
    tracker : float
        Poses in a second that a camera over the area publishes for recordings [Hz]; 0: there is none. The program
        never listens to them.
    tracker_noise : float
        Standard deviation of their position [m]; that of the heading is five times as many rad.
    dead_zone : float
        Commands up to this release the wheel [1]; daffy 0.01, ente 0.2.
    encoders : bool
        The wheels have encoders; a DB18 has none.
    """

    rate: float = 30.0
    camera_latency: float = 0.08
    camera_jitter: float = 0.01
    command_latency: float = 0.005
    command_jitter: float = 0.01
    dropped: float = 0.0
    late: float = 0.0
    late_by: float = 0.08
    clock_offset: float = 0.0
    pwm_steps: bool = True
    tracker: float = 0.0
    tracker_noise: float = 0.002
    dead_zone: float = 0.01
    encoders: bool = True

    def __post_init__(self) -> None:
        """Refuse what no robot is.

        Raises
        ------
        InputError
            A setting has no meaning.
        """
        if not 1.0 <= self.rate <= 120.0:
            raise InputError(f"the rate is {self.rate:g} Hz", where="rate", cure="Give 1 to 120.")
        if not 0.0 <= self.tracker <= 120.0:
            raise InputError(
                f"the tracker's rate is {self.tracker:g} Hz", where="tracker", cure="Give 0 to 120."
            )
        for name in (
            "camera_latency",
            "camera_jitter",
            "command_latency",
            "command_jitter",
            "late_by",
            "tracker_noise",
        ):
            if not 0.0 <= getattr(self, name) <= 2.0:
                raise InputError(f"{name} is {getattr(self, name):g}", where=name, cure="Give 0 to 2.")
        for name in ("dropped", "late", "dead_zone"):
            if not 0.0 <= getattr(self, name) < 1.0:
                raise InputError(f"{name} is {getattr(self, name):g}", where=name, cure="Give 0 to below 1.")
