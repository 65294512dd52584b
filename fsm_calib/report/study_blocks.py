"""What a study's report is made of, whether it becomes a web page, Markdown or text: sections of blocks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True)
class Paragraph:
    """A few sentences."""

    text: str


@dataclass(frozen=True, slots=True)
class Table:
    """A table: the header and its rows, all text; the first column names the row."""

    header: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True, slots=True)
class Plot:
    """A figure: its file's name, what it shows in a sentence, and who draws it."""

    name: str
    caption: str
    draw: Callable[[], Figure]


Block = Paragraph | Table | Plot


@dataclass(frozen=True, slots=True)
class Part:
    """A titled part of a report."""

    title: str
    blocks: Sequence[Block]


@dataclass(frozen=True, slots=True)
class Content:
    """A whole report: title, a sentence that says what it is, parts."""

    title: str
    lead: str
    parts: Sequence[Part]

    def text(self) -> str:
        """Return paragraphs and tables as plain text for a terminal."""
        lines = [self.title, self.lead]
        for part in self.parts:
            blocks = [block for block in part.blocks if not isinstance(block, Plot)]
            if blocks:
                lines += ["", part.title, *(_plain(block) for block in blocks)]
        return "\n".join(lines)


def _plain(block: Paragraph | Table) -> str:
    if isinstance(block, Paragraph):
        return f"  {block.text}"
    table = [list(block.header), *(list(row) for row in block.rows)]
    widths = [max(len(row[column]) for row in table) for column in range(len(block.header))]
    lines = ("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in table)
    return "\n".join(f"  {line}" for line in lines)


def markdown_table(table: Table) -> str:
    """Return a table in Markdown."""
    rows = [table.header, ["---"] * len(table.header), *table.rows]
    return "\n".join(f"| {' | '.join(cell.replace('|', '/') for cell in row)} |" for row in rows)
