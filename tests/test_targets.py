"""Printable targets: what is drawn is found again in a raster of the PDF, to a tenth of a millimetre."""

import numpy as np
import pytest
from typer.testing import CliRunner

from fsm_calib.cli import app
from fsm_calib.errors import InputError
from fsm_calib.perception.chessboard import find_board
from fsm_calib.perception.tags import find_tags
from fsm_calib.targets.area import area_sheets, poster, tiling
from fsm_calib.targets.boards import board_sheets, inner_corners
from fsm_calib.targets.pdf import write_pdf
from fsm_calib.targets.plan import plan_sheet
from fsm_calib.targets.sheet import MARGIN, PAPERS
from fsm_calib.targets.tags import placed_tags, tag_sheets
from fsm_calib.types import BoardSpec
from fsm_calib.world2d.layout import calibration_area, lane_beyond, mixed_boards
from fsm_calib.world2d.scene import MarkerField

pdfium = pytest.importorskip("pypdfium2", reason="pypdfium2 renders PDF; it comes with the extra dev")
DPI = 150
TOLERANCE = 0.1  # mm


@pytest.fixture(scope="module")
def scene():
    field = MarkerField(rows=2, columns=3)
    road = lane_beyond(field, length=2.0, markers=2, first_marker=0.8)
    return calibration_area(mixed_boards(2), field, road)


def rendered(tmp_path, sheets, page=0):
    path = tmp_path / "sheets.pdf"
    write_pdf(path, sheets, "test")
    document = pdfium.PdfDocument(path)
    image = np.ascontiguousarray(document[page].render(scale=DPI / 72.0, grayscale=True).to_numpy().squeeze())
    document.close()
    return image


def on_sheet(pixels, sheet):
    """Return where pixels are on the sheet [mm]; a page is stretched to whole pixels, their centres whole numbers."""
    size = np.array([sheet.width, sheet.height])
    at = (np.asarray(pixels) + 0.5) * size / np.ceil(size * DPI / 25.4 - 1e-6)
    return np.column_stack([at[:, 0], sheet.height - at[:, 1]])


def test_printed_board_is_found_where_it_is_drawn(tmp_path, scene) -> None:
    sheet = board_sheets(scene.boards, "a4")[0]
    board = scene.boards[0].board
    view = find_board(rendered(tmp_path, [sheet]), board)
    assert view is not None
    error = on_sheet(view.corners_image, sheet) - inner_corners(board, sheet)
    assert np.abs(error).max() < TOLERANCE


@pytest.mark.parametrize("paper", list(PAPERS))
def test_printed_tags_are_found_in_order_and_at_true_size(tmp_path, scene, paper) -> None:
    tags = placed_tags(scene)
    sheet = tag_sheets(tags, paper)[0]
    found = find_tags(rendered(tmp_path, [sheet]))
    expected = {tag.number: tag for tag in tags[: len(found)]}
    assert [tag.tag_id for tag in found] == sorted(expected)
    for tag in found:
        corners = on_sheet(tag.corners_image, sheet)
        sides = np.linalg.norm(np.diff(corners, axis=0, append=corners[:1]), axis=1)
        assert np.abs(sides - 1000.0 * expected[tag.tag_id].size).max() < TOLERANCE
        assert corners[1, 0] - corners[0, 0] > 0.0  # upright: the x axis runs to the right


def test_poster_has_every_tag_where_the_world_has_it(tmp_path, scene) -> None:
    sheet = poster(scene)
    found = {tag.tag_id: tag for tag in find_tags(rendered(tmp_path, [sheet]))}
    tags = placed_tags(scene)
    assert sorted(found) == sorted(tag.number for tag in tags)
    origin = None
    for tag in tags:
        corners = on_sheet(found[tag.number].corners_image, sheet)
        middle = corners.mean(axis=0)
        place = np.array([1000.0 * tag.pose.x, 1000.0 * tag.pose.y])
        origin = middle - place if origin is None else origin
        assert np.abs(middle - place - origin).max() < TOLERANCE
        axis = corners[1] - corners[0]
        turn = np.arctan2(axis[1], axis[0]) - tag.pose.theta
        assert abs(np.sin(turn)) < 0.003
        assert np.cos(turn) > 0.0


def test_sheets_of_the_floor_say_where_they_lie_and_hold_every_tag(tmp_path, scene) -> None:
    cut, sheets = tiling(scene, "a3"), area_sheets(scene, "a3")
    assert len(cut.tiles) == len(sheets)
    whole = set()
    for number, (tile, sheet) in enumerate(zip(cut.tiles, sheets, strict=True)):
        for tag in find_tags(rendered(tmp_path, sheets, number)):
            (drawn,) = (t for t in placed_tags(scene) if t.number == tag.tag_id)
            middle = on_sheet(tag.corners_image, sheet).mean(axis=0) - MARGIN + (tile.x, tile.y)
            assert np.abs(middle - 1000.0 * np.array([drawn.pose.x, drawn.pose.y])).max() < TOLERANCE
            whole.add(tag.tag_id)
    assert len(whole) >= 3  # the others are cut by a sheet's border


def test_pages_have_the_size_of_the_paper(tmp_path, scene) -> None:
    write_pdf(tmp_path / "plan.pdf", [plan_sheet(scene, "a4", "test")], "test")
    width, height = pdfium.PdfDocument(tmp_path / "plan.pdf")[0].get_size()
    assert (width, height) == pytest.approx((297.0 / 25.4 * 72.0, 210.0 / 25.4 * 72.0), abs=0.05)


def test_plan_tells_boards_and_tags(tmp_path, scene) -> None:
    write_pdf(tmp_path / "plan.pdf", [plan_sheet(scene, "a4", "test")], "test")
    text = pdfium.PdfDocument(tmp_path / "plan.pdf")[0].get_textpage().get_text_range()
    assert "Floor tags 300 to 305" in text
    assert "board 1" in text
    assert "2 rows along x of 3, 0.15 m apart" in text


def test_same_area_gives_the_same_bytes(tmp_path, scene) -> None:
    for name in ("one.pdf", "two.pdf"):
        write_pdf(tmp_path / name, board_sheets(scene.boards, "a4"), "test")
    assert (tmp_path / "one.pdf").read_bytes() == (tmp_path / "two.pdf").read_bytes()


def test_board_too_large_for_the_paper_is_refused_with_the_cure() -> None:
    boards = mixed_boards(1, BoardSpec(9, 6, 0.035))
    with pytest.raises(InputError, match="Take a3"):
        board_sheets(boards, "a4")
    assert len(board_sheets(boards, "a3")) == 1


def test_unknown_paper_writes_nothing(tmp_path) -> None:
    done = CliRunner().invoke(app, ["targets", "--paper", "letter", "--out", str(tmp_path / "t")])
    assert done.exit_code == 2
    assert not (tmp_path / "t").exists()


def test_command_writes_every_file_of_a_small_area(tmp_path) -> None:
    small = tmp_path / "small.yaml"
    small.write_text(
        "name: small\nscene:\n  boards: {count: 1}\n  field: {rows: 1, columns: 2}\n"
        "  road: {markers: 1, length: 1.6}\n"
    )
    done = CliRunner().invoke(app, ["targets", str(small), "--out", str(tmp_path / "t")])
    assert done.exit_code == 0, done.output
    names = {path.name for path in (tmp_path / "t").iterdir()}
    assert names == {"plan.pdf", "boards.pdf", "tags.pdf", "area.pdf", "poster.pdf"}
    assert "1 page " in done.output
