"""The plain robot's roll-out in local variables is the general step's, but for the order of roundings."""

import numpy as np
import pytest

from fsm_calib.world2d.kernel import flag_places, kernel
from fsm_calib.world2d.loop import OUTPUTS
from fsm_calib.world2d.parameters import parameters
from fsm_calib.world2d.rollout import Drive, active_flags, working_arrays

SAMPLES = np.arange(0.0, 20.0, 0.03)


def rolled(vector, general, dt):
    """Return the states; with `general` a hook is switched on that does nothing at its null value."""
    rng = np.random.default_rng(3)
    times = np.sort(rng.uniform(0.0, 20.0, 60))
    drive = Drive(times, *rng.choice([-0.6, -0.2, 0.0, 0.0, 0.3, 1.0], size=(2, 60)))
    on = active_flags(vector[None])
    on[0, flag_places()["tyre_scrub"]] = general
    out = np.empty((1, SAMPLES.size, OUTPUTS))
    starts, track = np.array([[0.2, -0.1, 0.4, 0.1, 0.02, -0.5]]), np.zeros((0, 5))
    arrays = drive.padded(0.0)
    kernel().run_many(
        vector[None],
        on,
        *working_arrays(arrays[0].size),
        np.zeros(1, dtype=int),
        *arrays,
        SAMPLES,
        starts,
        track,
        dt,
        out,
    )
    return out[0]


@pytest.mark.parametrize("dt", [0.002, 0.005])
@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"gain_left": 0.7, "gain_right": 0.52, "wheel_radius_left": 0.033, "axle_length": 0.12},
        {"slip_speed": 1e-3, "friction": 0.3, "tau_forward": 0.03, "tau_turn": 0.05},
        {"slip_ratio": 0.3, "slip_speed": 1e-3, "gain_left": 0.7},
        {"wheel_inertia": 0.0, "caster_share": 0.2, "mass": 2.5},
        {"command_delay.delay": 0.12, "motor_deadband.offset": 0.05},
    ],
)
def test_plain_and_general_step_agree(changes, dt):
    vector = parameters(changes)
    on_arrays = rolled(vector, general=True, dt=dt)
    in_variables = rolled(vector, general=False, dt=dt)
    assert np.abs(on_arrays[-1, :2] - on_arrays[0, :2]).max() > 0.05
    np.testing.assert_allclose(in_variables, on_arrays, rtol=0.0, atol=1e-10)
