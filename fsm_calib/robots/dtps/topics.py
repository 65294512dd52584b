"""Names of ente's topics, and of ours, below the vehicle's name (dt-duckiebot-interface, ente)."""

from __future__ import annotations

NAMES = {
    "image": "sensor/camera/front_center/jpeg",
    "wheels": "actuator/wheels/base/pwm",
    "executed": "actuator/wheels/base/pwm_executed",
    "emergency_stop": "actuator/wheels/base/estop",
    "left_tick": "sensor/wheel_encoder/left/ticks",
    "right_tick": "sensor/wheel_encoder/right/ticks",
    "estop": "fsm_calib/estop",
    "step": "fsm_calib/step",
    "stepped": "fsm_calib/stepped",
}
"""By the names that this project uses."""
RESOLUTION = 135
"""Ticks of one turn of a wheel."""
