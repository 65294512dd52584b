"""Robots that calibrate themselves, and simulations that know what they are missing."""

from __future__ import annotations

import importlib
from typing import Any

__version__ = "0.1.0"
__all__ = ["calibrate_camera", "diagnose", "identify", "investigate", "load_world", "read_recording", "run"]


def __getattr__(name: str) -> Any:
    """Return a function of `fsm_calib.api`; its libraries are loaded when it is first asked for."""
    if name in __all__:
        return getattr(importlib.import_module("fsm_calib.api"), name)
    raise AttributeError(f"module 'fsm_calib' has no attribute {name!r}")


def __dir__() -> list[str]:
    """Return the public names."""
    return sorted([*globals(), *__all__])
