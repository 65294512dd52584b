"""The schema says of every field what it means, and of every number its unit."""

import json

import pytest

from fsm_calib.scenario.schema import add_unit, number_kinds, scenario_schema
from fsm_calib.study.schema import study_schema_text

SCHEMAS = {"scenario": scenario_schema(), "study": json.loads(study_schema_text())}


def fields_of(kind):
    schema = SCHEMAS[kind]
    return {
        f"{name}.{field}": details
        for name, section in {kind: schema, **schema["$defs"]}.items()
        for field, details in section.get("properties", {}).items()
    }


@pytest.mark.parametrize("kind", SCHEMAS)
def test_every_field_has_a_description(kind):
    assert len(fields_of(kind)) > 300
    assert [n for n, details in fields_of(kind).items() if not details.get("description", "").strip()] == []


@pytest.mark.parametrize("kind", SCHEMAS)
def test_every_number_has_a_unit(kind):
    numbers = {name: details for name, details in fields_of(kind).items() if number_kinds(details)}
    assert len(numbers) > 200
    assert [name for name, details in numbers.items() if not details.get("unit")] == []


@pytest.mark.parametrize(
    ("field", "unit"),
    [
        ({"type": "number", "description": "Length of the road [m]."}, "m"),
        ({"type": "integer", "description": "How many."}, "1"),
        ({"anyOf": [{"type": "number"}, {"type": "null"}], "description": "Turn [rad/s]."}, "rad/s"),
        ({"type": "number", "description": "Something."}, None),
        ({"type": "string", "description": "A name [of a file]."}, None),
    ],
)
def test_a_unit_is_what_stands_in_brackets(field, unit):
    add_unit(field)
    assert field.get("unit") == unit
