"""Duckietown's DTPS library and messages, where they are installed."""

from __future__ import annotations

import importlib
from typing import Any

from fsm_calib.errors import InputError

MESSAGES = {
    "pwm": ("duckietown_messages.actuators.differential_pwm", "DifferentialPWM"),
    "image": ("duckietown_messages.sensors.compressed_image", "CompressedImage"),
    "bool": ("duckietown_messages.standard.boolean", "Boolean"),
    "integer": ("duckietown_messages.standard.integer", "Integer"),
    "text": ("duckietown_messages.standard.string", "String"),
    "header": ("duckietown_messages.standard.header", "Header"),
}
"""Messages by what this project calls them."""


def load(module: str) -> Any:
    """Return a module of the library.

    Raises
    ------
    InputError
        It is not installed.
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise InputError(
            f"robots with DTPS need Duckietown's library, and {error.name} is not installed",
            where="robot.connect",
            cure="pip install 'fsm-calib[dtps]'",
        ) from error


def message(kind: str) -> Any:
    """Return a message's class, by the names of `MESSAGES`.

    Raises
    ------
    InputError
        The library is not installed.
    """
    module, name = MESSAGES[kind]
    return getattr(load(module), name)
