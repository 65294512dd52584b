"""What looks odd in a recording, each with where it begins, how often it is, and how long: no more and no less."""

from __future__ import annotations

import numpy as np
import pytest

from fsm_calib.recording import CommandTrack, PoseTrack, Recording, RobotFacts, TwistTrack, WheelPair
from fsm_calib.recording.oddities import findings_of
from fsm_calib.recording.recording import Finding

TIME = np.arange(0.0, 20.0, 0.1)


def circle(**changes: np.ndarray) -> PoseTrack:
    """A drive of 20 s around a circle of 1 m at 1/3 m/s."""
    columns = {
        "time": TIME,
        "x": np.sin(TIME / 3.0),
        "y": 1.0 - np.cos(TIME / 3.0),
        "theta": TIME / 3.0,
    }
    return PoseTrack(**(columns | changes))


def shifted(field: str, rows: slice | list[int], by: float) -> PoseTrack:
    """The circle with some values of a column moved."""
    values = getattr(circle(), field).copy()
    values[rows] += by
    return circle(**{field: values})


def still(first: int, last: int) -> PoseTrack:
    """The circle, standing still from one row to another."""
    x, y = circle().x.copy(), circle().y.copy()
    x[first:last], y[first:last] = x[first], y[first]
    return circle(x=x, y=y)


def command(level: float, until: float = 20.0, steps: int = 41) -> CommandTrack:
    return CommandTrack(np.linspace(0.0, until, steps), np.full(steps, level), np.full(steps, level))


def found(**channels: object) -> list[Finding]:
    return findings_of(Recording(**channels))


def the_one(kind: str, **channels: object) -> Finding:
    (one,) = [finding for finding in found(**channels) if finding.kind == kind]
    return one


def test_a_plain_drive_has_nothing_odd() -> None:
    assert found(pose=circle(), command=command(0.3)) == []


def test_two_poses_are_too_few_to_judge() -> None:
    assert found(pose=shifted("x", [1], 100.0).rows(slice(0, 2))) == []


def test_a_jump_there_and_back_is_two_steps_from_its_first_time() -> None:
    one = the_one("jump", pose=shifted("x", [100], 2.0))
    assert (one.rows, one.time) == (2, pytest.approx(10.0))


def test_a_turn_that_no_robot_makes_is_a_jump_too() -> None:
    one = the_one("jump", pose=shifted("theta", [50], 2.0))
    assert (one.rows, one.time) == (2, pytest.approx(5.0))


def test_a_small_wrong_heading_is_noise_and_no_jump() -> None:
    close = np.arange(0.0, 2.0, 0.01)
    pose = PoseTrack(close, 0.3 * close, 0.0 * close, 0.0 * close)
    theta = pose.theta.copy()
    theta[50] = 0.25
    assert found(pose=PoseTrack(close, pose.x, pose.y, theta)) == []


def test_a_fast_stamp_between_two_slow_ones_is_no_jump() -> None:
    time = TIME.copy()
    time[100] = time[101] - 1e-3
    assert found(pose=circle(time=time)) == []


def test_poses_without_headings_are_judged_by_their_places() -> None:
    none = np.full(len(TIME), np.nan)
    assert found(pose=circle(theta=none)) == []
    one = the_one("jump", pose=PoseTrack(TIME, shifted("x", [100], 2.0).x, circle().y, none))
    assert one.rows == 2


@pytest.mark.parametrize(
    ("count", "kind"), [(4, "jump"), (6, "unit_slip"), (49, "unit_slip"), (51, "impossible")]
)
def test_many_jumps_are_a_wrong_unit_and_most_a_wrong_column(count: int, kind: str) -> None:
    rows = [2 * row + 1 for row in range(count)]
    one = the_one(kind, pose=shifted("x", rows, 5.0))
    assert one.rows == 2 * count


@pytest.mark.parametrize(
    ("channels", "is_jump"),
    [
        ({}, True),
        ({"wheel_speed": WheelPair(TIME, np.full(200, 4.0), np.full(200, -1.0), "m/s")}, False),
        ({"wheel_speed": WheelPair(TIME, np.full(200, 1.0), np.full(200, -4.0), "m/s")}, False),
        ({"wheel_speed": WheelPair(TIME, np.full(200, 2.0), np.full(200, 2.0), "m/s")}, True),
        ({"wheel_rate": WheelPair(TIME, np.full(200, 40.0), np.full(200, 1.0), "rad/s")}, False),
        ({"twist": TwistTrack(TIME, np.full(200, -4.0), np.zeros(200))}, False),
    ],
)
def test_what_wheels_and_commands_say_bounds_what_is_a_jump(
    channels: dict[str, object], is_jump: bool
) -> None:
    """A step of 0.6 m in 0.1 s is 6 m/s."""
    places = circle().x.copy()
    places[100:] += 0.6
    recording = Recording(pose=circle(x=places), robot=RobotFacts(wheel_radius=0.1), **channels)
    assert ("jump" in {finding.kind for finding in findings_of(recording)}) is is_jump


def test_nothing_on_wheels_is_as_fast_as_its_encoders_may_claim() -> None:
    claimed = WheelPair(TIME, np.full(200, 400.0), np.full(200, 400.0), "m/s")
    assert the_one("jump", pose=shifted("x", [100], 2.5), wheel_speed=claimed).rows == 2


def test_gaps_are_counted_and_the_longest_is_told() -> None:
    keep = np.ones(200, dtype=bool)
    keep[50:80], keep[120:130] = False, False
    one = the_one("gap", pose=circle().rows(keep))
    assert (one.rows, one.time) == (2, pytest.approx(4.9))
    assert "the longest 3.10 s" in one.sentence


def test_a_heading_against_the_path_is_mirrored() -> None:
    assert the_one("mirrored", pose=circle(theta=-TIME / 3.0)).rows > 100


def test_a_mirrored_path_is_seen_though_it_is_mostly_straight() -> None:
    theta = 0.9 * np.clip(np.sin(TIME / 2.0), 0.3, 1.0)
    x, y = (np.cumsum(0.4 * np.diff(TIME, prepend=0.0) * side(theta)) for side in (np.cos, np.sin))
    assert found(pose=PoseTrack(TIME, x, y, theta)) == []
    assert the_one("mirrored", pose=PoseTrack(TIME, x, -y, theta)).rows > 100


def test_a_heading_that_ignores_the_path_is_told() -> None:
    theta = np.cumsum(np.tile([0.02, -0.02, 0.021, -0.02], 50))
    one = the_one("heading", pose=circle(theta=theta))
    assert one.rows > 100


@pytest.mark.parametrize("offset", [np.pi, 0.5])
def test_a_robot_that_drives_backwards_or_a_little_askew_looks_where_it_drives(offset: float) -> None:
    assert found(pose=circle(theta=TIME / 3.0 + offset)) == []


def test_a_robot_that_pivots_slowly_is_not_said_to_look_elsewhere() -> None:
    rng, time = np.random.default_rng(6), np.arange(0.0, 10.0, 0.04)
    noise = rng.normal(0.0, 0.008, (2, len(time)))
    pivots = PoseTrack(time, 0.004 * time + noise[0], noise[1], 0.25 * time)
    assert found(pose=pivots) == []


def test_few_moves_judge_no_heading() -> None:
    few = slice(0, 30)
    assert found(pose=circle(theta=-TIME / 3.0).rows(few)) == []


@pytest.mark.parametrize(("largest", "is_told"), [(180.0, True), (359.0, True), (400.0, False), (6.2, False)])
def test_headings_that_wrap_at_the_circle_s_degrees_are_told(largest: float, is_told: bool) -> None:
    slow = np.arange(200.0)
    theta = np.linspace(0.0, 4.0 * largest, 200) % (2.0 * largest) - largest
    pose = PoseTrack(slow, circle().x, circle().y, theta)
    told = [finding for finding in found(pose=pose) if "degrees in place of radians" in finding.sentence]
    assert bool(told) is is_told


def test_headings_in_degrees_that_never_wrap_are_not_told_as_such() -> None:
    pose = PoseTrack(np.arange(200.0), circle().x, circle().y, np.linspace(0.0, 170.0, 200))
    assert not [finding for finding in found(pose=pose) if "degrees in place" in finding.sentence]


def test_a_pose_frozen_under_drive_is_told_with_its_seconds() -> None:
    one = the_one("frozen", pose=still(60, 121), command=command(0.3))
    assert (one.rows, one.time) == (1, pytest.approx(6.0))
    assert "frozen for 6.0 s" in one.sentence


def test_a_pose_frozen_to_the_end_is_told() -> None:
    one = the_one("frozen", pose=still(150, 200), command=command(0.3))
    assert "frozen for 4.9 s" in one.sentence


@pytest.mark.parametrize(
    "track",
    [
        command(0.0),
        command(0.3, until=5.0),
        CommandTrack(np.array([0.0, 5.0, 20.0]), np.array([1.0, 0.04, 1.0]), np.zeros(3)),
        CommandTrack(np.array([13.0, 20.0]), np.full(2, 0.3), np.full(2, 0.3)),
    ],
    ids=["commands of zero", "no command any more", "too little to move", "no command yet"],
)
def test_a_pose_that_stands_while_nothing_drives_is_not_frozen(track: CommandTrack) -> None:
    kinds = {finding.kind for finding in found(pose=still(60, 121), command=track)}
    assert "frozen" not in kinds


def test_one_driven_wheel_is_a_drive() -> None:
    track = CommandTrack(np.array([0.0, 20.0]), np.zeros(2), np.full(2, -0.3))
    assert the_one("frozen", pose=still(60, 121), command=track).rows == 1


def test_a_short_standstill_is_not_frozen() -> None:
    kinds = {finding.kind for finding in found(pose=still(60, 80), command=command(0.3))}
    assert "frozen" not in kinds


def test_motion_along_one_axis_alone_is_no_standstill() -> None:
    straight = PoseTrack(TIME, 0.3 * TIME, np.zeros(200), np.zeros(200))
    assert found(pose=straight, command=command(0.3)) == []


def test_without_any_input_nothing_says_that_the_robot_was_driven() -> None:
    assert "frozen" not in {finding.kind for finding in found(pose=still(60, 121))}


def test_measured_wheels_tell_a_frozen_pose_too() -> None:
    wheels = WheelPair(TIME, np.linspace(3.0, 4.0, 200), np.linspace(3.0, 4.0, 200), "rad/s")
    assert the_one("frozen", pose=still(60, 121), wheel_rate=wheels).channel == "pose"


@pytest.mark.parametrize("side", ["left", "right"])
def test_the_wheel_that_never_moves_is_named(side: str) -> None:
    moving, dead = np.linspace(0.0, 1.0, 10), np.full(10, 0.2)
    pair = (dead, moving) if side == "left" else (moving, dead)
    one = the_one("frozen", wheel_rate=WheelPair(np.arange(10.0), *pair, "rad/s"))
    assert f"the {side} column never changes" in one.sentence


def test_two_wheels_at_rest_or_two_rows_tell_no_dead_wheel() -> None:
    rest = np.zeros(10)
    assert found(wheel_rate=WheelPair(np.arange(10.0), rest, rest, "rad/s")) == []
    assert found(wheel_rate=WheelPair(np.arange(2.0), np.zeros(2), np.arange(2.0), "rad/s")) == []


def test_commands_beyond_one_are_counted_from_their_first() -> None:
    track = CommandTrack(np.arange(4.0), np.array([1.0, 0.2, -1.2, 1.1]), np.array([0.0, 0.0, 0.0, 1.3]))
    one = the_one("unit_slip", command=track)
    assert (one.rows, one.time) == (2, 2.0)


def test_wheel_rates_beyond_one_are_no_clipped_commands() -> None:
    assert found(command=CommandTrack(np.arange(3.0), np.full(3, 9.0), np.full(3, 9.0), unit="rad/s")) == []


@pytest.mark.parametrize(("begins", "is_told"), [(15.9, False), (16.1, True), (-15.9, False), (-16.1, True)])
def test_channels_that_share_less_than_a_fifth_of_the_shorter_have_two_clocks(
    begins: float, is_told: bool
) -> None:
    time = 100.0 + np.linspace(0.0, 20.0, 41)
    wheels = WheelPair(begins + time, np.sin(time), np.cos(time), "rad/s")
    track = CommandTrack(time, np.full(41, 0.3), np.full(41, 0.3))
    told = [finding.kind for finding in found(command=track, wheel_rate=wheels)]
    assert ("clocks" in told) is is_told


@pytest.mark.parametrize(
    ("one", "other"), [((100.0, 120.0), (119.0, 121.0)), ((119.0, 121.0), (100.0, 120.0))]
)
def test_a_short_channel_shares_enough_with_half_of_its_own_length(
    one: tuple[float, float], other: tuple[float, float]
) -> None:
    track = CommandTrack(np.linspace(*one, 9), np.full(9, 0.3), np.full(9, 0.3))
    wheels = WheelPair(np.linspace(*other, 9), np.linspace(0.0, 1.0, 9), np.linspace(0.0, 2.0, 9), "rad/s")
    assert found(command=track, wheel_rate=wheels) == []
