"""The JSON Schema of scenario files, for editors that complete and check while one types."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

from fsm_calib.scenario.models import Scenario

DIALECT = "http://json-schema.org/draft-07/schema#"
"""What the YAML language servers of editors understand."""


UNIT = re.compile(r"\[([^\[\]]+)\]")
"""How a description says the unit of a number; what only counts may leave out its ``[1]``."""


def scenario_schema() -> dict[str, Any]:
    """Return the JSON Schema of a scenario; every number carries its unit under ``unit``."""
    return described({"$schema": DIALECT, **Scenario.model_json_schema()})


def described(schema: dict[str, Any]) -> dict[str, Any]:
    """Give every field of a schema a description (a section's: what the section says) and every number its unit."""
    sections = schema["$defs"]
    for section in (schema, *sections.values()):
        for field in section.get("properties", {}).values():
            if "description" not in field and "$ref" in field:
                field["description"] = sections[field["$ref"].rsplit("/", 1)[1]].get("description", "")
            add_unit(field)
    return schema


def add_unit(field: dict[str, Any]) -> None:
    """Give a number's field the unit that its description says, ``1`` where it counts something."""
    said = UNIT.search(field.get("description", ""))
    kinds = number_kinds(field)
    if kinds and (said or kinds == {"integer"}):
        field["unit"] = said[1] if said else "1"


def number_kinds(field: Mapping[str, Any]) -> set[str]:
    """Return which of ``number`` and ``integer`` a field may hold, alone or in lists; empty for others."""
    inner = [*field.get("anyOf", ()), *field.get("prefixItems", ())]
    inner += [field["items"]] if isinstance(field.get("items"), dict) else []
    own = {field["type"]} & {"number", "integer"} if isinstance(field.get("type"), str) else set()
    return own.union(*(number_kinds(part) for part in inner))


def schema_text() -> str:
    """Return the schema as the text of ``scenarios/schema.json``."""
    return json.dumps(scenario_schema(), indent=2, sort_keys=True, ensure_ascii=False) + "\n"
