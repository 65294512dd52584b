"""The published behaviours that are settings of actions, by name (docs/method.md tells why each was
corrected).
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from fsm_calib.actions.settings import ActionSettings
from fsm_calib.errors import UnknownNameError

PUBLISHED: dict[str, dict[str, dict[str, Any]]] = {
    "equation_3": {"ratio": {"equation": "published", "combine": False}},
    "quiet_threshold": {"ratio": {"quiet_correction": 0.05, "combine": False}},
    "sweep_count": {"camera": {"smallest_gain": 0.0}},
    "camera_yaw": {"marker": {"heading": "camera"}},
    "last_marker": {"marker": {"nearest": "last", "frames": 1}},
}
"""Name -> group -> setting -> value."""


def with_published(settings: ActionSettings, *names: str) -> ActionSettings:
    """Return `settings` with the published behaviours `names` switched on.

    Raises
    ------
    UnknownNameError
        When a name is not in `PUBLISHED`.
    """
    for name in names:
        if name not in PUBLISHED:
            raise UnknownNameError("published behaviour", name, PUBLISHED)
        for group, changes in PUBLISHED[name].items():
            settings = replace(settings, **{group: replace(getattr(settings, group), **changes)})
    return settings
