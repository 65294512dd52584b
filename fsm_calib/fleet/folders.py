"""Which recordings belong to which robot, by where they lie."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from fsm_calib.errors import InputError
from fsm_calib.recording.places import (
    BAG_SUFFIXES,
    MANIFEST_END,
    MANIFEST_NAME,
    is_bag,
    is_bag_or_manifest,
    manifest_in,
    recordings_in,
)


@dataclass(frozen=True, slots=True)
class RobotFiles:
    """One robot: its name, of which none is given twice, and its recordings."""

    name: str
    recordings: tuple[Path, ...]

    @property
    def stamp(self) -> list[list[str | int]]:
        """Name, size [bytes] and time of change [ns] of every file behind the recordings: another stamp, other data."""
        files = sorted({file for path in self.recordings for file in _behind(path)})
        return [[str(f.resolve()), f.stat().st_size, f.stat().st_mtime_ns] for f in files]


def robots_in(places: Iterable[str | Path]) -> list[RobotFiles]:
    """Return the robots at some places: a recording, or a folder that holds recordings itself, is one robot; in any
    other folder each folder is one, with every recording below it.

    Raises
    ------
    InputError
        Nothing is there, or no recording is.
    """
    found: list[tuple[Path, tuple[Path, ...]]] = []
    for place in map(Path, places):
        here = list(_robots_at(place))
        if not here:
            cure = "Give bags, manifests, folders with them, or a folder of such folders."
            raise InputError("no recording is there", where=str(place), cure=cure)
        found += here
    names: list[str] = []
    for path, _ in found:
        names.append(_new_name(path, names))
    return [RobotFiles(name, recordings) for name, (_, recordings) in zip(names, found, strict=True)]


def _robots_at(place: Path) -> Iterator[tuple[Path, tuple[Path, ...]]]:
    named = place.with_name(place.name + MANIFEST_END) if place.name else place
    if place.is_file() or _is_recording(place):
        yield place, (place,)
    elif not place.exists() and named.is_file():
        yield place, (named,)
    elif place.is_dir():
        if direct := tuple(recordings_in(place)):
            yield place, direct
            return
        for folder in sorted(path for path in place.iterdir() if path.is_dir()):
            if below := tuple(_below(folder)):
                yield folder, below


def _below(folder: Path) -> Iterator[Path]:
    """Yield the recordings in a folder and in those below it; links to folders are not followed."""
    if _is_recording(folder):
        yield folder
        return
    for path in sorted(folder.iterdir()):
        if is_bag_or_manifest(path):
            yield path
        elif path.is_dir() and not path.is_symlink():
            yield from _below(path)


def _is_recording(path: Path) -> bool:
    return path.is_dir() and (is_bag(path) or manifest_in(path) is not None)


def _behind(path: Path) -> Iterator[Path]:
    """Yield the files that a recording may be read from: a bag's own, a manifest's whole folder."""
    if path.is_file() and path.suffix in BAG_SUFFIXES:
        yield path
        return
    folder = path if path.is_dir() else path.parent
    yield from (file for file in folder.iterdir() if file.is_file())


def _new_name(path: Path, taken: list[str]) -> str:
    """Return a name for the robot at `path` that may name a file and that no other has."""
    plain = path.resolve()
    word = plain.name.removesuffix(MANIFEST_END)
    word = plain.parent.name if word == MANIFEST_NAME else word
    word = word.removesuffix(plain.suffix) if plain.suffix in BAG_SUFFIXES else word
    word = (
        "".join(letter if letter.isalnum() or letter in "._=-" else "_" for letter in word).lstrip(".")
        or "robot"
    )
    name, number = word, 2
    while name in taken:
        name, number = f"{word}-{number}", number + 1
    return name
