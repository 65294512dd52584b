"""The diagrams are current and true: what they draw, read back from their text, is what is declared."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

from fsm_calib.machines.calibration import CALIBRATION
from fsm_calib.machines.supervisor import MACHINES, SUPERVISOR
from fsm_calib.statechart.diagrams import diagram_texts, draw_svg, pictures, stale_diagrams, write_diagrams
from fsm_calib.statechart.dot import dot_text
from fsm_calib.statechart.mermaid import LINE, STAY, mermaid_text
from fsm_calib.statechart.picture import picture

DIAGRAMS = Path(__file__).parent.parent / "diagrams"
DRAWN = r"^    (\w+) --> (\w+) : (.*)$"
ROW = r"^ +(\w+) : (.*)$"


def read_back(text: str) -> set[tuple[str, str]]:
    """Source and label of everything that the Mermaid text draws; where it leads is part of the label."""
    found = set()
    for source, dest, labels in re.findall(DRAWN, text, re.M):
        found |= {(source, f"{label} -> {dest}") for label in labels.split(LINE)}
    for source, label in re.findall(ROW, text, re.M):
        if not label.startswith("do / "):
            found.add((source.removesuffix("__every"), label.removesuffix(STAY)))
    return found


def declared(chart) -> set[tuple[str, str]]:
    """The same, from the table alone."""
    found = set()
    for edge in chart.all_transitions():
        source, dest = edge.source.replace("/", "__"), (edge.dest or "").removeprefix("/")
        if not dest or edge.dest == edge.source:
            way = ""
        elif dest.startswith(("failed/", "aborted")):
            way = f" ⇒ {dest.split('/')[-1]}"
        else:
            way = f" -> {dest.replace('/', '__')}"
        found.add((source, edge.label + way))
    return found


@pytest.mark.parametrize("chart", [*MACHINES, SUPERVISOR], ids=lambda chart: chart.name)
def test_mermaid_text_draws_every_declared_transition_and_no_other(chart) -> None:
    drawn = {item for item in read_back(mermaid_text(picture(chart))) if item[0] != "failed"}
    assert drawn == declared(chart)


@pytest.mark.parametrize("chart", [*MACHINES, SUPERVISOR], ids=lambda chart: chart.name)
def test_every_state_is_drawn(chart) -> None:
    text = mermaid_text(picture(chart))
    for path, _ in chart.walk():
        if not path.startswith("failed/"):
            assert f" as {path.replace('/', '__')}\n" in text


def test_active_leaf_and_all_states_around_it_are_marked() -> None:
    text = mermaid_text(picture(SUPERVISOR), active="scan/clockwise/collecting")
    marked = re.findall(r"^    class (\w+) active$", text, re.M)
    assert marked == ["scan", "scan__clockwise", "scan__clockwise__collecting"]


def test_active_failure_marks_the_box_of_failures() -> None:
    text = mermaid_text(picture(SUPERVISOR), active="failed/wall_hit")
    assert re.findall(r"^    class (\w+) active$", text, re.M) == ["failed"]


def test_active_leaf_is_marked_in_dot_text_too() -> None:
    plain, marked = (dot_text(picture(SUPERVISOR), active=leaf) for leaf in ("", "wheels/forward"))
    assert "#ffd54f" not in plain
    assert marked.count("#ffd54f") == 1


def test_committed_diagrams_are_current() -> None:
    assert [path.name for path in stale_diagrams(CALIBRATION, DIAGRAMS)] == []


def test_stale_and_missing_files_are_found(tmp_path: Path) -> None:
    write_diagrams(CALIBRATION, tmp_path)
    assert stale_diagrams(CALIBRATION, tmp_path) == []
    (tmp_path / "scan.mmd").write_text("stateDiagram-v2\n", encoding="utf-8")
    (tmp_path / "lane.svg").write_text("<svg/>", encoding="utf-8")
    (tmp_path / "README.md").unlink()
    assert {path.name for path in stale_diagrams(CALIBRATION, tmp_path)} == {
        "scan.mmd",
        "lane.svg",
        "README.md",
    }


def test_texts_are_the_same_every_time_and_end_with_one_line_feed() -> None:
    first, second = diagram_texts(CALIBRATION), diagram_texts(CALIBRATION)
    assert first == second
    assert all(
        text.endswith("\n") and not text.endswith("\n\n") and "\r" not in text for text in first.values()
    )


def test_there_is_a_picture_for_every_machine_the_supervisor_and_the_whole() -> None:
    assert set(pictures(CALIBRATION)) == {chart.name for chart in MACHINES} | {"supervisor", "whole"}


def test_without_graphviz_the_texts_are_written_and_the_project_s_pictures_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    assert draw_svg("digraph {}") is None
    written = write_diagrams(CALIBRATION, tmp_path / "out")
    assert {path.suffix for path in written} == {".mmd", ".dot", ".md", ".svg"}
    assert stale_diagrams(CALIBRATION, tmp_path / "out") == []


def test_graphviz_is_given_the_text_and_its_failure_is_not_hidden(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = tmp_path / "dot"
    program.write_text("#!/bin/sh\nexit 3\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(subprocess.CalledProcessError):
        draw_svg("digraph {}")
