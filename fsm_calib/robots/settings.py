"""Settings of the link to a real robot, and of the guard that owns its wheels."""

from __future__ import annotations

from dataclasses import dataclass

from fsm_calib.errors import InputError


@dataclass(frozen=True, slots=True)
class LinkSettings:
    """How a real robot is spoken to, and what stops it.

    Parameters
    ----------
    camera_bound : float
        A frame counts as taken after a call when its stamp is later by this [s]: Duckietown's driver stamps a
        frame when it publishes it, one to four frame times after the exposure.
    frame_timeout : float
        Longest wait for a frame [s]; after it the camera has delivered nothing.
    largest_command : float
        Wheel commands are cut to this [1].
    resend : float
        A held command is published again after this [s]; each time another whole PWM number may be nearest.
    quiet : float
        The guard puts the wheels to zero when the program has been silent for this [s], and the program when the guard
        has.
    patience : float
        How long a program may compute while the wheels turn [s]; then it counts as hung.
    echo : float
        The wheel driver must acknowledge a command within this [s].
    fence : float
        Farthest from the start by dead reckoning [m]; 0 takes it from the area: its farthest point and 1 m.
    lowest_battery : float
        A run is refused below this charge [%], where the robot tells it.
    lockstep : bool
        The robot is a served one whose time passes only when it is asked to, for tests.
    dither : bool
        Spread commands over Duckietown's whole PWM numbers, so that their mean is the command.
    """

    camera_bound: float = 0.1
    frame_timeout: float = 2.0
    largest_command: float = 0.8
    resend: float = 0.05
    quiet: float = 0.2
    patience: float = 1.0
    echo: float = 0.5
    fence: float = 0.0
    lowest_battery: float = 15.0
    dither: bool = True
    lockstep: bool = False

    def __post_init__(self) -> None:
        """Refuse times that would stop every run, and commands that no driver takes.

        Raises
        ------
        InputError
            A setting has no meaning.
        """
        for name in ("camera_bound", "frame_timeout", "resend", "quiet", "patience", "echo"):
            if not 0.0 <= getattr(self, name) <= 60.0:
                raise InputError(f"{name} is {getattr(self, name):g} s", where=name, cure="Give 0 to 60.")
        if not 0.0 < self.largest_command <= 1.0:
            problem = f"largest_command is {self.largest_command:g}"
            raise InputError(problem, where="largest_command", cure="Give more than 0 and at most 1.")
        if self.resend >= self.quiet:
            raise InputError(
                f"quiet ({self.quiet:g} s) is not longer than resend ({self.resend:g} s)",
                where="quiet",
                cure="Make quiet at least three times resend.",
            )
