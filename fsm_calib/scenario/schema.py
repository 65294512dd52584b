"""The JSON Schema of scenario files, for editors that complete and check while one types."""

from __future__ import annotations

import json
from typing import Any

from fsm_calib.scenario.models import Scenario

DIALECT = "http://json-schema.org/draft-07/schema#"
"""What the YAML language servers of editors understand."""


def scenario_schema() -> dict[str, Any]:
    """Return the JSON Schema of a scenario."""
    return {"$schema": DIALECT, **Scenario.model_json_schema()}


def schema_text() -> str:
    """Return the schema as the text of ``scenarios/schema.json``."""
    return json.dumps(scenario_schema(), indent=2, sort_keys=True, ensure_ascii=False) + "\n"
