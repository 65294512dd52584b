"""The page of effects is current, and each effect has its picture."""

from pathlib import Path

from fsm_calib.world2d.effects import registry
from fsm_calib.world2d.effects.page import page

DOCS = Path(__file__).parent.parent / "docs"


def test_page_is_what_the_catalogue_says():
    assert (DOCS / "effects.md").read_text(encoding="utf-8") == page(), (
        "run python3 benchmarks/effects_page.py"
    )


def test_every_effect_has_its_picture():
    assert {p.stem for p in (DOCS / "effects").glob("*.png")} == set(registry())
