"""Locate the mismatch before naming it: channels, regime, when, where, in which state, and how significant.

The residual of the re-fitted base robot is tested against every feature group. Significance accounts for the looking:
the largest surprise over all groups is compared with the largest under random flips of the residual's sign in blocks
of a second (a max-statistic permutation test: Westfall & Young 1993), which keeps what correlation is left.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from fsm_calib.diagnosis.fitting.fit import Engine, Fit
from fsm_calib.diagnosis.replay.situation import Situation
from fsm_calib.diagnosis.shapes.features import Group, body_columns, feature_groups
from fsm_calib.diagnosis.shapes.score_tests import (
    ALPHA,
    Blocks,
    LeftOver,
    Products,
    Residual,
    log_tail,
    products_of,
    project,
    residual_of,
    test_products,
)
from fsm_calib.types import FloatArray

BLOCK = 1.0  # s: several times the noise's memory
FLIPS = 999  # p-values down to 0.001
STATE_SURPRISE = 3.0  # -log10 p of a state before the correction for their number
BIN = 1.0  # s
BIN_SURPRISE = 4.0  # -log10 p of a second: 120 seconds are looked at
REGIME_WORDS = {
    "command level": "depends on the command",
    "other wheel": "depends on both wheels' directions",
    "fast turns": "turning",
    "speed and turning": "depends on speed",
    "place": "at a place",
    "place and heading": "depends on heading and place",
    "heading": "depends on heading",
    "heading and speed": "depends on heading",
    "time": "changes with time",
    "after a command": "after a command changes",
    "after a reversal": "after a reversal",
    "heading turned": "depends on turns made",
    "wheel phase": "once per wheel turn",
    "direction of motion": "depends on the direction of motion",
    "wear and warmth": "changes with time",
    "moment": "at moments",
    "repeats in time": "comes and goes with a period",
}
CHANNELS = {"left wheel": ("forward", "turn"), "right wheel": ("forward", "turn")}


@dataclass(frozen=True, eq=False)
class Location:
    """Where a mismatch shows.

    channels; regime; when : spans (start, end) [s] of the first recording that shows it; where : x, y, radius [m] or
    None; states; p_value of the largest surprise over all groups; tests : all groups, most surprising first.
    """

    channels: tuple[str, ...]
    regime: str
    when: tuple[tuple[float, float], ...]
    where: dict[str, float] | None
    states: tuple[str, ...]
    p_value: float
    tests: tuple[LeftOver, ...]


def locate(engine: Engine, fit: Fit, situations: list[Situation], rng: np.random.Generator) -> Location:
    """Locate what a fit leaves unexplained."""
    groups = feature_groups(situations)
    residual = residual_of(engine, fit)
    tests, p_value, threshold = flip_test(residual, groups, rng)
    strong = [t for t in tests if t.surprise > threshold]
    channels: list[str] = []
    for test in strong[:4]:
        channels += [c for c in CHANNELS.get(test.group.channel, (test.group.channel,)) if c not in channels]
    return Location(
        channels=tuple(channels),
        regime=_regime(strong, situations),
        when=_when(residual, situations),
        where=_where(tests, situations, threshold),
        states=_states(residual, situations, engine),
        p_value=p_value,
        tests=tuple(tests),
    )


@dataclass(frozen=True, eq=False)
class Flips:
    """Random signs of blocks of innovations, (flips, blocks), and the largest surprise so far under each."""

    signs: FloatArray
    largest: FloatArray

    def watch(self, products: Products) -> None:
        """Take note of the surprises of a group under the random signs."""
        if not products.has_nothing:
            energy = np.sum((self.signs @ products.parts) ** 2, axis=1)
            np.maximum(self.largest, products.surprise(energy), out=self.largest)


def flip_test(
    residual: Residual, groups: Iterable[Group], rng: np.random.Generator
) -> tuple[list[LeftOver], float, float]:
    """Return the tests of all groups, most surprising first, the p-value of the first, and what ALPHA of them reach."""
    blocks = _blocks(residual)
    flips = Flips(rng.choice([-1.0, 1.0], size=(FLIPS, blocks.count)), np.zeros(FLIPS))
    tests = []
    for group in groups:
        products = products_of(residual, group, blocks)
        tests.append(test_products(group, products))
        flips.watch(products)
    tests.sort(key=lambda t: -t.surprise)
    p_value = float((1 + np.sum(flips.largest >= tests[0].surprise)) / (FLIPS + 1))
    return tests, p_value, float(np.quantile(flips.largest, 1 - ALPHA))


def _blocks(residual: Residual) -> Blocks:
    """Return the second that each innovation belongs to, counted through all recordings."""
    numbers, offset = [], 0
    for whitener in residual.whiteners:
        p = whitener.prepared
        own = np.floor((p.time - p.time[0]) / BLOCK).astype(int)
        numbers.append(np.broadcast_to(own[:, None], p.scored.shape)[p.scored] + offset)
        offset += int(own.max()) + 1
    return Blocks(np.concatenate(numbers), offset)


def _regime(strong: Sequence[LeftOver], situations: list[Situation]) -> str:
    """Return the regime of the most surprising group in words, with the sharper half of what it depends on."""
    if not strong:
        return ""
    names = list(dict.fromkeys(test.group.regime for test in strong[:3]))
    return ", ".join(REGIME_WORDS.get(name, name) for name in names)


def _when(residual: Residual, situations: list[Situation]) -> tuple[tuple[float, float], ...]:
    """Return the seconds in which the residual is larger than noise, joined, of the recording that shows most."""
    best: tuple[float, tuple[tuple[float, float], ...]] = (0.0, ())
    for run, whitener in enumerate(residual.whiteners):
        p, psi = whitener.prepared, residual.psi[residual.rows(run)]
        second = np.broadcast_to(np.floor((p.time - p.time[0]) / BIN).astype(int)[:, None], p.scored.shape)[
            p.scored
        ]
        energy = np.bincount(second, psi**2)
        number = np.bincount(second)
        level = float(np.median(energy[number > 0] / number[number > 0]))
        surprise = -log_tail(energy / level, np.maximum(number, 1)) / np.log(10.0)
        hot = np.flatnonzero(surprise > BIN_SURPRISE)
        spans: list[tuple[float, float]] = []
        for h in hot:
            start = float(p.time[0] + h * BIN)
            if spans and start - spans[-1][1] <= 2 * BIN:
                spans[-1] = (spans[-1][0], start + BIN)
            else:
                spans.append((start, start + BIN))
        total = float(surprise[hot].sum())
        if total > best[0]:
            best = (total, tuple((round(a, 2), round(b, 2)) for a, b in spans[:8]))
    return best[1]


def _where(
    tests: Sequence[LeftOver], situations: list[Situation], threshold: float
) -> dict[str, float] | None:
    """Return the centre of the strongest place function when place is the most surprising thing."""
    from fsm_calib.diagnosis.shapes.features import place_centres, place_pitch

    strong = [t for t in tests if t.surprise > threshold][:2]
    place = next((t for t in strong if t.group.regime == "place"), None)
    if place is None:
        return None
    pitch = place_pitch(situations)
    centres = place_centres(situations, pitch)
    weight = np.abs(place.coefficients)
    near = np.hypot(*(centres - centres[int(np.argmax(weight))]).T) < 1.5 * pitch
    x, y = (weight[near, None] * centres[near]).sum(axis=0) / weight[near].sum()
    return {"x": round(float(x), 3), "y": round(float(y), 3), "radius": pitch}


def _states(residual: Residual, situations: list[Situation], engine: Engine) -> tuple[str, ...]:
    """Return the machine's states in which the robot's speeds are off, most surprising first."""
    rows = [_state_rows(simulator.prepared) for simulator in engine.simulators]
    names = sorted({name for row in rows for name in row if name})
    found = []
    for name in names:
        blocks = [
            _state_columns(s, np.array([r == name for r in row]))
            for s, row in zip(situations, rows, strict=True)
        ]
        x = project(residual, blocks)
        gram = x.T @ x + 1e-9 * np.eye(x.shape[1])
        score = x.T @ residual.psi
        surprise = float(-log_tail(score @ np.linalg.solve(gram, score), x.shape[1]) / np.log(10.0))
        if surprise > STATE_SURPRISE + np.log10(len(names)):
            found.append((surprise, name))
    return tuple(name for _, name in sorted(found, reverse=True)[:4])


def _state_rows(prepared: object) -> list[str]:
    track = prepared.recording.state  # type: ignore[attr-defined]
    time = prepared.time  # type: ignore[attr-defined]
    return [track.at(float(t)) if track is not None else "" for t in time]


def _state_columns(s: Situation, inside: np.ndarray) -> FloatArray:
    on = inside.astype(float)[:, None]
    return np.concatenate(
        [
            body_columns(s, forward=on * np.tanh(s.v / 0.02)[:, None]),
            body_columns(s, turn=on * np.tanh(s.omega * s.half / 0.02)[:, None] / s.half),
            body_columns(s, lateral=on),
        ],
        axis=2,
    )


def families(names: Sequence[str], family_of: dict[str, str]) -> dict[str, list[str]]:
    """Group names by family."""
    grouped: dict[str, list[str]] = defaultdict(list)
    for name in names:
        grouped[family_of[name]].append(name)
    return dict(grouped)
