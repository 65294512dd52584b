"""Pages of cameras, studies, fleets and next drives in a real browser: nothing sideways, cut, faint or in error."""

import numpy as np
from browser import faults, needs_browser
from camera_views import BOARD, SIZE, hand_held
from test_next_drive import PLAN
from test_study_report import row, summary

from fsm_calib.diagnosis.design.area import Area
from fsm_calib.perception.fleet_camera import FLEET_MEDIAN
from fsm_calib.perception.intrinsics import calibrate
from fsm_calib.perception.lens import camera_model
from fsm_calib.perception.prediction import projection_difference
from fsm_calib.report.camera_compare import compare_page
from fsm_calib.report.camera_report import camera_report
from fsm_calib.report.fleet import cells, fleet_page
from fsm_calib.report.next_drive import next_drive_page
from fsm_calib.report.study_files import write_study

FLEET = (
    {
        "robot": "a robot with a long name",
        "straight": {"side": "left", "sideways_m": 0.175, "sd_m": 0.022},
        "trim": {"gain": 1.35, "trim": -0.024},
        "identify": {"wheel_ratio": {"value": 0.966, "sd": 0.003}},
        "diagnosis": {"verdict": "explained", "effects": [{"name": "motor_deadband", "confidence": 0.9}]},
        "recordings": ["a.bag", "b.bag"],
    },
    {"robot": "broken", "recordings": ["c.bag"], "error": {"reason": "c.bag: not a bag."}},
)


def camera_page() -> str:
    views = hand_held(12, 0.1)
    photo = np.full((SIZE[1], SIZE[0]), 120, dtype=np.uint8)
    result = calibrate(views, BOARD, SIZE)
    return camera_report(result, views, BOARD, ("a photo", photo), lambda _: photo)


def study_page(folder) -> str:
    extra = [row(robot, "published:equation_3", scale=9.0) for robot in range(4)]
    write_study(folder, summary(extra=extra, corrections=["equation_3"]))
    return (folder / "report.html").read_text(encoding="utf-8")


def compared_page() -> str:
    near, far = FLEET_MEDIAN, FLEET_MEDIAN + np.array([9.0, 9.0, 2.0, -3.0, 0.02, *np.zeros(7)])
    cameras = (camera_model(near, SIZE), camera_model(far, SIZE))
    names = ("cameras/of_a_robot_with_a_long_name/camera.yaml", "b.yaml")
    return compare_page(names, cameras, projection_difference(*cameras))


@needs_browser
def test_pages_are_sound_in_a_browser(tmp_path) -> None:
    pages = {
        "camera": camera_page(),
        "compared": compared_page(),
        "study": study_page(tmp_path),
        "fleet": fleet_page([cells(robot) for robot in FLEET]),
        "next": next_drive_page(PLAN, Area(), "duckie"),
    }
    assert faults(pages, tmp_path) == []
