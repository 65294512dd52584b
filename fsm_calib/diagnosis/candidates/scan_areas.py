"""Areas on the floor as candidates of a scan: where they could lie, what they would do, how to move them uphill."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import astuple, dataclass, replace

import numpy as np

from fsm_calib.diagnosis.replay.robot_size import robot_size
from fsm_calib.diagnosis.replay.situation import Situation
from fsm_calib.diagnosis.shapes.features import body_columns, cells_about
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import Effect

RADII = (0.15, 0.25)  # m: the span of spots, mats and markers that a small robot crosses
WIDE_RADII = (0.4, 0.65)  # m, of rugs and lawns, at a pitch of half of each
STRIPS = (0.08, 0.2)  # m, half widths
STRIP_PITCH = 0.12  # m
LONG = 5.0  # m, half length of a strip: beyond any arena of a small robot
SETTLE_STEPS = (0.05, 0.025, 0.0125)  # m, by which centre and edges are moved
ROUNDS = 3  # moves tried at each step
SMALLEST = 0.04  # m, half size


@dataclass(frozen=True, slots=True)
class Area:
    """A box (or the ellipse in it) on the floor: centre, half sizes [m]; `spread` 1 felt by wheels, 0 by the middle."""

    x: float
    y: float
    half_x: float
    half_y: float
    spread: float = 0.0
    roundness: float = 1.0

    def numbers(self, effect: Effect) -> dict[str, float]:
        """Return the area in the words of an effect's parameters, by full name; of a disc: its mean radius."""
        sizes = {"half_x": self.half_x, "half_y": self.half_y}
        if effect.where == "disc":
            sizes = {"radius": min(0.5 * (self.half_x + self.half_y), effect.parameter("radius").high)}
        return {f"{effect.name}.{name}": value for name, value in {"x": self.x, "y": self.y, **sizes}.items()}

    @property
    def is_strip(self) -> bool:
        """Return whether one side is as long as the arena."""
        return max(self.half_x, self.half_y) >= LONG

    def is_like(self, other: Area, size: float = 1.0) -> bool:
        """Return whether both came to the same place, as `settled` moves them for a robot of this size."""
        pairs = zip(astuple(self), astuple(other), strict=True)
        return all(abs(a - b) < size * SETTLE_STEPS[0] for a, b in pairs)

    def holds(self, x: FloatArray, y: FloatArray) -> FloatArray:
        """Return 1 inside and 0 outside, shape of x and y [m]."""
        dx, dy = np.abs(x - self.x) / self.half_x, np.abs(y - self.y) / self.half_y
        reach = np.hypot(dx, dy) if self.roundness > 0.5 else np.maximum(dx, dy)
        return (reach < 1.0).astype(float)


Judge = Callable[[Sequence[Area]], FloatArray]


def boxes(centres: FloatArray, size: float = 1.0) -> list[Area]:
    """Return squares of several sizes around centres (m, 2) [m], `size` times those of a small robot."""
    return [box for radius in RADII for box in _squares(size * radius, centres)]


def wide_boxes(centres: FloatArray, size: float = 1.0) -> list[Area]:
    """Return wide squares about centres (m, 2) [m], `size` times those of a small robot."""
    halves = [size * radius for radius in WIDE_RADII]
    return [box for half in halves for box in _squares(half, cells_about(centres, 0.5 * half))]


def _squares(half: float, centres: FloatArray) -> Iterator[Area]:
    """Yield a square of half a side [m] about each of some centres (m, 2) [m]."""
    for x, y in centres.tolist():
        yield Area(x, y, half, half, roundness=0.0)


def strips(situations: Sequence[Situation]) -> list[Area]:
    """Return strips along both axes over the visited floor."""
    found, size = [], robot_size(situations[0].half)
    for half in (size * width for width in STRIPS):
        for at in _line([s.x for s in situations], size):
            found.append(Area(float(at), 0.0, half, size * LONG, roundness=0.0))
        for at in _line([s.y for s in situations], size):
            found.append(Area(0.0, float(at), size * LONG, half, roundness=0.0))
    return found


def _line(tracks: Sequence[FloatArray], size: float) -> FloatArray:
    low, high = min(float(t.min()) for t in tracks), max(float(t.max()) for t in tracks)
    return np.arange(low, high, size * STRIP_PITCH)


def settled(area: Area, judge: Judge, size: float = 1.0) -> tuple[Area, float]:
    """Move and resize an area while that promises more, by steps `size` times a small robot's; return its promise."""
    best, gain = area, float(judge([area])[0])
    for step in (size * step for step in SETTLE_STEPS):
        for _ in range(ROUNDS):
            tried = list(neighbours(best, step))
            promise = judge(tried)
            i = int(np.argmax(promise))
            if promise[i] <= gain:
                break
            best, gain = tried[i], float(promise[i])
    return best, gain


def neighbours(area: Area, step: float) -> Iterator[Area]:
    """Yield the area moved, resized, of the other form, and felt at the other place."""
    for dx in (-step, 0.0, step):
        for dy in (-step, 0.0, step):
            yield replace(area, x=area.x + dx, y=area.y + dy)
    for change in (-step, step):
        half_x, half_y = max(area.half_x + change, SMALLEST), max(area.half_y + change, SMALLEST)
        yield replace(area, half_x=half_x, half_y=half_y)
        if area.roundness < 0.5:
            yield replace(area, half_x=half_x)
            yield replace(area, half_y=half_y)
    yield replace(area, spread=1.0 - area.spread)
    if not area.is_strip:
        half = 0.5 * (area.half_x + area.half_y)
        yield replace(area, roundness=1.0 - area.roundness, half_x=half, half_y=half)


def drag_columns(s: Situation, areas: Sequence[Area]) -> FloatArray:
    """Return increments (n, 5, areas) of a unit loss of rim speed on each side that stands in an area."""
    loss = np.zeros((2, len(s.dt), len(areas)))
    felt = {
        spread: [_felt(s, sign * s.half * spread) for sign in (1.0, -1.0)]
        for spread in {a.spread for a in areas}
    }
    for i, area in enumerate(areas):
        for side, (x, y, against) in enumerate(felt[area.spread]):
            loss[side, :, i] = area.holds(x, y) * against
    spread = np.array([area.spread for area in areas])
    return body_columns(
        s, forward=0.5 * (loss[0] + loss[1]), turn=0.5 * spread * (loss[1] - loss[0]) / s.half
    )


def _felt(s: Situation, arm: float) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return where a point `arm` [m] to the left of the axle's middle is, x, y [m], and which way a drag slows it."""
    x, y = s.x - arm * np.sin(s.heading), s.y + arm * np.cos(s.heading)
    return x, y, -np.tanh((s.v - arm * s.omega) / 0.02)
