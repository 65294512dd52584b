"""Writes a study's report: one HTML page, figures as PNG, the figures' numbers as JSON, a section of a page."""

from __future__ import annotations

import json
import math
import re
import textwrap
from collections.abc import Mapping
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import yaml
from markupsafe import Markup

from fsm_calib.journal import plain, write_atomically
from fsm_calib.report import pages
from fsm_calib.report.run_style import svg
from fsm_calib.report.study_blocks import Block, Content, Paragraph, Plot, Table, markdown_table
from fsm_calib.report.study_content import content_of, settings_of
from fsm_calib.study.fleet import COMMANDS_NAME, CommandCost
from fsm_calib.study.summary import Summary

TEMPLATE = "study.html.j2"
REPORT_NAME = "report.html"
SUMMARY_NAME = "study.json"
DOTS_PER_INCH = 100
"""Resolution of the figures beside a Markdown page."""
LINE_WIDTH = 118
"""Longest line of text in a Markdown page [characters]."""


def write_study(directory: Path, summary: Summary) -> Content:
    """Write ``report.html`` and ``study.json`` into a study's directory and return the report's content."""
    content = content_of(summary, costs_in(directory))
    write_atomically(directory / REPORT_NAME, html_of(content, summary).encode())
    numbers = json.dumps(plain(_numbers(summary)), indent=2, ensure_ascii=False) + "\n"
    write_atomically(directory / SUMMARY_NAME, numbers.encode())
    return content


def costs_in(directory: Path) -> list[CommandCost]:
    """Return what the commands did that worked in a study's directory."""
    path = directory / COMMANDS_NAME
    if not path.exists():
        return []
    names = {field.name for field in fields(CommandCost)}
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    return [CommandCost(**{name: value for name, value in line.items() if name in names}) for line in lines]


def html_of(content: Content, summary: Summary) -> str:
    """Return the report as one HTML page that opens offline."""
    environment = pages.environment()
    environment.tests["table"] = lambda block: isinstance(block, Table)
    environment.tests["plot"] = lambda block: isinstance(block, Plot)
    environment.filters["drawn"] = lambda block: Markup(svg(block.draw(), block.name))
    text = environment.get_template(TEMPLATE).render(content=content, settings=settings_text(summary))
    return pages.finished(text)


def settings_text(summary: Summary) -> str:
    """Return every setting of the study as YAML."""
    return yaml.safe_dump(settings_of(summary), sort_keys=False, allow_unicode=True)


def write_page(page: Path, summary: Summary, directory: Path, command: str) -> None:
    """Renew the section of this study in a Markdown page, and its figures beside the page.

    The section stands between two comments with the study's name; a page without them gets them at its end.
    """
    content = content_of(summary, costs_in(directory))
    folder = page.parent / page.stem
    folder.mkdir(parents=True, exist_ok=True)
    text = _section(content, summary.study.name, folder, command)
    before = page.read_text("utf-8") if page.exists() else ""
    write_atomically(page, replaced(before, summary.study.name, text).encode())


def replaced(page: str, name: str, text: str) -> str:
    """Return a page with the section of the study `name` replaced by `text`, or with it at the end."""
    begin, end = f"<!-- study {name} -->", f"<!-- end of study {name} -->"
    section = f"{begin}\n{text}\n{end}"
    pattern = re.compile(re.escape(begin) + ".*?" + re.escape(end), re.S)
    if pattern.search(page):
        return pattern.sub(lambda _: section, page)
    return f"{page.rstrip()}\n\n{section}\n".lstrip()


def _section(content: Content, name: str, folder: Path, command: str) -> str:
    """Return a study as Markdown, its figures drawn into `folder`."""
    lines = [f"## {content.title}", "", content.lead, "", f"    {command}", ""]
    for part in content.parts:
        lines += [f"### {part.title}", ""]
        for block in part.blocks:
            lines += [_markdown(block, name, folder), ""]
    return "\n".join(lines).rstrip()


def _markdown(block: Block, name: str, folder: Path) -> str:
    if isinstance(block, Paragraph):
        return textwrap.fill(block.text, LINE_WIDTH, break_long_words=False, break_on_hyphens=False)
    if isinstance(block, Table):
        return markdown_table(block)
    path = folder / f"{name}_{block.name}.png"
    block.draw().savefig(path, dpi=DOTS_PER_INCH, facecolor="white", metadata={"Software": None})
    return f"![{block.caption}]({folder.name}/{path.name})"


def _numbers(summary: Summary) -> Mapping[str, Any]:
    """Return the summary's figures as plain values; what is not finite is left out."""
    left_out = ("study", "rows", "variants")
    numbers: dict[str, Any] = {
        item.name: getattr(summary, item.name) for item in fields(summary) if item.name not in left_out
    }
    numbers["variants"] = {item.variant.name: item for item in summary.variants}
    numbers["study"] = {"name": summary.study.name, "seed": summary.study.seed}
    return {name: _plain(value) for name, value in numbers.items()}


def _plain(value: Any) -> Any:
    if hasattr(value, "__dataclass_fields__"):
        return _plain(asdict(value))
    if isinstance(value, Mapping):
        return {name: _plain(item) for name, item in value.items()}
    if isinstance(value, tuple | list):
        return [_plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
