"""The settings of a diagnosis: every threshold by name, with its unit and where it comes from."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Settings:
    """How a diagnosis looks at recordings.

    longest_gap [s]: a longer hole in the poses breaks the chain of increments (the speed noise's memory is
    shorter, nothing is remembered across it). settle_time [s]: after unknown commands the wheels' state is unknown
    for about three drive time constants. encoder_rate [Hz]: encoders are thinned to it, a tick's quantisation is
    not white above. still_speed, moving_speed [m/s]: speed noise fades in between them. degrees_of_freedom:
    Student's t of the whitened innovations. horizon [s]: of the errors that are reported (design contract).
    simulation_step [s]: the roll-out's step in a fit (at 0.01 s the log-likelihood
    differs by 0.1 from 0.002 s, measured on three robots). own_map: poses come from a map that their own frames told,
    so that a jump at a place is the map's and no marker's that was moved. processes: so many fit side by side; no
    result depends on it.
    """

    longest_gap: float = 1.5
    settle_time: float = 0.5
    encoder_rate: float = 31.0
    still_speed: float = 0.008
    moving_speed: float = 0.025
    degrees_of_freedom: float = 8.0
    horizon: float = 2.0
    simulation_step: float = 0.01
    own_map: bool = False
    processes: int = 1


DEFAULT_SETTINGS = Settings()
