"""The JSON Schema of study files, for editors that complete and check while one types."""

from __future__ import annotations

import json

from fsm_calib.scenario.schema import DIALECT, described
from fsm_calib.study.models import Study


def study_schema_text() -> str:
    """Return the schema as the text of ``scenarios/study_schema.json``."""
    schema = described({"$schema": DIALECT, **Study.model_json_schema()})
    return json.dumps(schema, indent=2, sort_keys=True, ensure_ascii=False) + "\n"
