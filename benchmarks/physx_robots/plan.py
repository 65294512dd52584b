"""Which robot has what: families and labels in shuffled blocks, so that their shares come out even."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.physx_robots import (  # noqa: F401  (they enter their laws in the catalogue)
    laws_command,
    laws_floor,
    laws_load,
    laws_mechanics,
    laws_motor,
    laws_outside,
    laws_push,
    laws_sensing,
    laws_supply,
    laws_timing,
)
from benchmarks.physx_robots.laws import LAWS, OUTSIDE, Law
from benchmarks.physx_robots.robots import Rng

HALVES = (
    {"plain": 15, "faint": 3, "pair": 3, "clean": 1, "outside": 3},
    {"plain": 14, "faint": 3, "pair": 4, "clean": 2, "outside": 2},
)  # of 50 robots: 58, 12, 14, 6 and 10 %
KIND_OF = {
    "electric": "motor_deadband command_saturation motor_gain_curve motor_reverse_asymmetry motor_asymmetric_lag "
    "motor_fault battery_sag motor_warmup",
    "time": "command_delay observation_delay clock_drift",
    "mechanics": "coulomb_friction gear_backlash wheel_eccentricity caster_drag tyre_scrub lateral_slip payload_offset",
    "floor": "floor_tilt carpet_nap rough_floor_patch low_friction_patch external_push",
    "sensing": "sensor_offset sensor_yaw misplaced_marker",
}
KINDS = {label: kind for kind, labels in KIND_OF.items() for label in labels.split()}
LABELS = sorted(KINDS)
SLOTS = {"plain": 1, "faint": 1, "pair": 2, "clean": 0, "outside": 0}


@dataclass(frozen=True)
class Task:
    """What a robot is to have: its family, labels, and a number for the choice among a label's laws."""

    family: str
    labels: tuple[str, ...]
    turn: int


def _families(seed: int, block: int) -> list[str]:
    rng = np.random.default_rng([seed, 11, block])
    names = [name for name, count in HALVES[block % 2].items() for _ in range(count)]
    return [str(name) for name in rng.permutation(names)]


def _label(seed: int, slot: int) -> str:
    rng = np.random.default_rng([seed, 12, slot // len(LABELS)])
    return str(rng.permutation(LABELS)[slot % len(LABELS)])


def task_of(seed: int, index: int) -> Task:
    """Return the task of robot `index`."""
    names = [name for block in range(index // 25 + 1) for name in _families(seed, block)]
    family = names[index]
    slot = sum(SLOTS[name] for name in names[:index])
    turn = slot // len(LABELS) if SLOTS[family] else names[:index].count(family)
    labels = [_label(seed, slot + i) for i in range(SLOTS[family])]
    if family == "pair" and KINDS[labels[0]] == KINDS[labels[1]]:
        others = [label for label in LABELS if KINDS[label] != KINDS[labels[0]]]
        labels[1] = str(np.random.default_rng([seed, 13, index]).choice(others))
    return Task(family, tuple(labels), turn)


def choose(rng: Rng, task: Task, attempt: int, seed: int) -> list[type[Law]]:
    """Return the laws of an attempt: the one whose turn it is at first, any of the label after three attempts."""
    if task.family == "clean":
        return []
    if task.family == "outside":
        order = np.random.default_rng([seed, 14]).permutation(len(OUTSIDE))
        return [OUTSIDE[order[(task.turn + attempt // 5) % len(OUTSIDE)]]]
    found = []
    for label in task.labels:
        laws = LAWS[label]
        first = int(np.random.default_rng([seed, 15, LABELS.index(label)]).integers(len(laws)))
        pick = (first + task.turn) % len(laws) if attempt < 3 else int(rng.integers(len(laws)))
        found.append(laws[pick])
    return found


def joined_needs(laws: list[type[Law]]) -> dict[str, str] | None:
    """Return what a robot must have for all of the laws; None where they contradict."""
    needs: dict[str, str] = {}
    for law in laws:
        for key, value in law.needs.items():
            if needs.setdefault(key, value) != value:
                return None
    return needs
