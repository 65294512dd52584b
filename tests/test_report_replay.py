"""The replay: a run's page shows any moment of it, and a film shows all of them."""

import json
import re

import numpy as np
import pytest
from browser import faults, needs_browser, page_after_scripts
from PIL import Image

from fsm_calib.errors import InputError
from fsm_calib.report import movie
from fsm_calib.report.run_replay import MOST_POSES, thinned_track
from fsm_calib.report.run_report import run_report
from fsm_calib.runner.run import run_scenario
from fsm_calib.scenario.load import load_scenario

TOLD = re.compile(r'id="replay-data">(.*?)</script>', re.DOTALL)


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """Run a robot that turns to the floor tags; return its record and its page."""
    folder = tmp_path_factory.mktemp("run")
    (folder / "turn.yaml").write_text("name: turn\nrobot: {known: {camera: true}}\nplan: [orientation]\n")
    records = []

    def draw(record) -> str:
        records.append(record)
        return run_report(record)

    run_scenario(load_scenario(folder / "turn.yaml"), folder / "out", draw=draw)
    return records[0], folder / "out" / "report.html"


def test_page_holds_every_event_frame_and_the_path(told) -> None:
    record, page = told
    found = TOLD.search(page.read_text(encoding="utf-8"))
    assert found is not None
    data = json.loads(found[1])
    assert [path for _, path, _ in data["events"]] == [event["path"] for event in record.events]
    assert len(data["frames"]) == len(record.pictures) > 0
    assert data["poses"][-1][0] == pytest.approx(record.track[-1, 0], abs=0.01)


def test_long_track_is_thinned_between_its_ends() -> None:
    track = np.arange(40_000.0).reshape(-1, 4)
    kept = thinned_track(track)
    assert len(kept) == MOST_POSES
    assert (kept[0, 0], kept[-1, 0]) == (track[0, 0], track[-1, 0])


@needs_browser
def test_page_shows_the_first_moment_without_a_hand(told, tmp_path) -> None:
    record, page = told
    shown = page_after_scripts(page.as_uri(), tmp_path)
    assert record.events[0]["path"].replace("/", " / ") in re.search(r'id="replay-state">([^<]*)<', shown)[1]
    assert 'id="replay-clock">0.0 s<' in shown


@needs_browser
def test_page_of_a_run_is_sound_in_a_browser(told, tmp_path) -> None:
    failing = (
        "name: lost\nrobot: {known: {camera: true}}\nfaults: [{kind: missing_markers}]\nplan: [orientation]\n"
    )
    (tmp_path / "lost.yaml").write_text(failing)
    pages = {"done": told[1].read_text(encoding="utf-8")}
    run_scenario(
        load_scenario(tmp_path / "lost.yaml"),
        tmp_path / "out",
        draw=lambda record: pages.setdefault("failed", run_report(record)),
    )
    assert "Failed" in pages["failed"] or "failed" in pages["failed"]
    assert faults(pages, tmp_path) == []


def test_film_shows_as_many_moments_as_it_says(told, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(movie, "SECONDS", 1.0)
    for name in ("run.gif", "run.mp4"):
        movie.write_movie(told[0], tmp_path / name)
    assert (tmp_path / "run.mp4").stat().st_size > 1000
    with Image.open(tmp_path / "run.gif") as film:
        assert (film.size, film.n_frames) == (movie.SIZE, 6)


def test_film_of_another_kind_is_refused(tmp_path) -> None:
    with pytest.raises(InputError, match=r"\.mp4 or \.gif"):
        movie.movie_kind(tmp_path / "run.avi")
