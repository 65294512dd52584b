"""A machine in one file outside the package is drawn, checked exhaustively and run on rendered pixels."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner, Result

from fsm_calib.cli import app
from fsm_calib.errors import UnknownNameError
from fsm_calib.journal import JOURNAL_NAME, read_journal
from fsm_calib.statechart.diagrams import diagram_texts
from fsm_calib.statechart.from_file import machinery_from
from fsm_calib.statechart.runtime import Machine

HERE = Path(__file__).parent
FILE = HERE / "machines_outside" / "light_round.py"
SCENARIO = HERE / "machines_outside" / "light_round.yaml"
PAGE = HERE.parent / "docs" / "own-machine.md"


def call(*arguments: object) -> Result:
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def changed(folder: Path, old: str, new: str) -> Path:
    """A copy of the machine's file with a slip."""
    text = FILE.read_text()
    assert old in text
    copy = folder / "slip.py"
    copy.write_text(text.replace(old, new))
    return copy


def test_the_page_shows_the_file_that_is_tested() -> None:
    assert f"```python\n{FILE.read_text()}```" in PAGE.read_text()


def test_it_is_drawn_with_every_state_and_the_drawing_is_current_then(tmp_path: Path) -> None:
    out = tmp_path / "drawn"
    assert call("diagrams", "--machines", FILE, "--out", out).exit_code == 0
    text = (out / "light_round.mmd").read_text()
    assert "turning --> measuring : marker_seen" in text
    assert "measuring --> turning : light_measured [has_places_left & !is_dark] / count_place" in text
    assert call("diagrams", "--check", "--machines", FILE, "--out", out).exit_code == 0
    (out / "light_round.dot").write_text("digraph {}")
    stale = call("diagrams", "--check", "--machines", FILE, "--out", out)
    assert (stale.exit_code, str(FILE) in stale.stderr) == (1, True)


def test_its_page_lists_its_own_activity_and_limits() -> None:
    page = diagram_texts(machinery_from(FILE))["README.md"]
    assert "`measure_light`" in page
    assert "`darkest` | 40" in page
    assert "`solve_camera`" not in page


def test_it_is_checked_in_every_configuration() -> None:
    result = call("validate", SCENARIO, "--machines", FILE)
    assert result.exit_code == 0
    assert "all are taken, and every run ends" in result.stdout
    assert f"{SCENARIO}: valid" in result.stdout


def test_it_runs_on_rendered_pixels_and_its_run_can_be_resumed(tmp_path: Path) -> None:
    out = tmp_path / "run"
    assert call("run", SCENARIO, "--machines", FILE, "--out", out).exit_code == 0
    events = list(read_journal(out / JOURNAL_NAME))
    greys = [event["evidence"]["grey"] for event in events if event["trigger"] == "light_measured"]
    assert len(greys) == 2
    assert all(30.0 < grey < 255.0 for grey in greys)
    assert json.loads((out / "result.json").read_text())["state"] == "done"
    assert (out / "report.html").is_file()
    again = call("run", SCENARIO, "--machines", FILE, "--resume", out)
    assert (again.exit_code, list(read_journal(out / JOURNAL_NAME))) == (0, events)
    calibration = tmp_path / "same.yaml"
    calibration.write_text("name: light_round\nseed: 3\nrobot: {source: nominal, known: {camera: true}}\n")
    assert call("run", calibration, "--resume", out).exit_code == 1


def test_its_own_limit_ends_a_run_with_its_own_reason_and_numbers(tmp_path: Path) -> None:
    scenario = tmp_path / "dark.yaml"
    scenario.write_text(SCENARIO.read_text().replace("darkest: 30", "darkest: 254"))
    result = call("run", scenario, "--machines", FILE, "--out", tmp_path / "run")
    assert result.exit_code == 1
    assert (
        "too_dark: After 0 bright places a picture was darker than 254. Switch on the light." in result.stderr
    )


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        ("limits: {place: 2}", ":1:10: unknown limits setting 'place'. Did you mean places?"),
        ("plan: [scan]", ":1:7: "),
        ("limits: {darkest: bright}", ":1:19: "),
    ],
)
def test_a_scenario_may_give_only_what_the_machine_has(tmp_path: Path, line: str, sentence: str) -> None:
    scenario = tmp_path / "wrong.yaml"
    scenario.write_text(f"{line}\nname: wrong\n")
    result = call("validate", scenario, "--machines", FILE)
    assert result.exit_code == 2
    assert f"{scenario}{sentence}" in result.stderr


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ('"resting", "turning"),', '"resting", "turnin"),', "no state turnin. Did you mean turning?"),
        ('when("is_dark"', 'when("is_drak"', "no guard is_drak. Did you mean is_dark?"),
        (
            '"turning", "count_place"',
            '"turning", "count_plac"',
            "no action count_plac. Did you mean count_place?",
        ),
        (
            'do="measure_light"',
            'do="measure_ligth"',
            "no activity measure_ligth. Did you mean measure_light?",
        ),
        ("in {turns} turning", "in {turn} turning", "the reason names turn. Did you mean turns?"),
        ("streaks=STREAKS", 'streaks={"lost": "count_turn"}', "the books have no lost to count in a row"),
        (
            '("resting", "turning", "measuring"), "abo',
            '("resting", "turning"), "abo',
            "abort is not declared",
        ),
        ("does=named(measure_light),", "", "nothing does the activity measure_light"),
        ("MACHINE = Mach", "MACHINES = Mach", "declares no machine"),
        ("turns: int = 0\n", "turns: int = )\n", ":27: cannot be loaded (SyntaxError"),
        ("return Outcome(", "retrun Outcome(", "cannot be loaded (SyntaxError"),
        ("contract=CONTRACT", "contract=CONTRACTS", "cannot be loaded (NameError: name 'CONTRACTS'"),
    ],
)
def test_a_slip_is_one_sentence_before_anything_is_written(
    tmp_path: Path, old: str, new: str, sentence: str
) -> None:
    slip = changed(tmp_path, old, new)
    result = call("run", SCENARIO, "--machines", slip, "--out", tmp_path / "run")
    assert result.exit_code == 2
    assert sentence.rstrip("?") in result.stderr
    assert "Traceback" not in result.output
    assert not (tmp_path / "run" / JOURNAL_NAME).exists()


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("books.turns += 1", "pass", "may go on for ever through turning"),
        ('samples={"grey": (10.0, 200.0)},', "", "no samples of the evidence grey"),
        ("(10.0, 200.0)", "(100.0, 200.0)", "state failed/too_dark is never reached"),
        ("limits.darkest)", "limits.darkst)", "fails with AttributeError"),
        ('["grey"]', '["gray"]', "fails with KeyError: 'gray'"),
    ],
)
def test_what_only_a_run_would_show_is_found_by_the_exhaustive_check(
    tmp_path: Path, old: str, new: str, sentence: str
) -> None:
    result = call("validate", "--machines", changed(tmp_path, old, new))
    assert result.exit_code == 2
    assert sentence in result.stderr


def test_its_books_count_and_survive_a_checkpoint() -> None:
    machinery = machinery_from(FILE)
    machine = Machine(machinery, state="turning")
    machine.books.turns = 7
    kept = machinery.books.from_dict(json.loads(json.dumps(machine.books.to_dict())))
    assert kept == machine.books
    with pytest.raises(UnknownNameError, match="phase"):
        Machine(machinery, plan=["scan"])


def test_nothing_to_check_is_said() -> None:
    result = call("validate")
    assert (result.exit_code, "nothing to check" in result.stderr) == (2, True)
