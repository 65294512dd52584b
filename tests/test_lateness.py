"""How late a robot is by itself, and two delays that are one."""

import pytest

from fsm_calib.world2d.effects.lateness import may_be_built_so

PLAIN = {
    "command_delay.delay": 0.0,
    "observation_delay.delay": 0.0,
    "speed_controller.hold": 0.0,
    "caster_drag.drag": 0.0,
}


@pytest.mark.parametrize(
    ("commands", "poses", "one"),
    [
        (0.038, -0.059, True),
        (-0.05, 0.06, True),
        (0.1, -0.01, False),
        (0.04, 0.05, False),
        (0.06, 0.0, False),
    ],
)
def test_delays_that_mostly_cancel_are_one_lateness(commands, poses, one):
    model = {**PLAIN, "command_delay.delay": commands, "observation_delay.delay": poses}
    assert may_be_built_so({**model, "delay": commands}) is one


@pytest.mark.parametrize(
    ("late", "built"), [({"delay": 0.015}, True), ({"delay": 0.0, "apart": 0.03}, False)]
)
def test_a_controller_is_late_by_half_of_its_period(late, built):
    assert may_be_built_so({**PLAIN, "speed_controller.hold": 0.2, **late}) is built
