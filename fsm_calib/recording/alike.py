"""Do recordings belong together? One robot in a call; nothing that is fitted is also judged on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path

from fsm_calib.errors import InputError
from fsm_calib.recording.recording import Recording, RobotFacts

SAME_SHARE = 0.02  # stated lengths of one robot differ by no more than this: nobody states an axle better
UNNAMED = RobotFacts().name


def robot_warnings(recordings: Sequence[Recording]) -> list[str]:
    """Return a sentence for every fact in which the recordings' manifests state different robots."""
    said = []
    names = {r.robot.name: r for r in reversed(recordings) if r.robot.name != UNNAMED}
    if len(names) > 1:
        said.append(_apart("names", sorted(names)))
    for fact in fields(RobotFacts):
        stated = {v for r in recordings if isinstance(v := getattr(r.robot, fact.name), float | int)}
        if stated and max(stated) - min(stated) > SAME_SHARE * abs(max(stated)):
            said.append(_apart(f"values of {fact.name}", [f"{v:g}" for v in sorted(stated)]))
    return said


def _apart(what: str, values: Sequence[str]) -> str:
    return (
        f"two different robots? The recordings state different {what}: {', '.join(values)}. They are fitted as one "
        "robot; give each robot its own call"
    )


def refuse_shared(fitted: Sequence[Recording], held_out: Sequence[Recording]) -> None:
    """Refuse a recording that is both fitted and held out: it would prove itself.

    Raises
    ------
    InputError
        One is, by its file or by its numbers.
    """
    for new in held_out:
        for old in fitted:
            if _file(new) == _file(old) or (new.channels and new == old):
                raise InputError(
                    "the recording is fitted and held out at once: it would prove itself",
                    where=new.source or "--holdout",
                    cure="Hold out a recording that is not fitted.",
                )


def _file(recording: Recording) -> object:
    return Path(recording.source).resolve() if recording.source else id(recording)
