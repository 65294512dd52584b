"""After an investigation: the calibration in the improved world, and the page with the fit and what came of it."""

from types import SimpleNamespace

from fsm_calib.diagnosis.design.area import Area
from fsm_calib.report.investigation import investigation_page
from fsm_calib.runner.investigation import afterwards
from fsm_calib.runner.investigation.afterwards import calibrated_afterwards
from fsm_calib.runner.progress import Silent
from fsm_calib.scenario.models import Scenario

WORLD = """
name: improved-bot
robot: {name: bot, source: nominal, wheel_ratio: 1.05, speed: 0.9, base: {axle_length: 0.101},
        effects: {motor_deadband: {offset: 0.03}}}
"""


def test_calibration_is_driven_with_what_was_found_and_without_it(tmp_path, monkeypatch):
    driven = {}

    def run_scenario(scenario, directory, **_):
        driven[directory.name] = scenario
        return SimpleNamespace(result={"outcome": "done", "wheels": {"wheel_ratio": 1.05}})

    monkeypatch.setattr(afterwards, "run_scenario", run_scenario)
    own = Scenario.model_validate(
        {"name": "wheels", "robot": {"known": {"camera": True}, "wheel_ratio": 1.2}, "plan": ["wheels"]}
    )
    told = calibrated_afterwards(own, WORLD, tmp_path, Silent())
    improved, without = driven["improved"].robot, driven["without"].robot
    assert improved.effects.motor_deadband.offset == 0.03
    assert without.effects.motor_deadband is None
    assert improved.wheel_ratio == without.wheel_ratio == 1.05
    assert improved.known.camera
    assert told["improved"]["wheel_ratio"] == 1.05


def test_page_shows_the_fit_before_and_after_and_the_calibration():
    error = {"xy_m": 0.0021, "theta_rad": 0.02}
    row = {"outcome": "done", "wheel_ratio": 1.0512, "true_wheel_ratio": None, "deviation_2m_m": 0.013}
    result = {
        "verdict": "explained",
        "effects": [{"name": "motor_deadband"}],
        "drives": [],
        "ended": "done",
        "robot": {"seconds": 43.0},
        "fit": {"holdout": None, "train": {"before": error, "after": error, "floor": error}},
        "calibration": {"improved": row},
    }
    page = investigation_page([], Area(), result)
    assert "base robot alone" in page
    assert "1.0512" in page
    assert "1.3" in page
