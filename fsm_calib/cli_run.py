"""`fsm-calib run`: the main job, from a scenario to calibration files and a report."""

from __future__ import annotations

import typer


def register(app: typer.Typer) -> None:
    """Add `run` to the command line."""
