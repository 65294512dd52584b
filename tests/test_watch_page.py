"""The page of a run that is watched, and that of an investigation, as a browser shows them."""

import re

import numpy as np
from browser import faults, needs_browser, page_after_scripts
from test_watch import ask, folder, server  # noqa: F401  (fixtures)

from fsm_calib.actions.investigating import Field
from fsm_calib.diagnosis.design.area import Area
from fsm_calib.report.investigation import investigation_page

STYLE = re.compile(r"<link[^>]*stylesheet[^>]*>")
SCRIPT = re.compile(r"<script.*?</script>", re.DOTALL)
ERROR = {"xy_m": 0.0021, "theta_rad": 0.02}


@needs_browser
def test_the_page_of_a_watched_run_is_sound(server, tmp_path) -> None:  # noqa: F811
    shown = SCRIPT.sub("", page_after_scripts(f"{server.address}?at=5", tmp_path))
    style = ask(server, "GET", "/page.css")[1].decode("utf-8")
    shown = STYLE.sub(lambda _: f"<style>{style}</style>", shown)
    assert "Sentence 5." in shown
    assert faults({"watch": shown}, tmp_path) == []


def investigation() -> str:
    """Return a page with one drive of long names, a fit and a calibration."""
    time = np.arange(0.0, 20.0, 0.1)
    poses = [(t, 0.5 * np.cos(t / 3), 0.5 * np.sin(t / 3), t / 3 + np.pi / 2) for t in time.tolist()]
    steps = [{"name": f"a slalom of {n} curves at three quarters of the speed"} for n in range(6)]
    drive = Field(commands=[(0.0, 0.3, 0.3)], poses=poses, plan={"manoeuvres": steps})
    row = {
        "why": "tells_tyre_scrub_from_caster_drag",
        "expected": 0.9,
        "reached": 0.96,
        "seconds": 20.0,
        "cut": True,
    }
    row["beliefs"] = [("motor_reverse_asymmetry", 0.96), ("low_friction_patch", 0.03)]
    ended = {"outcome": "done", "wheel_ratio": 1.0512, "true_wheel_ratio": 1.05, "deviation_2m_m": 0.013}
    result = {
        "verdict": "explained", "effects": [{"name": "motor_reverse_asymmetry"}, {"name": "low_friction_patch"}],
        "drives": [row], "ended": "sure_enough", "robot": {"seconds": 43.0},
        "fit": {"holdout": None, "train": {"before": ERROR, "after": ERROR, "floor": ERROR}},
        "calibration": {"improved": ended, "without": ended},
    }  # fmt: skip
    return investigation_page([drive], Area(), result)


@needs_browser
def test_the_page_of_an_investigation_is_sound(tmp_path) -> None:
    assert faults({"investigation": investigation()}, tmp_path) == []
