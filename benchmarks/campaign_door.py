"""Damaged input through the door that a user takes: a command's exit code, its words, and what it leaves behind."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable
from pathlib import Path

from campaign_case import Wrong
from campaign_children import command, started
from campaign_hazards import expect_sentence

from fsm_calib.errors import InputError

LONGEST_COMMAND = 120.0  # s by the clock, which a busy machine needs many times as long for


def through(*words: str) -> Callable[[Path], object]:
    """Return who gives what is in a folder to `fsm-calib WORDS`, in a child of this process.

    `{folder}` in a word is the folder, `{out}` a new one for results. Right is exit code 0, with results that are whole;
    or 1 or 2, with a sentence and no results.
    """

    def answer(folder: Path) -> None:
        with tempfile.TemporaryDirectory(dir=folder.parent) as name:
            out = Path(name) / "out"
            out.mkdir()
            arguments = [word.format(folder=folder, out=out) for word in words]
            child = started(command(arguments), Path(name) / "log").wait(LONGEST_COMMAND)
            expect_sentence(child, (0, 1, 2))
            _expect_whole(out, child.code or 0)
            if child.code:
                said = child.stderr().partition("fsm-calib:")[2].strip().partition("\n")[0]
                raise InputError(said.removesuffix("."))

    return answer


def _expect_whole(out: Path, code: int) -> None:
    """Demand that a command that failed has written nothing, and that what another one has written can be read."""
    written = sorted(out.rglob("*"))
    if code and written:
        raise Wrong(f"exit code {code}, and {written[0].name} was written")
    for path in written:
        if path.suffix == ".json":
            json.loads(path.read_text())
