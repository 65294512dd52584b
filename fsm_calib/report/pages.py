"""What all pages have in common: one style, a table of contents, figures and tables that scroll inside the page.

A page is one file without links to other places: it opens offline, on a phone, at night, and prints.
"""

from __future__ import annotations

import re
from typing import Any

import jinja2

SECTION = re.compile(r"<section([^>]*)>\s*<h2>(.*?)</h2>", re.DOTALL)
FIGURE = re.compile(r'<svg\b[^>]*\brole="img"[^>]*>.*?</svg>', re.DOTALL)
VIEW_BOX = re.compile(r'viewBox="[\d.]+ [\d.]+ ([\d.]+) [\d.]+"')
TABLE = re.compile(r"<table.*?</table>", re.DOTALL)
WIDE = 400.0
"""Figures drawn wider than this [px] scroll inside the page on a phone, so that words stay readable; others shrink."""
FEWEST_CONTENTS = 4
"""Pages with fewer sections need no table of contents."""


def environment() -> jinja2.Environment:
    """Return what renders the templates of this room; they may include each other and `page.css`."""
    loader = jinja2.PackageLoader("fsm_calib", "report")
    return jinja2.Environment(
        loader=loader, autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True
    )


def page(template: str, **values: Any) -> str:
    """Return a template with its values as a finished page."""
    return finished(environment().get_template(template).render(**values))


def finished(html: str) -> str:
    """Return a page with a table of contents behind its header, and with what is wide scrolling inside the page."""
    html = FIGURE.sub(_figure, html)
    html = TABLE.sub(lambda found: f'<div class="scroll">{found[0]}</div>', html)
    titles: list[tuple[str, str]] = []

    def numbered(found: re.Match[str]) -> str:
        title = re.sub(r"<[^>]*>", "", found[2]).strip()
        slug = re.sub(r"\W+", "-", title.lower()).strip("-") or "part"
        slug = slug if all(slug != known for known, _ in titles) else f"{slug}-{len(titles)}"
        titles.append((slug, title))
        return f'<section id="{slug}"{found[1]}><h2>{found[2]}</h2>'

    html = SECTION.sub(numbered, html)
    if len(titles) < FEWEST_CONTENTS:
        return html
    links = "".join(f'<a href="#{slug}">{title}</a>' for slug, title in titles)
    return html.replace(
        "</header>", f'</header>\n<nav class="contents" aria-label="contents">{links}</nav>', 1
    )


def beside(*figures: str) -> str:
    """Return figures beside each other, below each other where a page is narrow."""
    return f'<div class="pair">{"".join(f"<div>{figure}</div>" for figure in figures)}</div>'


def _figure(found: re.Match[str]) -> str:
    """Return a figure, when it is wide in a box of its own that knows how wide it was drawn."""
    box = VIEW_BOX.search(found[0])
    if box is None or float(box[1]) <= WIDE:
        return found[0]
    return f'<div class="wide" style="--width: {float(box[1]):.0f}px">{found[0]}</div>'
