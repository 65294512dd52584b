"""What every effect of the catalogue must keep, whichever it is: the battery runs over the registry."""

import re

import numpy as np
import pymunk
import pytest

from fsm_calib.errors import InputError, UnknownNameError
from fsm_calib.types import Pose2, WheelCommand
from fsm_calib.world2d.body import RobotBody
from fsm_calib.world2d.effects import effect, registry
from fsm_calib.world2d.effects.catalogue import table
from fsm_calib.world2d.observation import base_pose, observe, predict, robot_time
from fsm_calib.world2d.parameters import null_parameters, parameter_table, parameters, typical_parameters
from fsm_calib.world2d.rollout import Drive, active_flags, simulate

CATALOGUE = [
    "motor_deadband",
    "command_saturation",
    "motor_gain_curve",
    "motor_reverse_asymmetry",
    "motor_asymmetric_lag",
    "coulomb_friction",
    "gear_backlash",
    "battery_sag",
    "motor_warmup",
    "motor_fault",
    "command_delay",
    "wheel_eccentricity",
    "caster_drag",
    "tyre_scrub",
    "lateral_slip",
    "payload_offset",
    "floor_tilt",
    "carpet_nap",
    "rough_floor_patch",
    "low_friction_patch",
    "external_push",
    "observation_delay",
    "sensor_offset",
    "sensor_yaw",
    "clock_drift",
    "misplaced_marker",
    "unequal_motors",
    "wheel_slip",
]
NAMES = sorted(registry())
PHYSICAL = [n for n in NAMES if set(registry()[n].hooks) & {"begin", "shape", "delay", "step"}]
DISSIPATIVE = [n for n in NAMES if registry()[n].dissipative]
SAMPLES = np.arange(0.0, 14.0, 0.05)
START = (0.0, 0.0, 0.3)


def manoeuvre() -> Drive:
    """Straights at several speeds both ways, spins, arcs and rests, around (0.1, 0.1)."""
    levels = [
        (0.1, 0.1),
        (0.3, 0.3),
        (0, 0),
        (-0.3, -0.3),
        (0.6, 0.55),
        (-0.2, 0.2),
        (0, 0),
        (0.35, -0.35),
        (0.5, 0.2),
        (0, 0),
        (-0.5, -0.45),
        (0.2, 0.5),
        (0.7, 0.7),
        (0, 0.3),
        (0, 0),
        (-0.6, -0.6),
        (0.4, 0.1),
        (0, 0),
    ]
    return Drive(np.arange(len(levels)) * 0.7 + 0.3, [a for a, _ in levels], [b for _, b in levels])


def poses_of(vector, start=START, drive=None, samples=SAMPLES):
    return predict(vector, drive or manoeuvre(), samples, start).poses


def mirror(poses):
    return poses * np.array([1.0, -1.0, -1.0])


def energy(states, vector):
    """Kinetic energy [J] of body and wheels, without the payload's offset."""
    at = parameter_table().index
    mass, axle = vector[at["mass"]], vector[at["axle_length"]]
    rotating = vector[at["wheel_inertia"]] / vector[at["wheel_radius_left"]] ** 2
    turning = (0.5 * mass + rotating) * vector[at["tau_turn"]] / vector[at["tau_forward"]] * 0.5 * axle**2
    inertia = turning - 0.5 * rotating * axle**2
    body = mass * (states[:, 3] ** 2 + states[:, 4] ** 2) + inertia * states[:, 5] ** 2
    return 0.5 * (body + rotating * (states[:, 8] ** 2 + states[:, 9] ** 2))


def test_the_catalogue_holds_every_name_of_the_contract():
    assert set(CATALOGUE) <= set(NAMES)


def test_an_unknown_effect_is_answered_with_the_nearest_name():
    with pytest.raises(UnknownNameError, match="floor_tilt"):
        effect("floor_tlit")


def test_the_table_has_a_row_for_each_effect_with_its_parameters():
    rows = {row["name"]: row for row in table()}
    assert sorted(rows) == NAMES
    assert all(row["parameters"] and row["equation"] and row["manoeuvre"] for row in rows.values())


@pytest.mark.parametrize("name", NAMES)
def test_null_value_changes_nothing(name):
    """Where, when and how mean nothing while the strength is null: not a bit of the motion changes."""
    vector = null_parameters()
    for place in parameter_table().of_effect(name):
        entry = parameter_table().entries[place]
        if not entry.strength:
            vector[place] = entry.typical
    assert not active_flags(vector).any()
    np.testing.assert_array_equal(poses_of(vector), poses_of(null_parameters()))


@pytest.mark.parametrize("name", NAMES)
def test_vanishing_strength_changes_vanishingly_little(name):
    """The null value is the limit of small ones: no step on switching on."""
    vector, null = null_parameters(), null_parameters()
    for place in parameter_table().of_effect(name):
        entry = parameter_table().entries[place]
        vector[place] = (
            entry.typical if not entry.strength else entry.null + 1e-7 * (entry.typical - entry.null)
        )
    change = np.abs(poses_of(vector) - poses_of(null)).max()
    assert change < 1e-5


@pytest.mark.parametrize("name", NAMES)
def test_typical_size_changes_the_measured_motion(name):
    vector = typical_parameters(effect(name))
    change = np.abs(poses_of(vector) - poses_of(null_parameters())).max()
    assert change > (1e-3 if name != "wheel_slip" else 1e-4)


@pytest.mark.parametrize("name", NAMES)
def test_mirrored_robot_moves_as_the_mirror_image(name):
    table_ = parameter_table()
    vector = typical_parameters(effect(name))
    vector[table_.place("gain_left")] = 0.70
    drive = manoeuvre()
    image = poses_of(
        table_.mirrored(vector), mirror(np.array(START)), Drive(drive.time, drive.right, drive.left)
    )
    np.testing.assert_allclose(image, mirror(poses_of(vector)), atol=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_mirroring_twice_gives_the_robot_back(name):
    vector = typical_parameters(effect(name))
    np.testing.assert_array_equal(parameter_table().mirrored(parameter_table().mirrored(vector)), vector)


@pytest.mark.parametrize("name", DISSIPATIVE)
def test_friction_never_adds_energy(name):
    """Thrown with its motors off, the robot only loses energy."""
    vector = typical_parameters(effect(name))
    start = (0.1, 0.1, 0.2, 0.4, 0.05, 3.0)
    states = simulate(vector, Drive([0.0], [0.0], [0.0]), np.arange(0.0, 2.0, 0.005), start)
    assert np.diff(energy(states, vector)).max() < 1e-9


@pytest.mark.parametrize("name", PHYSICAL)
def test_pymunk_and_rollout_agree(name):
    vector = typical_parameters(effect(name))
    drive, step, count = manoeuvre(), 0.002, 5000
    body = RobotBody(pymunk.Space(), vector, Pose2(*START))
    seen = []
    for i in range(count):
        row = int(np.searchsorted(drive.time, i * step + 1e-9, side="right")) - 1
        command = WheelCommand(drive.left[row], drive.right[row]) if row >= 0 else WheelCommand()
        body.step(command, step)
        if i % 50 == 49:
            seen.append((body.pose.x, body.pose.y, body.pose.theta, *body.wheel_angles))
    states = simulate(vector, drive, np.arange(0, count + 1, 50) * step, START, dt=step)
    np.testing.assert_allclose(seen, states[1:, [0, 1, 2, 6, 7]], atol=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_longer_steps_change_little(name):
    """The fit's step is right to well below a pose's noise, over half-second increments."""
    vector = typical_parameters(effect(name))
    path = predict(vector, manoeuvre(), SAMPLES, START, dt=0.0005).states[:, :3]
    track = np.column_stack([SAMPLES, path])
    coarse = predict(vector, manoeuvre(), SAMPLES, START, track).poses
    fine = predict(vector, manoeuvre(), SAMPLES, START, track, dt=0.0005).poses
    increments = (coarse[10:] - coarse[:-10]) - (fine[10:] - fine[:-10])
    assert np.all(np.sqrt(np.mean(increments**2, axis=0)) < [1.5e-3, 1.5e-3, 5e-3])


@pytest.mark.parametrize("name", NAMES)
def test_docstring_has_equation_units_and_source(name):
    module = __import__(f"fsm_calib.world2d.effects.{name}", fromlist=["EFFECT"])
    text = module.__doc__
    assert re.search(r"^    .*[=:].*", text, re.MULTILINE), "an indented equation"
    assert re.search(r"\[[\w/ ]+\]", text), "units in brackets"
    assert re.search(r"Sources?:", text), "a source"


@pytest.mark.parametrize("name", NAMES)
def test_declaration_is_complete_and_consistent(name):
    declared = effect(name)
    names = {p.name for p in declared.parameters}
    assert declared.name == name
    assert set(declared.rivals) <= set(NAMES) - {name}
    assert set(re.findall(r"{(\w+)}", declared.sentence)) <= names
    assert all(set(v) <= names for v in declared.variants)
    assert declared.strengths
    for p in declared.parameters:
        assert p.low <= p.null <= p.high
        assert p.low <= p.typical <= p.high
        assert all(p.low <= s <= p.high for s in p.starts)


def test_robot_time_and_observation_of_the_nominal_robot_are_the_identity():
    poses = poses_of(null_parameters())
    np.testing.assert_array_equal(robot_time(null_parameters(), SAMPLES), SAMPLES)
    np.testing.assert_array_equal(observe(null_parameters(), SAMPLES, poses), poses)


def test_base_pose_undoes_the_sensors_place():
    vector = parameters({"sensor_offset.x": 0.04, "sensor_offset.y": -0.02, "sensor_yaw.yaw": 0.3})
    measured = observe(vector, np.zeros(1), np.array([[0.5, -0.2, 1.1]]))[0]
    back = base_pose(vector, Pose2(*measured))
    np.testing.assert_allclose([back.x, back.y, back.theta], [0.5, -0.2, 1.1], atol=1e-12)


def test_a_value_outside_its_bounds_is_refused_with_its_name_and_unit():
    with pytest.raises(InputError, match=r"floor_tilt.slope_x is 3 rad"):
        parameters({"floor_tilt.slope_x": 3.0})


def test_a_misspelt_parameter_is_answered_with_the_nearest():
    with pytest.raises(UnknownNameError, match=r"battery_sag.per_charge"):
        parameters({"battery_sag.per_charg": 0.01})
