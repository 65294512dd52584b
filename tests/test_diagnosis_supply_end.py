"""The supply behind a speed controller ends somewhere above full command: how such robots are built."""

from functools import partial

import diagnosis_robots
import numpy as np
import pytest
from diagnosis_robots import engine_of, fitted_number, judged, recording

from fsm_calib.diagnosis.candidates.free_number import found_free
from fsm_calib.diagnosis.candidates.supply_end import CEILING, LOOP
from fsm_calib.diagnosis.candidates.whole_base import fit_whole_base
from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.world2d.effects import registry

RIVALS = ("command_saturation", "motor_asymmetric_lag", "command_delay", "battery_sag")
HELD = {"speed_controller__hold": 5.0}
ENDING = {**HELD, "speed_controller__ceiling": 1.2, "speed_controller__loop": 3.0}
speeds = partial(
    diagnosis_robots.speeds, gain_left=0.6, gain_right=0.6, tau_forward=0.1, slip_speed=1e-4, **HELD
)


def test_it_is_the_law_of_a_supply_that_is_short():
    grid = np.arange(0.0, 3.0, 0.01)
    own, short = (
        speeds([0.0, 1.5], [0.9, -0.5], grid, **{f"{effect}__{end}": 0.95, f"{effect}__loop": 2.0})
        for effect, end in (("speed_controller", "ceiling"), ("command_saturation", "voltage"))
    )
    assert own == pytest.approx(short, abs=1e-12)
    assert np.abs(own - speeds([0.0, 1.5], [0.9, -0.5], grid)).max() > 0.05


@pytest.mark.parametrize("ceiling", [1.1, 1.3])
def test_full_command_is_reached_late(ceiling):
    grid = np.arange(0.0, 3.0, 0.01)
    ending = {**ENDING, "speed_controller__ceiling": ceiling}
    held, free = speeds([0.0], [1.0], grid, **ending), speeds([0.0], [1.0], grid)
    assert held[-1] == pytest.approx(free[-1], rel=1e-3)
    assert held[20] < 0.9 * free[20]


def based(*recordings):
    return fit_whole_base(engine_of(*recordings), [registry()[name] for name in RIVALS])


def test_a_robot_whose_supply_ends_is_given_its_end():
    fit = based(*(recording(seed, **ENDING) for seed in (0, 1)))
    assert fitted_number(fit, CEILING) == pytest.approx(1.2, abs=0.04)
    assert fitted_number(fit, LOOP) == pytest.approx(3.0, rel=0.15)


def test_a_robot_with_volts_to_spare_has_none():
    fit = based(*(recording(seed, **HELD) for seed in (0, 1)))
    assert not found_free(fit, CEILING)


def test_it_is_said_and_never_accused():
    others = set(registry()) - set(RIVALS)
    found = diagnose([recording(seed, **ENDING) for seed in (0, 1)], without=others)
    assert found.decision.outcome == "match"
    assert found.verdict.base[CEILING].value == pytest.approx(1.2, abs=0.04)
    assert any("the supply behind the controller ends at 1." in note for note in found.notes)


def test_a_supply_that_is_short_is_a_finding():
    decision = judged(RIVALS, **HELD, command_saturation__voltage=0.75, command_saturation__loop=3.0)
    assert [belief.name for belief in decision.named] == ["command_saturation"]
    assert fitted_number(decision.model.fit, "command_saturation.voltage") == pytest.approx(0.75, abs=0.03)
