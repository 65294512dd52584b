r"""Where is the marker that lies wrong on the map? A matched filter on the jumps of the measured poses.

A misplaced marker shows in a few frames only: the pose jumps where the robot enters the disc in which it is seen, and
back where it leaves. Between two frames k - 1 and k the jump is

    e_k = (c_k - c_(k-1)) - (what the base robot moved)          c_k = inside_k (shift + rigid turn perp(r_k), turn)

e_k [m, m, rad] in world axes, r_k [m] the place seen from the disc's centre, rigid 1, or 0 of headings alone. A
board that counts only while the robot looks its way is entered and left by turning, too. For a
disc, turn and shift are linear, and least squares over the frames with their robust spread tells what they would win.
The edge must be right to a frame or two: 8 mm beside the truth a disc may promise a quarter of what it does there
(measured, poses at 30 Hz). A first look at a grid of discs therefore takes jumps over the time in which the robot
travels from one disc to the next; the best then move and resize by what jumps from a frame before to a frame after
the crossing tell. The centre need not have been visited. The spread is a median of all frames: the fitted noise has
swallowed the jumps, and would hide them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numba import njit

from fsm_calib.diagnosis.candidates.distinct import apart
from fsm_calib.diagnosis.candidates.scan_areas import Area
from fsm_calib.diagnosis.replay.prepared import Prepared
from fsm_calib.diagnosis.replay.robot_size import robot_size
from fsm_calib.types import FloatArray
from fsm_calib.world2d.effects import Effect

CENTRE_PITCH, FAR_PITCH = 0.03, 0.06  # m: of near discs, and of far ones, whose edges are flatter
RADII = np.arange(0.09, 0.40, 0.03)  # m: how far off a marker is still the one that is seen
FAR_RADII = np.arange(0.45, 1.0, 0.06)  # m: of one that is seen from afar, or a compass beside steel
MOVED_WIDE, MOVED = (0.015, 0.0075), (0.0075, 0.004, 0.002)  # m, by which the best discs are moved at the end
LARGEST_JUMP = 12.0  # robust standard deviations: larger ones count as so many, a lone outlier is no marker
SURE_JUMP = 6.0  # the same where one asks whether there is a marker at all
SLACK = 1  # frames before and after a crossing that may be its own
WIDE_TIME, WIDE_LEAST = 0.1, 2  # s, frames: the same for the grid, in which a robot travels about its pitch
SHORTEST_STAY = 6  # frames: a shorter visit is all edge, or a few outliers in a row (4 of them, measured)
STRETCH = 16  # frames that are passed over together where they are far from a disc
FEWEST_JUMPS = 2  # entries and exits that a disc must have
DISC_NUMBERS = 4  # turn, centre, radius
KEPT = 3
APART = 0.06  # m between the centres of two discs that are kept
SMALLEST_SPREAD = np.array([1e-5, 1e-5, 1e-5])  # m, m, rad: of poses without noise
RIDGE = 1e-6  # keeps the normal matrix regular where a disc is crossed at one point only
MOVES = np.array(np.meshgrid(*[(-1.0, 0.0, 1.0)] * 3)).reshape(3, -1).T
MAD_TO_SD = 1.4826  # of a normal distribution


@dataclass(frozen=True, slots=True)
class Wrong:
    """How a marker may be wrong: by so many of turn and shift, along x and y; `rigid` 1, or 0: headings alone.

    It counts within `view` of the heading `face` [rad], by all headings where that is pi.
    """

    numbers: int
    rigid: float
    face: float = 0.0
    view: float = math.pi

    @property
    def from_one_side(self) -> bool:
        """Whether it counts by some headings alone."""
        return self.view < math.pi


TURNED, SHIFTED, HEADING = Wrong(1, 1.0), Wrong(3, 1.0), Wrong(1, 0.0)
# Boards that are seen from one side [rad]: as they are sought; by how much the best are turned, how wide they may see.
FACES = np.arange(-0.75, 1.01, 0.25) * math.pi
VIEWS = (0.6, 1.2, 1.8)
TURNED_BY, WIDTH = (0.2, 0.1, 0.05, 0.025), (0.4, 2.4)
FROM_ONE_SIDE = tuple(Wrong(3, 1.0, face, view) for face in FACES.tolist() for view in VIEWS)
COARSE = 2.0  # times the usual pitch: boards that are entered and left by turning are less sharp in place


@dataclass(frozen=True, eq=False)
class Jumps:
    """Unexplained motion about each pose (n, 3) [m, m, rad]: jump (n, 3) in world axes, spread (3,).

    wide, wide_spread : the same over the longer time that a grid of discs needs.
    """

    pose: FloatArray
    jump: FloatArray
    spread: FloatArray
    wide: FloatArray
    wide_spread: FloatArray


@dataclass(frozen=True, slots=True)
class Disc:
    """A marker's disc [m], its turn [rad] and shift [m], how it is wrong, and the log-likelihood that it promises to
    win.
    """

    x: float
    y: float
    radius: float
    turn: float
    shift_x: float
    shift_y: float
    wrong: Wrong
    promise: float

    def changes(self, effect: Effect) -> dict[str, float]:
        """Return the disc in the words of an effect's parameters, by full name; shifts only where it has one."""
        numbers = {"turn": float(np.clip(self.turn, -1.0, 1.0)), "rigid": self.wrong.rigid}
        if self.shift_x or self.shift_y:
            numbers |= {"shift_x": self.shift_x, "shift_y": self.shift_y}
        if self.wrong.from_one_side:
            numbers |= {"face": self.wrong.face, "view": self.wrong.view}
        acting = {f"{effect.name}.{name}": value for name, value in numbers.items()}
        return Area(self.x, self.y, self.radius, self.radius).numbers(effect) | acting


def jumps_of(prepared: Prepared, simulated: FloatArray, largest: float = LARGEST_JUMP) -> Jumps:
    """Return what the poses of one recording moved beyond the simulated increments (n, 5).

    largest : robust standard deviations that a jump may count for.
    """
    p = prepared
    cos, sin = np.cos(p.reference[:, 2]), np.sin(p.reference[:, 2])
    off = np.column_stack([cos * p.y[:, 0] - sin * p.y[:, 1], sin * p.y[:, 0] + cos * p.y[:, 1], p.y[:, 2]])
    too_far = simulated - p.step  # told in the frame at the begin of an interval
    drift = np.zeros_like(off)
    drift[1:, 0] = cos[:-1] * too_far[1:, 0] - sin[:-1] * too_far[1:, 1]
    drift[1:, 1] = sin[:-1] * too_far[1:, 0] + cos[:-1] * too_far[1:, 1]
    drift[1:, 2] = too_far[1:, 2]
    poses = np.flatnonzero(p.seen[:, 2])
    unexplained, chain = (off - np.cumsum(drift, axis=0))[poses], np.cumsum(p.restart)[poses]
    wide = max(WIDE_LEAST, round(WIDE_TIME / float(p.geometry[2])))
    return Jumps(
        p.reference[poses],
        *_over(unexplained, chain, SLACK, largest),
        *_over(unexplained, chain, wide, largest),
    )


def _over(
    unexplained: FloatArray, chain: FloatArray, slack: int, largest: float
) -> tuple[FloatArray, FloatArray]:
    """Return the change (n, 3) from `slack` frames before a step to `slack` after it, nan across breaks; its spread."""
    jump, width = np.full_like(unexplained, np.nan), 1 + 2 * slack
    inner = slice(1 + slack, len(unexplained) - slack)
    jump[inner] = unexplained[width:] - unexplained[:-width]
    jump[inner][chain[width:] != chain[:-width]] = np.nan
    known = jump[np.isfinite(jump[:, 2])]
    spread = MAD_TO_SD * np.median(np.abs(known), axis=0) if len(known) else np.ones(3)
    spread = np.maximum(spread, SMALLEST_SPREAD)
    return np.clip(jump, -largest * spread, largest * spread), spread


def likely_discs(jumps: Sequence[Jumps], wrong: Wrong, kept: int = KEPT, size: float = 1.0) -> list[Disc]:
    """Return the most promising discs, apart from each other, of a marker that is `wrong` in some way.

    size : of the robot, as `robot_size` tells it.
    """
    pose = np.vstack([j.pose for j in jumps])
    wide = Frames.of(pose, [(j.wide, j.wide_spread) for j in jumps])
    narrow = Frames.of(pose, [(j.jump, j.spread) for j in jumps])
    coarse = COARSE if wrong.from_one_side else 1.0
    discs = _grid(pose, size, coarse)
    promise = wide.numbers(discs, wrong)[:, 0]
    any_good = promise > 0.0
    promise, discs = promise[any_good], discs[any_good]
    best = [discs[i] for i in apart(promise, discs[:, :2], kept, size * APART)]
    first = (COARSE * MOVED_WIDE[0],) if wrong.from_one_side else ()
    by = [[size * step for step in steps] for steps in ((*first, *MOVED_WIDE), MOVED)]
    moved = [narrow.moved(wide.moved(disc, by[0], wrong), by[1], wrong) for disc in best]
    looked = [narrow.looked(disc, wrong, by[1]) if wrong.from_one_side else (disc, wrong) for disc in moved]
    found = [narrow.disc(*one) for one in looked]
    return sorted(found, key=lambda disc: -disc.promise)


def jump_evidence(prepared: Sequence[Prepared], simulated: Sequence[FloatArray], count: int) -> float:
    """Return the evidence that poses jump at the edge of some disc, whatever the simulated increments (n, 5) explain.

    2 g - 4 ln N - 2 ln D for the gain g of the best of D discs and `count` innovations N. None where poses have no
    places, or places of a map that was told by the same frames.
    """
    if not all(p.poses.placed and not p.settings.own_map for p in prepared):
        return -np.inf
    jumps = [jumps_of(p, s, SURE_JUMP) for p, s in zip(prepared, simulated, strict=True)]
    size = robot_size(float(prepared[0].geometry[0]))
    best = max((disc.promise for disc in likely_discs(jumps, TURNED, size=size)), default=0.0)
    discs = len(_grid(np.vstack([j.pose for j in jumps]), size))
    return float(2.0 * best - DISC_NUMBERS * np.log(count) - 2.0 * np.log(discs))


@dataclass(frozen=True, eq=False)
class Frames:
    """All frames: pose (n, 3) [m, m, rad], jump (n, 3), nan where a recording begins or breaks, weights (n, 3)."""

    pose: FloatArray
    jump: FloatArray
    weight: FloatArray

    @classmethod
    def of(cls, pose: FloatArray, jumps: Sequence[tuple[FloatArray, FloatArray]]) -> Frames:
        """Join the jumps (n, 3) of all recordings, each with its spread (3,)."""
        weight = [np.tile(spread**-2, (len(jump), 1)) for jump, spread in jumps]
        return cls(pose, np.vstack([jump for jump, _ in jumps]), np.vstack(weight))

    def numbers(self, discs: FloatArray, wrong: Wrong) -> FloatArray:
        """Return promise, turn [rad] and shift [m] of discs (m, 3), shape (m, 4)."""
        looks = np.cos(self.pose[:, 2] - wrong.face) >= math.cos(wrong.view)
        found = _numbers(self.pose, looks, self.jump, self.weight, discs, wrong.numbers, wrong.rigid)
        return np.asarray(found, dtype=float)

    def moved(self, disc: FloatArray, steps: Sequence[float], wrong: Wrong) -> FloatArray:
        """Move and resize a disc (3,) by ever smaller `steps` [m] to where it promises most."""
        for step in steps:
            tried = disc + step * MOVES
            disc = tried[int(np.argmax(self.numbers(tried, wrong)[:, 0]))]
        return disc

    def looked(self, disc: FloatArray, wrong: Wrong, steps: Sequence[float]) -> tuple[FloatArray, Wrong]:
        """Turn the face and widen the view of a board by ever smaller steps to where it promises most, the disc (3,)
        moved by `steps` [m] after each.
        """
        for turned in TURNED_BY:
            tried = [
                replace(
                    wrong, face=wrong.face + a * turned, view=float(np.clip(wrong.view + b * turned, *WIDTH))
                )
                for a in (-1.0, 0.0, 1.0)
                for b in (-1.0, 0.0, 1.0)
            ]
            wrong = max(tried, key=lambda one: float(self.numbers(disc[None], one)[0, 0]))
            disc = self.moved(disc, steps, wrong)
        return disc, wrong

    def disc(self, disc: FloatArray, wrong: Wrong) -> Disc:
        """Return a disc (3,) with the turn and shift that fit it best."""
        x, y, radius = map(float, disc)
        promise, turn, shift_x, shift_y = map(float, self.numbers(disc[None], wrong)[0])
        return Disc(x, y, radius, turn, shift_x, shift_y, wrong, promise)


def _grid(place: FloatArray, size: float, coarse: float = 1.0) -> FloatArray:
    """Return discs (m, 3): x, y, radius [m] over the visited floor and beyond it as far as their edge reaches it.

    coarse : times the usual pitch of centres and radii.
    """
    grids = ((RADII, CENTRE_PITCH), (FAR_RADII, FAR_PITCH))
    return np.vstack(
        [_discs(place, size * radii[:: round(coarse)], size * coarse * pitch) for radii, pitch in grids]
    )


def _discs(place: FloatArray, radii: FloatArray, pitch: float) -> FloatArray:
    """Return discs (m, 3) of some radii with a pitch between their centres."""
    low, high = place.min(axis=0) - radii[-1], place.max(axis=0) + radii[-1]
    x, y, r = np.meshgrid(np.arange(low[0], high[0], pitch), np.arange(low[1], high[1], pitch), radii)
    return np.column_stack([x.ravel(), y.ravel(), r.ravel()])


@njit(cache=True)
def _stretches(place):  # type: ignore[no-untyped-def]
    """Return a circle (x, y, radius) [m] around each stretch of `STRETCH` frames, shape (n / STRETCH, 3)."""
    out = np.zeros(((len(place) + STRETCH - 1) // STRETCH, 3))
    for i in range(len(out)):
        part = place[i * STRETCH : (i + 1) * STRETCH]
        x, y = 0.5 * (part[:, 0].min() + part[:, 0].max()), 0.5 * (part[:, 1].min() + part[:, 1].max())
        out[i, 0], out[i, 1] = x, y
        out[i, 2] = np.sqrt(((part[:, 0] - x) ** 2 + (part[:, 1] - y) ** 2).max())
    return out


@njit(cache=True)
def _is_far(circle, disc):  # type: ignore[no-untyped-def]
    """Return whether a disc and a circle do not touch: no frame of that stretch lies in the disc."""
    reach = circle[2] + disc[2]
    return (circle[0] - disc[0]) ** 2 + (circle[1] - disc[1]) ** 2 > reach * reach


@njit(cache=True)
def _numbers(place, looks, jump, weight, discs, size, rigid):  # type: ignore[no-untyped-def]
    """Return promise and the first `size` of turn, shift_x, shift_y of each disc, shape (m, 4); looks : (n,) in which
    frames the robot looks its way.
    """
    out = np.zeros((len(discs), 4))
    normal, score = np.zeros((3, 3)), np.zeros(3)
    around = _stretches(place)
    for d in range(len(discs)):
        normal[:], score[:] = 0.0, 0.0
        count, entered, square = 0, -1, discs[d, 2] ** 2
        was, k = False, 0
        while k < len(place):
            if not was and k % STRETCH == 0 and _is_far(around[k // STRETCH], discs[d]):
                k += STRETCH
                continue
            near = (place[k, 0] - discs[d, 0]) ** 2 + (place[k, 1] - discs[d, 1]) ** 2 < square
            inside = near and looks[k]
            if inside and not was:
                entered = k
            elif was and not inside and k - entered >= SHORTEST_STAY:
                way_in, way_out = (1.0, rigid), (-1.0, rigid)
                count += _add_jump(
                    place[entered], way_in, jump[entered], weight[entered], discs[d], size, normal, score
                )
                count += _add_jump(place[k - 1], way_out, jump[k], weight[k], discs[d], size, normal, score)
            was, k = inside, k + 1
        if count >= FEWEST_JUMPS:
            numbers = np.linalg.solve(normal[:size, :size] + RIDGE * np.eye(size), score[:size])
            out[d, 0] = 0.5 * np.dot(numbers, score[:size])
            out[d, 1 : 1 + size] = numbers
    return out


@njit(cache=True)
def _add_jump(at, way, jump, weight, disc, size, normal, score):  # type: ignore[no-untyped-def]
    """Add the jump at an edge to the normal equations; `at` the pose that is wrong, `way` in or out (1 or -1) and
    `rigid`; return 0 where no jump is known.
    """
    if np.isnan(jump[2]):
        return 0
    columns, sign, turned = np.zeros((3, 3)), way[0], way[0] * way[1]
    columns[0, 0], columns[0, 1] = -turned * (at[1] - disc[1]), turned * (at[0] - disc[0])
    columns[0, 2] = columns[1, 0] = columns[2, 1] = sign
    for c in range(3):
        for i in range(size):
            score[i] += columns[i, c] * weight[c] * jump[c]
            for j in range(size):
                normal[i, j] += columns[i, c] * weight[c] * columns[j, c]
    return 1
