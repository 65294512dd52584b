"""What a robot's description says: wheel radius, axle length, mass and inertia from a URDF or SDF file.

Wheels are links whose names say wheel and left or right; their radius is that of a cylinder or sphere, their distance
that of the places of the joints (URDF) or links (SDF), rotations between them left aside. A differential drive's plugin
says both too; it wins, because the robot's own controller uses it. Documents with declarations of types or entities are
refused: nothing is expanded.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from fsm_calib.errors import InputError
from fsm_calib.recording.recording import LARGEST_FACT, RobotFacts

LARGEST_FILE = 5_000_000  # bytes; descriptions have some ten thousand, meshes lie beside them
SEPARATION = ("wheel_separation", "wheelSeparation", "wheel_track")
RADIUS = ("wheel_radius", "wheelRadius")
DIAMETER = ("wheel_diameter", "wheelDiameter")
SIDES = ("left", "right")
Place = tuple[float, float, float]


@dataclass(frozen=True)
class Link:
    """A link: name, place on the robot [m], mass [kg], its own yaw inertia [kg m2], radius of its cylinder [m]."""

    name: str
    place: Place
    mass: float
    inertia: float
    radius: float | None


def read_robot_file(path: Path) -> RobotFacts:
    """Read a URDF or SDF file.

    Raises
    ------
    InputError
        It is missing, no XML, declares entities, is an unexpanded xacro, or says nothing of wheels or mass.
    """
    root = _parsed(path)
    urdf = root.tag == "robot"
    model = root if urdf else root.find(".//model")
    if model is None:
        raise InputError("neither a URDF (<robot>) nor an SDF (<model>)", where=f"{path}:1")
    try:
        links = list(_urdf_links(model) if urdf else _sdf_links(model))
        facts = _facts(str(model.get("name") or "robot"), links, root)
    except (ValueError, IndexError) as error:
        raise InputError(
            f"a number of the description cannot be read: {error}",
            where=f"{path}:1",
            cure="Expand a xacro first: xacro robot.urdf.xacro > robot.urdf",
        ) from error
    if facts.wheel_radius is None and facts.axle_length is None and facts.mass is None:
        raise InputError("the description names no wheels and no mass", where=f"{path}:1")
    return facts


def with_facts(stated: RobotFacts, described: RobotFacts) -> RobotFacts:
    """Return what is stated, and what a description says where nothing is."""
    missing = {
        k: getattr(described, k) for k in RobotFacts.__dataclass_fields__ if getattr(stated, k) is None
    }
    name = described.name if stated.name == RobotFacts().name else stated.name
    return replace(stated, **missing, name=name)


def _parsed(path: Path) -> ElementTree.Element:
    try:
        data = path.read_bytes()
    except OSError as error:
        raise InputError(f"cannot read the robot's description: {error.strerror}", where=str(path)) from error
    if len(data) > LARGEST_FILE:
        raise InputError("the robot's description is larger than 5 MB", where=f"{path}:1")
    try:
        text = data.decode("utf-8-sig")
        if "<!DOCTYPE" in text or "<!ENTITY" in text:
            raise InputError(
                "the robot's description declares types or entities, which are not expanded",
                where=f"{path}:1",
            )
        return ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError, RecursionError) as error:
        raise InputError(f"the robot's description is no XML: {error}", where=f"{path}:1") from error


def _number(text: str) -> float:
    value = float(text)
    if not abs(value) < LARGEST_FACT:
        raise ValueError(f"{text!r}, and no robot has {LARGEST_FACT:g} m or kg")
    return value


def _numbers(text: str | None, count: int) -> list[float]:
    values = [_number(part) for part in (text or "0 " * count).split()]
    if len(values) < count:
        raise ValueError(f"{text!r}")
    return values


def _positive(text: str | None) -> float | None:
    if text is None or not text.strip():
        return None
    value = _number(text)
    if value <= 0.0:
        raise ValueError(f"{text!r}")
    return value


def _mass(text: str | None) -> float:
    value = _number(text or "0")
    if value < 0.0:
        raise ValueError(f"a mass of {text!r}")
    return value


def _place(element: ElementTree.Element | None) -> Place:
    x, y, z = _numbers(element.get("xyz") if element is not None else None, 3)[:3]
    return x, y, z


def _urdf_links(robot: ElementTree.Element) -> Iterator[Link]:
    parents = {}
    for joint in robot.findall("joint"):
        parent, child = joint.find("parent"), joint.find("child")
        if parent is not None and child is not None:
            parents[child.get("link")] = (parent.get("link"), _place(joint.find("origin")))
    for link in robot.findall("link"):
        x, y, z = 0.0, 0.0, 0.0
        name: str | None = link.get("name")
        for _ in range(len(parents) + 1):  # a description that goes in circles ends here
            if name not in parents:
                break
            name, (dx, dy, dz) = parents[name]
            x, y, z = x + dx, y + dy, z + dz
        mass, about = link.find("inertial/mass"), link.find("inertial/inertia")
        shapes = [s.get("radius") for tag in ("cylinder", "sphere") for s in link.iter(tag)]
        yield Link(
            link.get("name") or "",
            (x, y, z),
            _mass(mass.get("value")) if mass is not None else 0.0,
            _number(about.get("izz", "0")) if about is not None else 0.0,
            _positive(shapes[0]) if shapes else None,
        )


def _sdf_links(model: ElementTree.Element) -> Iterator[Link]:
    for link in model.findall("link"):
        x, y, z = _numbers(link.findtext("pose"), 3)[:3]
        radius = link.findtext(".//cylinder/radius") or link.findtext(".//sphere/radius")
        mass, izz = link.findtext("inertial/mass"), link.findtext("inertial/inertia/izz")
        yield Link(link.get("name") or "", (x, y, z), _mass(mass), _number(izz or "0"), _positive(radius))


def _facts(name: str, links: Sequence[Link], root: ElementTree.Element) -> RobotFacts:
    sides = [[k for k in links if "wheel" in k.name.lower() and _side(k.name) == side] for side in SIDES]
    radius = axle = None
    if all(sides):
        radii = [k.radius for side in sides for k in side if k.radius]
        radius = sum(radii) / len(radii) if radii else None
        left, right = (sum(k.place[1] for k in side) / len(side) for side in sides)
        axle = abs(left - right) or None
    diameter = _first(root, DIAMETER)
    mass = sum(k.mass for k in links)
    return RobotFacts(
        name=name,
        wheel_radius=_first(root, RADIUS) or (0.5 * diameter if diameter else radius),
        axle_length=_first(root, SEPARATION) or axle,
        mass=mass if mass > 0.0 else None,
        inertia=_yaw_inertia(links, mass) if mass > 0.0 else None,
    )


def _side(name: str) -> str | None:
    words = name.lower().replace("-", "_").split("_")
    for side in SIDES:
        if side in name.lower() or any(word in (side[0], f"f{side[0]}", f"r{side[0]}") for word in words):
            return side
    return None


def _first(root: ElementTree.Element, names: Sequence[str]) -> float | None:
    for name in names:
        for element in root.iter(name):
            return _positive(element.text)
    return None


def _yaw_inertia(links: Sequence[Link], mass: float) -> float | None:
    """Return the inertia about the vertical through the centre of mass [kg m2], by the parallel axes."""
    cx, cy = (sum(k.mass * k.place[i] for k in links) / mass for i in range(2))
    total = sum(k.inertia + k.mass * ((k.place[0] - cx) ** 2 + (k.place[1] - cy) ** 2) for k in links)
    return total if total > 0.0 else None
