"""Bounds, priors and typical sizes follow the robot at hand; those of small robots stay as they are declared."""

import dataclasses

import pytest
from diagnosis_robots import recording

from fsm_calib.diagnosis.candidates.hypotheses import Hypothesis, slots_of
from fsm_calib.diagnosis.fitting.base import TYPICAL_LAG, base_slots, turning_share
from fsm_calib.diagnosis.replay.prepared import prepare
from fsm_calib.diagnosis.replay.simulator import make_simulator, nominal_values, scale_of
from fsm_calib.errors import FsmCalibError
from fsm_calib.recording.recording import RobotFacts
from fsm_calib.scenario.load import load_scenario
from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.parameters import parameter_table, parameters
from fsm_calib.world2d.scale import SMALL, Scale

HALF_TONNE = RobotFacts(wheel_radius=0.3, axle_length=1.2, max_wheel_rate=10.0, mass=500.0, inertia=90.0)
DUCKIEBOT = RobotFacts(wheel_radius=0.0318, axle_length=0.1, max_wheel_rate=20.0)


@pytest.fixture(scope="module")
def drive():
    return recording(0, 10.0)


def simulator_of(drive, facts):
    return make_simulator(prepare(dataclasses.replace(drive, robot=facts)))


def declared(name):
    table = parameter_table()
    return table.entries[table.place(name)]


def test_small_robots_keep_every_declared_bound():
    scale = Scale.of(axle_length=0.26, full_speed=0.95)
    assert scale == SMALL
    assert all(scale.bounds(p) == (p.low, p.high) for p in parameter_table().entries)


@pytest.mark.parametrize(("facts", "arm"), [(DUCKIEBOT, 0.075), (HALF_TONNE, 0.66)])
def test_a_caster_is_taken_to_sit_as_far_behind_as_the_robot_is_wide(drive, facts, arm):
    values = nominal_values([simulator_of(drive, facts)])
    assert values[parameter_table().place("caster_drag.arm")] == pytest.approx(arm)


def test_a_caster_that_the_world_states_sits_where_it_says(drive):
    simulator = make_simulator(
        prepare(dataclasses.replace(drive, robot=HALF_TONNE)), {"caster_drag.arm": 0.1}
    )
    assert nominal_values([simulator])[parameter_table().place("caster_drag.arm")] == 0.1


@pytest.mark.parametrize(
    ("name", "factor"),
    [
        ("payload_offset.x", 4.0), ("tyre_scrub.moment", 4.0), ("external_push.impulse_x", 3.0),
        ("external_push.impulse_turn", 12.0), ("wheel_slip.slip_speed", 3.0), ("caster_drag.drag", 1.0),
        ("command_delay.delay", 1.0), ("floor_tilt.slope_x", 1.0), ("lateral_slip.compliance", 1.0),
    ],
)  # fmt: skip
def test_bounds_grow_by_dimension(name, factor):
    entry = declared(name)
    low, high = Scale(length=4.0, speed=3.0).bounds(entry)
    assert high == pytest.approx(factor * entry.high)
    assert low == pytest.approx(factor * entry.low if entry.low < 0.0 else entry.low)


def test_a_large_robots_load_may_lie_as_far_off_as_its_axle_lets(drive):
    form = Hypothesis("payload_offset", ("x", "y"))
    scale = scale_of(simulator_of(drive, HALF_TONNE))
    assert slots_of(form, 1, scale)[0].high == pytest.approx(4.0 * declared("payload_offset.x").high)
    assert slots_of(form, 1, scale_of(simulator_of(drive, DUCKIEBOT))) == slots_of(form, 1)


def test_tyres_of_a_fast_robot_may_slip_faster(drive):
    slow, fast = (
        next(s for s in base_slots([sim], nominal_values([sim])) if s.place == parameter_table().place("slip_speed"))
        for sim in (simulator_of(drive, DUCKIEBOT), simulator_of(drive, HALF_TONNE))
    )  # fmt: skip
    assert (fast.centre, fast.spread) == pytest.approx((3.0 * slow.centre, 3.0 * slow.spread))


def test_large_wheels_hold_the_same_share_of_the_mass_at_their_rims(drive):
    place, radius = parameter_table().place("wheel_inertia"), 0.05
    at_rim = [
        nominal_values([simulator_of(drive, dataclasses.replace(HALF_TONNE, wheel_radius=r))])[place] / r**2
        for r in (radius, 0.3)
    ]
    assert at_rim[0] == pytest.approx(at_rim[1])


def test_wheels_smaller_than_a_duckiebots_hold_its_share_of_the_mass_at_their_rims(drive):
    place = parameter_table().place("wheel_inertia")
    small = nominal_values([simulator_of(drive, dataclasses.replace(DUCKIEBOT, wheel_radius=0.02))])
    assert small[place] / 0.02**2 == pytest.approx(declared("wheel_inertia").null / 0.0318**2)


def test_a_stated_inertia_says_how_much_longer_turning_lasts(drive):
    simulator = simulator_of(drive, HALF_TONNE)
    values = nominal_values([simulator])
    body = 4.0 * 90.0 / (500.0 * 1.2**2)
    rotating = float(values[parameter_table().place("wheel_inertia")]) / 0.3**2 / declared("mass").null
    expected = (body + 2.0 * rotating) / (1.0 + 2.0 * rotating)
    assert turning_share(HALF_TONNE, values) == pytest.approx(expected)
    turn = next(s for s in base_slots([simulator], values) if s.place == parameter_table().place("tau_turn"))
    assert turn.centre == pytest.approx(TYPICAL_LAG * expected)
    assert turning_share(dataclasses.replace(HALF_TONNE, inertia=None), values) == 1.0


def test_a_world_takes_a_far_load_on_a_large_robot_only():
    far = {"payload_offset.x": 0.2}
    assert parameters({"axle_length": 1.0, **far}) is not None
    with pytest.raises(FsmCalibError, match=r"payload_offset\.x is 0\.2 m"):
        parameters(far)


def test_a_scenario_takes_a_far_load_on_a_large_robot_only(tmp_path):
    text = "name: far\nrobot: {base: {axle_length: AXLE, mass: 500}, effects: {payload_offset: {x: 0.2}}}\n"
    path = tmp_path / "scenario.yaml"
    path.write_text(text.replace("AXLE", "1.2"))
    assert load_scenario(path).robot.effects.payload_offset.x == 0.2
    path.write_text(text.replace("AXLE", "0.1"))
    with pytest.raises(FsmCalibError, match=r"scenario\.yaml:2:.*payload_offset\.x is 0\.2 m"):
        load_scenario(path)


def test_every_typical_size_is_within_the_bounds_of_small_robots():
    for effect in registry().values():
        for p in effect.parameters:
            low, high = SMALL.bounds(p)
            assert low <= p.typical <= high or p.typical == p.null
