"""What a diagnosis writes for other programs: the same robot in Python, for ros2, for Gazebo and for MuJoCo."""

import ast
import runpy
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
import yaml
from diagnosis_robots import GAIN_LEFT, GAIN_RIGHT, recording, robot
from typer.testing import CliRunner

from fsm_calib.cli import app
from fsm_calib.diagnosis.diagnose import diagnose
from fsm_calib.recording.writers import write_recording
from fsm_calib.report.export import controller_text, exported, gazebo_text, mujoco_text, readme_text
from fsm_calib.report.export_corrections import COMMAND_MAP, corrections_text
from fsm_calib.report.export_values import ExportValues, export_values
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table
from fsm_calib.world2d.rollout import Drive, simulate

FULL = 0.0318 * 20.0
CASES = [
    {"motor_deadband__offset": 0.08},
    {"motor_deadband__offset": -0.06},
    {"motor_deadband__offset_left": 0.1},
    {"motor_gain_curve__curvature_right": 0.4},
    {"motor_gain_curve__curvature": -0.2},
    {"motor_gain_curve__power": 0.3},
    {"command_saturation__limit": 0.3},
    {"command_saturation__limit": 0.3, "command_saturation__soft": 1.0},
    {"motor_reverse_asymmetry__loss": 0.1, "motor_reverse_asymmetry__difference": 0.06},
    {"pwm_steps__share": 1.0},
    {"pwm_steps__share": 0.9, "pwm_steps__levels": 19.0, "pwm_steps__nearest": 1.0},
    {
        "motor_deadband__offset_right": 0.05,
        "command_saturation__limit": 0.4,
        "motor_gain_curve__curvature": 0.3,
    },
]


def values_of(axle=0.1, **changes):
    """Return the export's numbers of a `robot` with `changes`."""
    table, vector = parameter_table(), robot(**changes)
    effects = {
        name: {p.name: float(vector[table.place(f"{name}.{p.name}")]) for p in registry()[name].parameters}
        for name in table.active_effects(vector)
    }
    gains = (GAIN_LEFT, GAIN_RIGHT)
    rolling = tuple(0.0318 * gain / FULL for gain in gains)
    return ExportValues("r", 0.0318, 0.1, FULL, gains, rolling, axle, 1.1, effects, tuple(effects), (), False)


def module_of(values, tmp_path):
    path = tmp_path / "corrections.py"
    path.write_text(corrections_text(values), encoding="utf-8")
    return runpy.run_path(str(path))


def steady_twist(vector, left, right):
    """Return forward speed and yaw rate that the world's own robot settles at."""
    states = simulate(vector, Drive([0.0], [left], [right]), np.array([0.0, 4.0]), (0.0, 0.0, 0.0))
    return states[-1, 3], states[-1, 5]


@pytest.mark.parametrize("changes", CASES, ids=str)
def test_the_python_function_gives_the_speeds_of_the_worlds_robot(changes, tmp_path):
    module = module_of(values_of(**changes), tmp_path)
    for left, right in ((0.35, 0.35), (-0.2, -0.2), (0.45, 0.2), (-0.15, 0.25), (0.0, 0.0)):
        expected = steady_twist(robot(axle_length=0.1, **changes), left, right)
        assert module["twist"](left, right) == pytest.approx(expected, rel=0.02, abs=2e-3)


def test_a_plain_robot_told_the_corrected_commands_drives_as_the_recorded_one(tmp_path):
    changes = {"motor_deadband__offset": 0.08}
    module = module_of(values_of(**changes), tmp_path)
    plain = robot(gain_left=FULL, gain_right=FULL, axle_length=0.1)
    for left, right in ((0.35, 0.35), (-0.2, 0.3)):
        recorded = steady_twist(robot(axle_length=0.1, **changes), left, right)
        assert steady_twist(plain, *module["corrected"](left, right)) == pytest.approx(
            recorded, rel=0.02, abs=2e-3
        )


def test_the_python_module_needs_nothing_but_python():
    every = values_of(**{k: v for case in CASES for k, v in case.items()})
    tree = ast.parse(corrections_text(every))
    imported = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    imported |= {a.name for node in ast.walk(tree) if isinstance(node, ast.Import) for a in node.names}
    assert imported == {"__future__", "math"}


def test_every_effect_that_shapes_commands_is_exported_in_the_order_in_which_it_acts():
    shaping = sorted((e for e in registry().values() if "shape" in e.hooks), key=lambda e: e.order)
    assert list(COMMAND_MAP) == [e.name for e in shaping]


def test_the_controllers_multipliers_are_fitted_over_stated_sizes():
    told = yaml.safe_load(controller_text(values_of(axle=0.104)))["diff_drive_controller"]["ros__parameters"]
    assert told["wheel_separation_multiplier"] == pytest.approx(1.04)
    assert told["left_wheel_radius_multiplier"] == pytest.approx(GAIN_LEFT / FULL, rel=1e-5)
    assert told["right_wheel_radius_multiplier"] == pytest.approx(GAIN_RIGHT / FULL, rel=1e-5)


def test_the_gazebo_plugin_answers_a_twist_as_the_robot_does(tmp_path):
    values = replace(values_of(axle=0.104), gains=(0.6, 0.6))
    plugin = ET.fromstring(gazebo_text(values)).find("model/plugin")
    separation, radius = (float(plugin.findtext(f"wheel_{name}")) for name in ("separation", "radius"))
    v, omega = 0.2, 1.1
    left, right = ((v + sign * 0.5 * omega * separation) / radius * values.radius for sign in (-1, 1))
    simulated = 0.5 * (left + right), (right - left) / values.axle
    assert simulated == pytest.approx(module_of(values, tmp_path)["corrected_twist"](v, omega), rel=1e-4)


def test_mujocos_fields_hold_friction_mass_and_slope():
    values = values_of(
        coulomb_friction__friction=0.01,
        coulomb_friction__difference=0.004,
        payload_offset__x=-0.015,
        floor_tilt__slope_x=0.02,
    )
    model = ET.fromstring(mujoco_text(values))
    losses = {j.get("name"): float(j.get("frictionloss")) for j in model.iter("joint")}
    assert losses == pytest.approx({"left_wheel": 0.012, "right_wheel": 0.008})
    assert model.find(".//inertial").get("pos").split()[0] == "-0.015"
    pull = [float(x) for x in model.find("option").get("gravity").split()]
    assert pull[0] == pytest.approx(-9.80665 * 0.02, rel=1e-4)
    assert np.linalg.norm(pull) == pytest.approx(9.80665, rel=1e-5)
    assert ET.fromstring(gazebo_text(values)).findtext("world/gravity")


def test_the_readme_says_which_effect_has_no_place():
    text = readme_text(values_of(motor_deadband__offset=0.08, observation_delay__delay=0.1), "explained: ...")
    rows = {line.split("|")[1].strip(): line for line in text.splitlines() if line.startswith("| ")}
    assert "`corrections.py`" in rows["motor_deadband"]
    assert "no place here" in rows["observation_delay"]


def test_the_command_writes_the_files_of_what_it_found(tmp_path):
    drives = [recording(seed, 30.0, motor_deadband__offset=0.08) for seed in (1, 2)]
    files = [str(write_recording(one, tmp_path / str(i))) for i, one in enumerate(drives)]
    hidden = [t for name in registry() if name != "motor_deadband" for t in ("--without", name)]
    answer = CliRunner().invoke(app, ["diagnose", *files, "--export", str(tmp_path / "out"), *hidden])
    assert answer.exit_code == 0, answer.output
    found = diagnose(drives, without=[name for name in registry() if name != "motor_deadband"])
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == sorted(exported(found))
    module = runpy.run_path(str(tmp_path / "out" / "corrections.py"))
    assert module["rim_speeds"](0.3, 0.3) == pytest.approx((GAIN_LEFT * 0.22, GAIN_RIGHT * 0.22), rel=0.02)
    assert export_values(found).named == ("motor_deadband",)


def test_a_file_in_the_folders_place_is_refused_before_any_work(tmp_path):
    (tmp_path / "out").write_text("mine")
    answer = CliRunner().invoke(app, ["diagnose", "nowhere.yaml", "--export", str(tmp_path / "out")])
    assert answer.exit_code == 2
    assert "needs a folder" in answer.output
