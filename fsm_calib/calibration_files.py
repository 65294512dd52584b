"""Duckietown's own calibration files, as a robot reads them from ``/data/config/calibrations``.

``kinematics/NAME.yaml`` is the flat mapping of dt-car-interface
(``packages/dagu_car/src/kinematics_node.py``): the driver computes ``u_right = omega_right (gain + trim) /
k`` and ``u_left = omega_left (gain - trim) / k``, so a wheel ratio k_w (right command over left command) is
``trim = gain (k_w - 1) / (k_w + 1)`` at an unchanged mean speed. The camera's files are written by
`fsm_calib.perception.camera_files`.
"""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from fsm_calib.errors import InputError
from fsm_calib.journal import write_atomically
from fsm_calib.scenario.yaml_source import YamlDocument, read_yaml
from fsm_calib.types import WheelCalibration, is_finite_number

TIME_FORMAT = "%Y-%m-%d-%H-%M-%S"
"""Form of ``calibration_time`` in Duckietown's kinematics files."""

REQUIRED = ("gain", "trim", "baseline", "radius", "k", "limit")
"""Keys that every kinematics file of a real robot has."""


@dataclass(frozen=True)
class KinematicsFile:
    """What a kinematics file holds.

    Parameters
    ----------
    wheels : WheelCalibration
        Gain, wheel ratio (from gain and trim), axle length, wheel radius, motor constant, limit.
    v_max : float
        Largest forward speed that the driver accepts [m/s].
    omega_max : float
        Largest turn rate that the driver accepts [rad/s].
    calibrated : str
        When, as `TIME_FORMAT`; empty when the file does not tell.
    """

    wheels: WheelCalibration
    v_max: float = 1.0
    omega_max: float = 8.0
    calibrated: str = ""


def kinematics_text(wheels: WheelCalibration, calibrated: datetime, provenance: str = "") -> str:
    """Return the text of a kinematics file; every line of `provenance` becomes a comment."""
    values: dict[str, Any] = {
        "baseline": wheels.axle_length,
        "calibration_time": calibrated.strftime(TIME_FORMAT),
        "gain": wheels.gain,
        "k": wheels.motor_constant,
        "limit": wheels.limit,
        "omega_max": KinematicsFile(wheels).omega_max,
        "radius": wheels.wheel_radius,
        "trim": round(wheels.trim, 6),
        "v_max": KinematicsFile(wheels).v_max,
    }
    return comment(provenance) + "".join(f"{name}: {value}\n" for name, value in values.items())


def comment(text: str) -> str:
    """Return `text` as YAML comment lines."""
    return "".join(f"# {line}\n" for line in text.splitlines())


def read_kinematics(path: str | Path) -> KinematicsFile:
    """Read a kinematics file, ours or a robot's.

    Raises
    ------
    InputError
        A key is missing or its value is no finite number (with file:line:column); gain and trim give no
        wheel ratio.
    """
    document = read_yaml(path)
    number = {name: _number(document, name) for name in REQUIRED}
    gain, trim = number["gain"], number["trim"]
    if gain <= abs(trim):
        cure = "Expected gain > |trim|: otherwise a wheel never turns."
        raise InputError(f"gain {gain} and trim {trim}", where=document.where(("trim",)), cure=cure)
    wheels = WheelCalibration(
        wheel_ratio=(gain + trim) / (gain - trim),
        gain=gain,
        axle_length=number["baseline"],
        wheel_radius=number["radius"],
        motor_constant=number["k"],
        limit=number["limit"],
    )
    rest = {name: _number(document, name) for name in ("v_max", "omega_max") if name in document.data}
    return KinematicsFile(wheels, calibrated=str(document.data.get("calibration_time", "")), **rest)


def _number(document: YamlDocument, name: str) -> float:
    """Return the finite number called `name`."""
    if not isinstance(document.data, dict) or name not in document.data:
        raise InputError(f"the key {name!r} is missing", where=document.where(), cure="Add it.")
    value = document.data[name]
    if not is_finite_number(value):
        raise InputError(f"{name} is {value!r}", where=document.where((name,)), cure="Expected a number.")
    return float(value)


def write_kinematics(
    directory: Path, name: str, wheels: WheelCalibration, calibrated: datetime, provenance: str = ""
) -> Path:
    """Write ``directory/kinematics/NAME.yaml`` and return its path."""
    path = directory / "kinematics" / f"{name}.yaml"
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(path, kinematics_text(wheels, calibrated, provenance).encode())
    return path
