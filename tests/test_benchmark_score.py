"""The concealed proof's table: the key's numbers in the catalogue's words, and who counts as right."""

import math
import sys

import pytest
from recording_samples import ROOT

from fsm_calib.world2d.effects import registry

sys.path.insert(0, str(ROOT / "benchmarks"))

from concealed.robots import BY_NAME, HIDDEN
from concealed.score import confidence_rows, number_rows, right, time_rows
from concealed.truth import PLACES, STRENGTHS, TIMES, compared, distance, strength_error


def key_line(label, **fields):
    return {"label": label, "physics": fields, "sensor": {}, "encoders": False, "level": "plain"}


def effect(name, **numbers):
    said = {key: {"value": value, "sd": sd, "unit": ""} for key, (value, sd) in numbers.items()}
    return {"name": name, "parameters": said, "confidence": 0.9}


def verdict(*effects, seconds=1.0):
    return {"verdict": "explained", "effects": list(effects), "ambiguous": [], "seconds": seconds}


def test_every_hidden_effect_but_one_has_a_strength_to_compare():
    assert {hidden.name for hidden in HIDDEN} - set(STRENGTHS) == {"lateral_slip"}


@pytest.mark.parametrize("table", [STRENGTHS, PLACES, TIMES])
def test_translations_read_the_generators_fields_and_speak_the_catalogues_names(table):
    import numpy as np
    from concealed.physics import Physics

    for name, translate in table.items():
        hidden, rng = BY_NAME[name], np.random.default_rng(0)
        fields = Physics()._asdict() | hidden.physics(0.5, rng) | hidden.sensor(0.5, rng)
        assert set(translate(fields)) <= {p.name for p in registry()[name].parameters}


def test_a_nap_against_the_travel_is_the_catalogues_drag():
    fields = {"nap": 0.4, "nap_direction": 0.7}
    n = STRENGTHS["carpet_nap"](fields)
    for travel in (0.0, 1.0, 2.5, -2.0):
        theirs = 0.4 * 0.5 * (1 + math.cos(travel - 0.7))
        ours = math.hypot(n["x"], n["y"]) - (n["x"] * math.cos(travel) + n["y"] * math.sin(travel))
        assert ours == pytest.approx(theirs)


def test_an_error_of_a_vector_is_a_share_of_its_length():
    line = key_line("floor_tilt", tilt_x=0.03, tilt_y=0.04)
    found = compared(line, effect("floor_tilt", slope_x=(0.03, 0.01), slope_y=(0.05, 0.001)))
    assert strength_error(found) == pytest.approx(0.2)
    assert [number.held for number in found] == [True, False]


def test_blaming_the_other_wheel_misses_the_whole_size():
    line = key_line("wheel_eccentricity", ecc_left=0.1, ecc_right=0.0)
    assert strength_error(compared(line, effect("wheel_eccentricity", right=(0.1, 0.01)))) == pytest.approx(
        math.sqrt(2)
    )


def test_a_ratio_of_time_constants_is_measured_from_one():
    line = key_line("motor_asymmetric_lag", brake_fade=0.5)
    assert strength_error(compared(line, effect("motor_asymmetric_lag", ratio=(1.9, 0.1)))) == pytest.approx(
        0.1
    )


def test_warming_up_by_time_and_by_effort_are_compared_at_the_end_of_a_drive():
    line = key_line("motor_warmup", warm_left=0.2, warm_right=0.0, warm_time=60.0)
    share = 1 - math.exp(-1)
    (number,) = compared(line, effect("motor_warmup", change_left=(0.2 * share, 0.1), effort=(0.01, None)))
    assert number.share == pytest.approx(0.0, abs=1e-9)
    assert number.held is None


def test_places_and_onsets_are_distances():
    line = key_line("low_friction_patch", patch_mu=0.2, patch_x=0.1, patch_y=0.2)
    said = effect("low_friction_patch", loss=(0.8, 0.1), x=(0.13, 0.1), y=(0.24, 0.1))
    assert distance(compared(line, said), "place") == pytest.approx(0.05)
    push = key_line("external_push", push_m=0.1, push_time=20.0)
    assert distance(compared(push, effect("external_push", start=(20.4, 0.1))), "time") == pytest.approx(0.4)


def test_a_key_of_another_world_is_compared_where_it_has_the_field():
    assert compared(key_line("battery_sag", sag=0.1), effect("battery_sag", per_charge=(0.1, 0.1))) == []


def test_the_delays_count_as_one_without_encoders_and_share_their_number():
    line = key_line("command_delay", delay=0.1)
    said = verdict(effect("observation_delay", delay=(0.11, 0.01)))
    assert right((line, said))
    assert not right(({**line, "encoders": True}, said))
    assert strength_error(compared(line, said["effects"][0])) == pytest.approx(0.1)


def test_the_table_tells_errors_coverage_and_time_by_what_was_recorded():
    pairs = [
        (key_line("sensor_yaw", yaw=0.1), verdict(effect("sensor_yaw", yaw=(0.11, 0.02)), seconds=8.0)),
        (
            key_line("tyre_scrub", scrub_dry=0.1),
            verdict(effect("tyre_scrub", moment=(0.15, 0.01)), seconds=4.0),
        ),
    ]
    rows = {
        name: value for name, value, _ in (*number_rows(pairs), *time_rows(pairs), *confidence_rows(pairs))
    }
    assert rows["parameter error, median"] == "30.0 % (n 2)"
    assert rows["parameter error, worst effect's median"] == "50.0 % (tyre_scrub, n 1)"
    assert rows["90 % intervals that hold the truth"] == "50.0 % (1/2)"
    assert rows["seconds without encoders, median / max"] == "6.0 / 8.0 (n 2)"
    assert rows["seconds with encoders, median / max"] == "-"
    assert rows["stated confidence, mean / share right"] == "0.900 / 1.000"


def test_either_name_of_a_pair_counts_as_a_right_first_name():
    said = verdict(effect("payload_offset"))
    rows = dict(
        (name, value)
        for name, value, _ in confidence_rows([(key_line("coulomb_friction+payload_offset"), said)])
    )
    assert rows["stated confidence, mean / share right"] == "0.900 / 1.000"
