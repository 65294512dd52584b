"""The variants of a study: as it is, one correction taken back, one setting changed; and each robot's scenario."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic import ValidationError

from fsm_calib.errors import InputError, UnknownNameError
from fsm_calib.scenario.explain import dotted
from fsm_calib.scenario.mirrors import PUBLISHED_ACTIONS, PUBLISHED_LIMITS
from fsm_calib.scenario.models import Scenario
from fsm_calib.study.models import RobotScenario, Study
from fsm_calib.world2d.fleet import FLEET, draw_camera, draw_mount

BASE = "base"
"""Name of the variant that changes nothing."""
AS_PUBLISHED = "as_published"
"""Name of the variant with every correction taken back."""


@dataclass(frozen=True, slots=True)
class Variant:
    """One way to run the robots: its name, the published behaviours in it, and the setting it changes."""

    name: str = BASE
    published: tuple[str, ...] = ()
    sweep: str | None = None
    setting: str = ""
    value: float = 0.0


def variants_of(study: Study) -> tuple[Variant, ...]:
    """Return the variants of a study, the base first."""
    found = [Variant()]
    found += [Variant(f"published:{name}", (name,)) for name in study.corrections]
    if study.as_published:
        found.append(Variant(AS_PUBLISHED, (*PUBLISHED_ACTIONS, *PUBLISHED_LIMITS)))
    for sweep in study.sweeps:
        for value in sweep.values:
            number = int(value) if sweep.whole else value
            found.append(Variant(f"{sweep.name}={value:g}", (), sweep.name, sweep.setting, number))
    return tuple(found)


def seed_of(study_seed: int, robot: int) -> int:
    """Return the seed of robot number `robot`: from (study seed, robot index) alone, below 2**63."""
    state = np.random.SeedSequence([study_seed, robot]).generate_state(1, np.uint64)
    return int(state[0] >> np.uint64(1))


def robot_name(robot: int) -> str:
    """Return the name of robot number `robot`, which sorts as the number does."""
    return f"robot{robot:06d}"


def scenario_of_variant(study: Study, variant: Variant) -> Scenario:
    """Return the scenario that every robot of a variant goes through.

    Only what the study's file says counts as given: what the area's drawing tells is still taken from it.

    Raises
    ------
    InputError
        When the swept setting does not exist or does not take the value.
    """
    data = study.scenario.model_dump(mode="json", exclude_unset=True)
    data["published"] = list(dict.fromkeys([*study.scenario.published, *variant.published]))
    if variant.setting:
        _check(study.scenario.model_dump(mode="json"), variant.setting)
        _set(data, variant.setting, variant.value)
    try:
        return RobotScenario.model_validate(data)
    except ValidationError as error:
        details = error.errors(include_url=False)[0]
        raise InputError(f"{dotted(details['loc'])}: {details['msg']}", where=variant.setting) from error


def _check(every: Mapping[str, Any], path: str) -> None:
    """Refuse a dotted path that leads nowhere in `every`, all settings of a scenario; below what is off (null) or
    empty the scenario itself checks.
    """
    names, section = path.split("."), every
    for depth, name in enumerate(names):
        if not isinstance(section, Mapping) or name not in section:
            known = section if isinstance(section, Mapping) else ()
            raise UnknownNameError("setting", name, known, where=".".join(names[:depth]))
        if not section[name] and isinstance(section[name], Mapping | None):
            return
        section = section[name]


def _set(data: dict[str, Any], path: str, value: float) -> None:
    """Set the value at a dotted path of nested mappings; what is off (null) or not given is switched on."""
    *sections, last = path.split(".")
    for name in sections:
        data[name] = data.get(name) or {}
        data = data[name]
    data[last] = value


def scenario_of_robot(study: Study, variant: Variant, robot: int) -> Scenario:
    """Return the scenario of robot number `robot`: its own seed and name, everything else of its variant."""
    scenario = scenario_of_variant(study, variant)
    section = scenario.robot.model_copy(update={"name": robot_name(robot)})
    if study.same_robot:
        section = section.model_copy(update=_one_robot(study))
    return scenario.model_copy(update={"seed": seed_of(study.seed, robot), "robot": section})


def _one_robot(study: Study) -> dict[str, Any]:
    """Return what a study of one robot fixes: lens, mount and wheel ratio, drawn once from the study's seed."""
    from fsm_calib.scenario.models import CameraSection, MountSection

    section, rng = study.scenario.robot, np.random.default_rng([study.seed])
    camera, mount, ratio = draw_camera(rng), draw_mount(rng), FLEET["wheel_ratio"].draw(rng)
    m, d = camera.matrix, camera.distortion
    lens = CameraSection(
        fx=m[0, 0], fy=m[1, 1], cx=m[0, 2], cy=m[1, 2], k1=d[0], k2=d[1], p1=d[2], p2=d[3], k3=d[4]
    )
    drawn = MountSection(**{name: getattr(mount, name) for name in type(mount).__dataclass_fields__})
    return {
        "source": "nominal",
        "camera": section.camera or lens,
        "mount": section.mount or drawn,
        "wheel_ratio": section.wheel_ratio or ratio,
    }
