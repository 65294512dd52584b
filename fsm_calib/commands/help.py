"""How a group of commands lists them: each with the whole first paragraph of its help, which Typer would cut."""

from __future__ import annotations

from typing import Any

from typer.core import TyperGroup


class WholeSentences(TyperGroup):
    """A group of commands whose help cuts no sentence."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """List the commands, each with its whole first sentence."""
        named = [(name, self.get_command(ctx, name)) for name in self.list_commands(ctx)]
        rows = [
            (name, _first_sentence(found.help or "")) for name, found in named if found and not found.hidden
        ]
        with formatter.section("Commands"):
            formatter.write_dl(rows)


def _first_sentence(text: str) -> str:
    """Return the first paragraph of a help text as one line."""
    return " ".join(text.strip().split("\n\n")[0].split())
