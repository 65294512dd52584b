"""An effect's sentence with its numbers: signs in words where the sentence has words for them."""

import math

import pytest

from fsm_calib.diagnosis.verdict.explain import sentence
from fsm_calib.diagnosis.verdict.verdict import Estimate
from fsm_calib.world2d.effects import registry


@pytest.mark.parametrize(
    ("x", "y", "said"),
    [
        (0.03, 0.005, "lies 0.03 ± 0.001 m ahead and 0.005 ± 0.0006 m left of"),
        (-0.0347, -0.005, "lies 0.0347 ± 0.001 m behind and 0.005 ± 0.0006 m right of"),
    ],
)
def test_a_place_is_told_by_its_side(x, y, said):
    numbers = {"x": Estimate(x, 0.001, "m"), "y": Estimate(y, 0.0006, "m")}
    assert said in sentence(registry()["payload_offset"], numbers)


def test_poses_are_early_where_their_delay_is_negative():
    numbers = {"delay": Estimate(-0.0044, 0.0005, "s")}
    told = sentence(registry()["observation_delay"], numbers, "constant")
    assert told == "Poses are stamped 0.0044 ± 0.0005 s early."


def test_a_number_without_words_keeps_its_sign():
    numbers = {"offset": Estimate(-0.9, math.nan, "1")}
    assert "lose -0.9 of every command" in sentence(registry()["motor_deadband"], numbers)


def test_every_sentence_reads_with_the_usual_numbers():
    for effect in registry().values():
        numbers = {p.name: Estimate(p.typical, 0.1, p.unit) for p in effect.parameters}
        for closure in ("", *(c.name for c in effect.closures)):
            assert "{" not in sentence(effect, numbers, closure)
