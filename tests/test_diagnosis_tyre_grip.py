"""The grip and the slip ratio of the tyres: free where recordings ask for them, nominal where nothing shows them."""

import diagnosis_robots
import pytest
from diagnosis_robots import engine_of, judged, recording, selector_on, with_encoders

from fsm_calib.diagnosis.candidates.free_number import found_free
from fsm_calib.diagnosis.candidates.tyre_grip import RATIO
from fsm_calib.diagnosis.candidates.whole_base import fit_whole_base
from fsm_calib.diagnosis.fitting.base import fit_base
from fsm_calib.diagnosis.verdict.bared import ranked_if_bared
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table
from fsm_calib.world2d.rollout import Drive

SPOT = {"loss": 0.9, "x": 0.4, "y": 0.0, "radius": 0.4}


def reversals(rng, duration=40.0):
    """Return held commands that reverse at speeds at which tyres slip."""
    time, left, right, at = [], [], [], 0.5
    while at < duration:
        u = rng.uniform(0.5, 1.0)
        a, b = [(u, u), (-u, -u), (u, -u), (-u, u)][rng.integers(4)]
        for pair, hold in (((a, b), 0.4), ((-a, -b), 0.4), ((0.0, 0.0), 0.3)):
            time.append(at)
            left.append(pair[0])
            right.append(pair[1])
            at += hold
    return Drive(time, left, right)


def grip_of(places=(), **changes):
    """Return the fitted grip [1] and its standard deviation; None where it was held."""
    return number_of("friction", [recording(seed, **changes) for seed in (0, 1)], places)


def number_of(name, recordings, places=()):
    """Return a number of the base robot and its standard deviation; None where it was held."""
    engine = engine_of(*recordings)
    fit = fit_whole_base(engine, [registry()[name] for name in places])
    place = parameter_table().place(name)
    found = [(value, variance**0.5) for slot, value, variance in fit.numbers() if slot.place == place]
    return found[0] if found else None


def test_a_floor_of_little_grip_shows_in_the_base_robot():
    value, sd = grip_of(friction=0.3)
    assert value == pytest.approx(0.3, abs=4.0 * sd)
    assert sd < 0.01


@pytest.mark.parametrize("grip", [0.6, 0.75, 0.9])
def test_a_grip_that_no_drive_shows_is_held(grip):
    assert grip_of(friction=grip) is None


def test_a_slippery_spot_is_no_smaller_grip_of_the_whole_floor():
    changes = {f"low_friction_patch__{name}": value for name, value in SPOT.items()}
    assert grip_of(**changes) is not None
    assert grip_of(["low_friction_patch"], **changes) is None


def test_a_floor_of_little_grip_beside_a_place_is_free():
    changes = {f"rough_floor_patch__{name}": value for name, value in {"x": 0.1, "y": 0.0}.items()}
    changes |= {"rough_floor_patch__drag": 0.4, "friction": 0.3, "duration": 40.0}
    value, sd = grip_of(["rough_floor_patch"], **changes)
    assert value == pytest.approx(0.3, abs=4.0 * sd)


def test_a_floor_of_little_grip_is_no_limit_of_the_motors(monkeypatch):
    monkeypatch.setattr(diagnosis_robots, "drive", reversals)
    assert judged(["command_saturation", "motor_asymmetric_lag"], friction=0.5).outcome == "match"


def test_a_slip_that_grows_with_the_rolling_speed_shows_in_encoders():
    value, sd = number_of("slip_ratio", [with_encoders(seed, slip_ratio=0.3) for seed in (0, 1)])
    assert value == pytest.approx(0.3, abs=4.0 * sd)
    assert sd < 0.05


def test_a_slip_that_does_not_grow_with_the_rolling_speed_needs_no_ratio():
    assert number_of("slip_ratio", [with_encoders(seed) for seed in (0, 1)]) is None


def test_a_slip_ratio_is_held_where_no_encoder_shows_it():
    assert number_of("slip_ratio", [recording(seed, slip_ratio=0.3) for seed in (0, 1)]) is None


@pytest.mark.parametrize(("ratio", "is_found"), [(0.3, True), (0.0, False)])
def test_a_slip_ratio_that_a_late_command_hides_is_asked_beside_it(ratio, is_found):
    engine = engine_of(*(with_encoders(seed, slip_ratio=ratio, command_delay__delay=0.2) for seed in (0, 1)))
    selector = selector_on(fit_base(engine), engine, "command_delay", "motor_asymmetric_lag")
    _, _, ranking = ranked_if_bared(selector, *selector.first_ranked())
    assert ranking[0].name == "command_delay"
    found = [value for _, value, _ in found_free(ranking[0].fit, RATIO)]
    assert found == (pytest.approx([ratio], abs=0.1) if is_found else [])
