"""URDF and SDF: wheel radius, axle length, mass and inertia."""

import pytest

from fsm_calib.errors import InputError
from fsm_calib.recording.recording import RobotFacts
from fsm_calib.recording.robot_files import read_robot_file, with_facts

WHEEL = """<link name="wheel_{side}_link"><collision><geometry><cylinder radius="0.033" length="0.018"/></geometry>
</collision><inertial><mass value="0.03"/><inertia izz="1e-5"/></inertial></link>
<joint name="wheel_{side}_joint" type="continuous"><parent link="base_link"/><child link="wheel_{side}_link"/>
<origin xyz="0.0 {y} 0.023"/></joint>"""
URDF = (
    '<?xml version="1.0" encoding="utf-8"?><robot name="tb3"><link name="base_footprint"/><link name="base_link">'
    '<inertial><mass value="0.94"/><inertia izz="0.004"/></inertial></link><joint name="base" type="fixed">'
    '<parent link="base_footprint"/><child link="base_link"/><origin xyz="0 0 0.01"/></joint>'
    f"{WHEEL.format(side='left', y=0.08)}{WHEEL.format(side='right', y=-0.08)}</robot>"
)
SDF = """<sdf version="1.6"><model name="m"><link name="left_wheel"><pose>0 0.25 0 0 0 0</pose><inertial><mass>2</mass>
</inertial><collision><geometry><cylinder><radius>0.1</radius></cylinder></geometry></collision></link>
<link name="right_wheel"><pose>0 -0.25 0 0 0 0</pose></link>
<plugin><wheel_separation>0.52</wheel_separation><wheel_diameter>0.21</wheel_diameter></plugin></model></sdf>"""


def described(tmp_path, text):
    (tmp_path / "robot.urdf").write_text(text)
    return read_robot_file(tmp_path / "robot.urdf")


def test_a_urdf_tells_wheels_mass_and_inertia(tmp_path):
    facts = described(tmp_path, URDF)
    assert (facts.name, facts.wheel_radius, facts.axle_length) == ("tb3", 0.033, pytest.approx(0.16))
    assert facts.mass == pytest.approx(1.0)
    assert facts.inertia == pytest.approx(0.004 + 2e-5 + 0.06 * 0.08**2)


def test_the_plugin_of_an_sdf_wins_over_its_shapes(tmp_path):
    facts = described(tmp_path, SDF)
    assert (facts.wheel_radius, facts.axle_length, facts.mass) == (0.105, 0.52, 2.0)


def test_what_is_stated_wins_over_what_is_described():
    facts = with_facts(RobotFacts(axle_length=0.3), RobotFacts("tb3", 0.033, 0.16))
    assert (facts.name, facts.wheel_radius, facts.axle_length) == ("tb3", 0.033, 0.3)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ('<!DOCTYPE r [<!ENTITY a "b">]><robot name="&a;"/>', "declares types or entities"),
        ("<robot", "no XML"),
        ("<html/>", "neither a URDF"),
        ('<robot name="x"/>', "names no wheels and no mass"),
        (URDF.replace("0.033", "${radius}"), "Expand a xacro first"),
        (URDF.replace('"0.033"', '"-1"'), "cannot be read"),
        (URDF.replace("0.08 0.023", "1e300 0.023"), "'1e300', and no robot has 1e"),
        (SDF.replace("<pose>0 0.25", "<pose>1e300 0.25"), "'1e300', and no robot has 1e"),
        (SDF.replace("<mass>2", "<mass>-2"), "a mass of '-2'"),
        (SDF.replace("<mass>2", "<mass>nan"), "'nan', and no robot has 1e"),
    ],
)
def test_a_description_that_says_nothing_is_refused(tmp_path, text, sentence):
    with pytest.raises(InputError, match=sentence):
        described(tmp_path, text)
