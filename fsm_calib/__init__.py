"""Robots that calibrate themselves, and simulations that know what they are missing."""

__version__ = "0.1.0"
