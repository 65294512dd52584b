"""A Duckiebot's battery, as its health service tells it over HTTP (dt-device-health, port 8085)."""

from __future__ import annotations

import json
import urllib.error
import urllib.request

from fsm_calib.errors import EmergencyStopped

PORT, TIMEOUT = 8085, 2.0
"""Port of the health service; longest wait for it [s]."""


def charge_of(host: str, port: int = PORT) -> float | None:
    """Return the charge [%]; None when the robot does not tell it."""
    try:
        with urllib.request.urlopen(f"http://{host}:{port}/battery", timeout=TIMEOUT) as answer:
            return float(json.load(answer)["percentage"])
    except (OSError, urllib.error.URLError, ValueError, KeyError, TypeError):
        return None


def refuse_flat(host: str, lowest: float, port: int = PORT) -> None:
    """Refuse a robot whose battery is low; one that does not tell is let through.

    Raises
    ------
    EmergencyStopped
        The charge is below `lowest` [%].
    """
    charge = charge_of(host, port)
    if charge is not None and charge < lowest:
        problem = f"The battery is at {charge:.0f} %, less than {lowest:.0f} % (robot.link.lowest_battery)"
        raise EmergencyStopped(problem, cure="Charge it: a falling voltage changes the wheels' answer.")
