"""The bar of a diagnosis is not full while there is work to do."""

import io

import pytest
from rich.console import Console

from fsm_calib.progress.diagnosis import DiagnosisProgress

NAMES = ("command_delay", "floor_tilt", "tyre_scrub")
END = ("what is left", "how sure", "place and moment", "proof")


def shares(parts):
    bar = DiagnosisProgress(len(NAMES), Console(file=io.StringIO(), force_terminal=False))
    found = []
    for name in parts:
        bar.part(name)
        found.append(bar.share)
    return found


@pytest.mark.parametrize("rounds", [1, 2, 4])
def test_the_bar_is_not_full_before_the_end_however_many_rounds(rounds):
    found = shares(("base robot", *(NAMES * rounds), *END))
    assert max(found) < 1.0
    assert found[-1] > 0.7


def test_before_the_first_part_compiling_is_named():
    seen = io.StringIO()
    with DiagnosisProgress(len(NAMES), Console(file=seen, force_terminal=True)):
        pass
    assert "a first run compiles, too" in seen.getvalue()


def test_every_part_moves_the_bar():
    (*before, _), (_, *after) = (shares(("base robot", *NAMES, *END)) for _ in range(2))
    assert all(b < a for b, a in zip(before, after, strict=True))
