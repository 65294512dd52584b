"""Reads a study file: every error at once, each with its place and the nearest valid name."""

from __future__ import annotations

import json
from functools import lru_cache
from pathlib import Path

from fsm_calib.errors import InputError, ManyErrors
from fsm_calib.scenario.load import checked
from fsm_calib.scenario.models import Scenario
from fsm_calib.scenario.yaml_source import YamlDocument, read_yaml
from fsm_calib.study.models import Study
from fsm_calib.study.variants import scenario_of_variant, variants_of

ONLY_IN_STUDIES = frozenset(Study.model_fields) - frozenset(Scenario.model_fields)
"""Settings by which a study file is told from a scenario."""


def is_study(document: YamlDocument) -> bool:
    """Tell whether a file is meant as a study: it has a setting that only studies have."""
    return isinstance(document.data, dict) and not ONLY_IN_STUDIES.isdisjoint(document.data)


def load_study(path: str | Path) -> Study:
    """Return the study in a YAML file.

    Raises
    ------
    InputError
        With ``file:line:column`` for everything that is wrong; `ManyErrors` when there are several.
    """
    return study_from(read_yaml(path))


def study_from(document: YamlDocument) -> Study:
    """Return the study in a parsed YAML document; see `load_study` for the errors."""
    study = checked(document, Study, "a study", "scenarios/study.yaml")
    _check_variants(study, document)
    return study


def _check_variants(study: Study, document: YamlDocument) -> None:
    """Raise where a swept setting does not exist, does not take a value, or a name stands twice."""
    errors: list[InputError] = []
    names = [sweep.name for sweep in study.sweeps]
    for number, sweep in enumerate(study.sweeps):
        if names.index(sweep.name) != number:
            where = document.where(("sweeps", number, "name"))
            errors.append(
                InputError(f"two sweeps are called {sweep.name!r}", where=where, cure="Rename one.")
            )
    for variant in variants_of(study):
        if variant.sweep is None:
            continue
        where = document.where(("sweeps", names.index(variant.sweep)))
        try:
            scenario_of_variant(study, variant)
        except InputError as error:
            errors.append(InputError(f"{variant.name}: {error}".rstrip("."), where=where))
    if errors:
        raise errors[0] if len(errors) == 1 else ManyErrors(errors)


def study_text(study: Study) -> str:
    """Return what is given of a study as one line of JSON, the form in which it travels to workers."""
    return json.dumps(study.model_dump(mode="json", exclude_unset=True), sort_keys=True)


@lru_cache(maxsize=8)
def study_of_text(text: str) -> Study:
    """Return the study that `study_text` wrote; a worker parses it once."""
    return Study.model_validate_json(text)
