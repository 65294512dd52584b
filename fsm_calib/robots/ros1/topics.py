"""Names of Duckietown's topics, services and parameters, and of ours, below the vehicle's name."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Topics:
    """Full names for one vehicle (dt-duckiebot-interface and dt-car-interface, daffy)."""

    vehicle: str

    def __getattr__(self, name: str) -> str:
        """Return the full name of what is called `name` in `NAMES`."""
        if name not in NAMES:
            raise AttributeError(name)
        return f"/{self.vehicle}/{NAMES[name]}"


NAMES = {
    "image": "camera_node/image/compressed",
    "camera_info": "camera_node/camera_info",
    "set_camera_info": "camera_node/set_camera_info",
    "wheels": "wheels_driver_node/wheels_cmd",
    "executed": "wheels_driver_node/wheels_cmd_executed",
    "emergency_stop": "wheels_driver_node/emergency_stop",
    "estop": "fsm_calib/estop",
    "left_tick": "left_wheel_encoder_node/tick",
    "right_tick": "right_wheel_encoder_node/tick",
    "kinematics": "kinematics_node",
    "save_calibration": "kinematics_node/save_calibration",
    "update_parameters": "kinematics_node/request_parameters_update",
    "tracker": "tracker/pose",
    "mode": "fsm_calib/mode",
    "state": "fsm_calib/state",
    "step": "fsm_calib/step",
    "stepped": "fsm_calib/stepped",
}
"""By the names that this project uses."""
OTHER_DRIVERS = ("kinematics_node",)
"""Nodes that may publish wheel commands beside us, because they do so only when somebody drives."""
