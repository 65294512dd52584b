"""The benchmark of foreign physics: one seed, one set; every law changes the drive; no truth in the recordings."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from recording_samples import ROOT

from fsm_calib.recording import read_recording

sys.path.insert(0, str(ROOT / "benchmarks"))

from foreign import generate
from foreign.catalogue import LAWS, Law
from foreign.drive import Drive, replay
from foreign.score import calibration, improvement, names_right, score, wrong_names
from foreign.sealed import RUNS, Bench, Effect, Order, draw_bench, make
from foreign.setup import Place
from foreign.tracker import clean_poses

TIMES = np.array([0.0, 0.2, 2.0, 2.5, 3.0, 4.2, 5.6, 6.4, 7.8])
DUTIES = np.array(
    [[0, 0], [0.9, 0.9], [0, 0], [0.07, 0.06], [-0.5, 0.5], [-0.7, -0.4], [0.1, 0.2], [0.6, 0.0], [0.3, 0.35]]
)
ALL = [item for laws in LAWS.values() for item in laws]


def bench_of(item: Law) -> Bench:
    bench = draw_bench(Order("r", "plain", (item.label,), "planar", 3, item.name), 0)
    bench.place = Place(0.0, 0.0, "ellipse", 0.8, 0.8, 0.0, 0.0)
    bench.windows = dict.fromkeys(RUNS, (0.5, 6.0))
    return bench


def shown(bench: Bench, effects: list[Effect]) -> np.ndarray:
    setup = bench.setup("run-a", effects)
    drive = replay(setup, np.zeros(3), TIMES, DUTIES, 8.5, 1)
    return clean_poses(setup, drive, 20.0, 0.0)[1]


@pytest.mark.parametrize("item", ALL, ids=lambda item: f"{item.label}-{item.name}")
def test_law_changes_what_is_seen(item: Law) -> None:
    bench = bench_of(item)
    effect = Effect(item, 1.0, 5)
    without, with_effect = shown(bench, []), shown(bench, [effect])
    assert np.isfinite(with_effect).all()
    assert np.abs(with_effect - without).max() > 1e-3
    assert effect.sizes


@pytest.mark.parametrize("name", ["gritty", "stuck_swivel"])
def test_a_caster_takes_energy_from_the_robot(name: str) -> None:
    [item] = [law for law in LAWS["caster_drag"] if law.name == name]
    bench = bench_of(item)
    others = len(bench.setup("run-a", []).hooks)
    [caster] = bench.setup("run-a", [Effect(item, 1.0, 5)]).hooks[others:]
    rng, power = np.random.default_rng(4), []
    for step in range(2000):
        state = np.concatenate(
            [rng.uniform(-3.0, 3.0, 3), rng.normal(size=2) * 0.3, rng.normal(size=1) * 3.0]
        )
        force = np.zeros(3)
        caster(0.01 * step, state, force)
        power.append(force @ state[3:])
    assert max(power) <= 1e-9
    assert min(power) < -1e-3


def test_every_label_has_two_laws_and_every_law_a_source() -> None:
    assert {label for label, laws in LAWS.items() if len(laws) < 2} == set()
    assert all(item.apply.__doc__ for item in ALL)
    assert len(generate.LABELS) == 26
    assert len(LAWS["outside"]) >= 8


def test_seed_gives_the_same_robot_to_the_byte(tmp_path: Path) -> None:
    order = Order("robot-000", "plain", ("sensor_yaw",), "planar", 11)
    keys = [make(order, tmp_path / name) for name in ("one", "two")]
    assert keys[0] == keys[1]
    files = sorted(path.relative_to(tmp_path / "one") for path in (tmp_path / "one").rglob("*.*"))
    assert len(files) >= 9
    assert all((tmp_path / "one" / f).read_bytes() == (tmp_path / "two" / f).read_bytes() for f in files)


def test_recordings_read_back_and_hold_no_truth(tmp_path: Path) -> None:
    key = make(Order("robot-000", "plain", ("sensor_yaw",), "planar", 11), tmp_path)
    for run in RUNS:
        folder = tmp_path / "robot-000" / run
        recording = read_recording(folder)
        assert recording.pose is not None
        assert recording.pose.time[-1] > 45.0
        words = (folder / "recording.yaml").read_text()
        assert not any(word in words for word in ("sensor_yaw", "plain", "planar", *key["departures"]))
        names = {path.name for path in folder.iterdir()}
        assert names <= {"recording.yaml", "command.csv.gz", "pose.csv.gz", "ticks.csv.gz"}


def test_orders_are_the_same_for_a_seed_and_mix_engines() -> None:
    orders = generate.orders(4, 60, "mixed")
    assert orders == generate.orders(4, 60, "mixed")
    assert sum(order.engine != "planar" for order in orders) >= 15
    assert {order.family for order in orders} == set(generate.FAMILIES)
    assert {label for order in orders for label in order.labels} >= set(generate.LABELS)


def test_piloted_drive_replays_to_the_same_track() -> None:
    bench = draw_bench(Order("r", "clean", (), "planar", 5), 0)
    _, drive = bench.drive("run-a", [])
    _, again = bench.again("run-a", [], drive)
    assert isinstance(again, Drive)
    assert np.array_equal(drive.rows, again.rows)


def key(family: str, labels: list[str], **more: Any) -> dict[str, Any]:
    strongest = labels[0] if labels else None
    return {
        "name": "r",
        "family": family,
        "labels": labels,
        "strongest": strongest,
        "engine": "planar",
        "effects": [],
        "departures": {},
        **more,
    }


def answer(*names: tuple[str, float], ambiguous: list[list[str]] | None = None) -> dict[str, Any]:
    effects = [{"name": n, "confidence": c, "parameters": {}} for n, c in names]
    return {
        "verdict": "explained" if names else "unexplained",
        "effects": effects,
        "ambiguous": ambiguous or [],
    }


def test_ambiguity_set_with_the_true_name_is_right() -> None:
    said = answer(("motor_deadband", 0.9), ambiguous=[["motor_deadband", "coulomb_friction"]])
    assert names_right(said, ["coulomb_friction"]) == {"coulomb_friction"}
    assert wrong_names(said, key("plain", ["coulomb_friction"])) == []


def test_name_of_a_departure_is_wrong_only_when_strict() -> None:
    truth = key("clean", [], departures={"mass_behind": 0.4})
    said = answer(("payload_offset", 0.9))
    assert wrong_names(said, truth) == []
    assert wrong_names(said, truth, strict=True) == ["payload_offset"]


@pytest.mark.parametrize(("found", "wrong"), [(-0.021, []), (-0.012, ["payload_offset"])])
def test_a_centre_of_mass_in_the_key_is_a_right_name_where_its_size_was_found(
    found: float, wrong: list[str]
) -> None:
    truth = key("plain", ["sensor_yaw"], robot={"centre_x": -0.023, "centre_y": 0.003})
    said = answer(("sensor_yaw", 0.9), ("payload_offset", 0.95))
    said["effects"][1]["parameters"] = {"x": {"value": found}, "y": {"value": 0.001}}
    assert wrong_names(said, truth) == ["payload_offset"]
    assert wrong_names(said, truth, lenient=True) == wrong


@pytest.mark.parametrize(("found", "wrong"), [(0.034, []), (0.06, ["caster_drag"])])
def test_a_ball_that_slides_as_it_was_built_is_a_right_name(found: float, wrong: list[str]) -> None:
    truth = key("plain", ["sensor_yaw"], engine="rapier", robot={"caster_friction": 0.037})
    said = answer(("sensor_yaw", 0.9), ("caster_drag", 0.8))
    said["effects"][1]["parameters"] = {"drag": {"value": found}}
    assert wrong_names(said, truth, lenient=True) == wrong


def test_score_of_a_small_set_counts_each_row() -> None:
    pairs = [
        (key("plain", ["sensor_yaw"]), answer(("sensor_yaw", 0.95))),
        (key("plain", ["floor_tilt"]), answer(("carpet_nap", 0.85))),
        (key("pair", ["sensor_yaw", "floor_tilt"]), answer(("sensor_yaw", 0.9))),
        (key("clean", []), answer(("gear_backlash", 0.5))),
        (key("outside", []), answer()),
    ]
    rows = {what: measured for what, measured, _ in score(pairs)}
    assert rows["strongest named, plain"] == "1 of 2 (50 %)"
    assert rows["both of a pair"] == "0 of 1 (0 %)"
    assert rows["a wrong name above 0.6"] == "1 of 3 (33 %)"
    assert rows["clean, a false name above 0.6"] == "0 of 1 (0 %)"
    assert rows["outside, no name for it"] == "1 of 1 (100 %)"
    assert {low: right for low, _, _, right in calibration(pairs)} == {0.5: 0.0, 0.8: 0.0, 0.9: 1.0}


def test_improvement_is_the_share_above_the_floor() -> None:
    held = {
        "before": {"xy_m": 0.05, "theta_rad": 0.02},
        "after": {"xy_m": 0.02, "theta_rad": 0.02},
        "floor": {"xy_m": 0.01, "theta_rad": 0.02},
    }
    assert improvement({"fit": {"holdout": held}})["removed"] == pytest.approx(0.75)
