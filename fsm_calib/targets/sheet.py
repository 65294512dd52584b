"""A sheet of paper and what is on it: filled shapes, lines and words at true scale [mm].

The origin is the sheet's lower left corner, x to the right, y up. All black cells of a pattern are one shape, so that
no renderer leaves hair lines where cells meet.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from fsm_calib.errors import InputError

Point = tuple[float, float]
Outline = tuple[Point, ...]

PAPERS: dict[str, tuple[float, float]] = {"a4": (210.0, 297.0), "a3": (297.0, 420.0)}
"""Width and height of upright sheets [mm], ISO 216."""
MARGIN = 8.0
"""Border of a sheet that printers leave white [mm]; common ones need 4 to 6."""


@dataclass(frozen=True, slots=True)
class Shape:
    """Closed outlines that are filled together, or drawn where `fill` is empty; `width` of the line [mm]."""

    outlines: tuple[Outline, ...]
    fill: str = "black"
    edge: str = ""
    width: float = 0.0


@dataclass(frozen=True, slots=True)
class Line:
    """A line through points; `dash` as lengths of ink and gap [mm], or empty."""

    points: tuple[Point, ...]
    width: float = 0.2
    colour: str = "black"
    dash: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class Words:
    """Text whose base line begins, centres or ends at (x, y); `size` of the letters [mm]; `turn` [deg]."""

    x: float
    y: float
    text: str
    size: float = 3.0
    anchor: str = "left"
    colour: str = "black"
    turn: float = 0.0


@dataclass(eq=False)
class Sheet:
    """One page, `width` by `height` [mm], and what is on it in the order of drawing."""

    width: float
    height: float
    content: list[Shape | Line | Words] = field(default_factory=list)


def paper_size(name: str, *, wide: bool = False) -> tuple[float, float]:
    """Return width and height of a sheet [mm], lying when `wide`.

    Raises
    ------
    InputError
        A paper that is not known.
    """
    if name.lower() not in PAPERS:
        raise InputError(f"there is no paper {name!r}", where="--paper", cure=f"Give {' or '.join(PAPERS)}.")
    width, height = PAPERS[name.lower()]
    return (height, width) if wide else (width, height)


def rectangle(x: float, y: float, width: float, height: float) -> Outline:
    """Return the outline of a rectangle with its lower left corner at (x, y) [mm], counter-clockwise."""
    return ((x, y), (x + width, y), (x + width, y + height), (x, y + height))


def draw_ruler(sheet: Sheet, x: float, y: float, length: int, *, upright: bool = False) -> None:
    """Draw a ruler of `length` [mm] from (x, y) along x, or along y when `upright`, its ticks to the inside."""

    def at(along: float, across: float) -> Point:
        return (x + across, y + along) if upright else (x + along, y + across)

    walk: list[Point] = []  # along the ruler, up and down every tick: one line in place of hundreds
    for tick in range(length + 1):
        reach = 3.5 if tick % 10 == 0 else 2.5 if tick % 5 == 0 else 1.5
        walk += [at(tick, 0.0), at(tick, reach), at(tick, 0.0)]
    sheet.content.append(Line(tuple(walk), 0.1))
    for tick in range(0, length + 1, 50):
        place = at(tick, 4.2)
        sheet.content.append(Words(*place, str(tick), 2.2, "left" if upright else "middle"))
