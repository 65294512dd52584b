"""The concealed benchmark's bookkeeping: sealed verdicts, and which runs count as without the true effect."""

import json
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "benchmarks"))

from concealed import run
from concealed.score import is_left_out


def written(folder, name, *effects):
    folder.mkdir(exist_ok=True)
    verdict = {"verdict": "explained" if effects else "match", "effects": [{"name": e} for e in effects]}
    (folder / f"{name}.json").write_text(json.dumps(verdict))


def line(**changes):
    return {
        "name": "robot-000",
        "label": "floor_tilt",
        "level": "plain",
        "poor": False,
        "encoders": True,
    } | changes


def test_a_verdict_cannot_change_once_it_is_sealed(tmp_path):
    written(tmp_path / "verdicts", "robot-000", "floor_tilt")
    run.seal(tmp_path)
    written(tmp_path / "verdicts", "robot-000", "carpet_nap")
    with pytest.raises(SystemExit, match=r"robot-000\.json differs"):
        run.seal(tmp_path)


def test_verdicts_that_join_are_sealed_beside_the_others(tmp_path):
    for name in ("robot-000", "robot-001"):
        written(tmp_path / "verdicts", name)
        run.seal(tmp_path)
    assert len((tmp_path / "verdicts.sha256").read_text().splitlines()) == 2


def test_one_single_name_of_a_block_is_left_out_once(tmp_path):
    verdicts, left_out = tmp_path / "verdicts", tmp_path / "without"
    for name, effects in (("robot-000", ()), ("robot-001", ("command_delay",)), ("robot-002", ("a", "b"))):
        written(verdicts, name, *effects)
    left_out.mkdir()
    robots = [Path(f"robot-00{i}") for i in range(3)]
    ((robot, out, without),) = run.name_to_leave_out(robots, verdicts, left_out)
    assert (robot.name, without) == ("robot-001", ("command_delay", "observation_delay"))
    written(out.parent, out.stem)
    assert run.name_to_leave_out(robots, verdicts, left_out) == []


@pytest.mark.parametrize(
    ("changes", "without", "counts"),
    [
        ({}, ["floor_tilt"], True),
        ({}, ["carpet_nap"], False),
        ({"level": "faint"}, ["floor_tilt"], False),
        ({"label": "floor_tilt+command_delay"}, ["floor_tilt"], False),
        ({"poor": True}, ["floor_tilt"], False),
    ],
)
def test_a_run_counts_where_the_true_effect_was_left_out(changes, without, counts):
    assert is_left_out((line(**changes), {"without": without})) is counts
