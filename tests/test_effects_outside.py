"""Effects from outside the package: found, checked word by word, woven anew when their file changes."""

import importlib.metadata
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from fsm_calib.errors import InputError
from fsm_calib.world2d.effects import add_effects, registry
from fsm_calib.world2d.effects.outside import VARIABLE, effects_of, outside_effects
from fsm_calib.world2d.kernel import woven_source
from fsm_calib.world2d.parameters import parameter_table

STICKY = Path(__file__).parent / "effects_outside" / "sticky_spot.py"
TEXT = STICKY.read_text()


@pytest.fixture
def clean_catalogue(monkeypatch):
    """Whatever a test adds is gone after it."""
    monkeypatch.setenv(VARIABLE, "")
    yield
    monkeypatch.setenv(VARIABLE, "")
    add_effects(())


def changed(tmp_path, old, new, name="mine.py"):
    assert old in TEXT
    file = tmp_path / name
    file.write_text(TEXT.replace(old, new, 1))
    return file


def command(*arguments, cache):
    code = "from fsm_calib.cli import main; main()"
    environment = {**os.environ, "FSM_CALIB_CACHE": str(cache)}
    return subprocess.run(
        [sys.executable, "-c", code, *map(str, arguments)], capture_output=True, text=True, env=environment
    )


def test_an_added_effect_joins_behind_the_others_whose_numbers_stay_in_place(clean_catalogue):
    before, names = tuple(registry()), parameter_table().names
    add_effects([STICKY])
    assert tuple(registry()) == (*before, "sticky_spot")
    assert parameter_table().names[: len(names)] == names
    assert parameter_table().names[-1] == "sticky_spot.rate"


def test_its_hook_is_woven_into_the_program(clean_catalogue):
    assert "sticky_spot_step" not in woven_source()
    add_effects([STICKY])
    assert "sticky_spot_step(P, " in woven_source()


def test_an_edited_file_makes_another_program(clean_catalogue, tmp_path):
    """Otherwise the machine code of the file as it was would run."""
    code = "import sys\nfrom fsm_calib.world2d.kernel import woven_source\nprint(hash(woven_source()))"
    environment = {**os.environ, VARIABLE: str(tmp_path / "mine.py"), "PYTHONHASHSEED": "0"}
    seen = []
    for factor in ("1.0 + abs", "1.1 + abs"):
        changed(tmp_path, "1.0 + abs", factor)
        run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment)
        seen.append(run.stdout)
    assert seen[0].strip()
    assert seen[0] != seen[1]


def test_a_constant_that_a_hook_takes_from_elsewhere_is_part_of_the_program(clean_catalogue, monkeypatch):
    add_effects([STICKY])
    before = woven_source()
    module = sys.modules[registry()["sticky_spot"].hooks["step"].__module__]
    monkeypatch.setattr(module, "MASS", 23)
    assert woven_source() != before


def test_the_command_line_knows_an_effect_of_a_file(tmp_path):
    shown = command("effects", "--json", "--effects", STICKY, cache=tmp_path)
    row = json.loads(shown.stdout)[-1]
    assert (row["name"], row["phenomenon"], row["where"]) == ("sticky_spot", "sticky spot", "disc")
    assert [closure["parameters"] for closure in row["closures"]] == [["pull", "x", "y", "radius"]]


def test_scenarios_and_their_schema_know_it(tmp_path):
    scenario = tmp_path / "s.yaml"
    scenario.write_text("name: s\nrobot: {effects: {sticky_spot: {pull: 2.0}}}\n")
    assert command("validate", scenario, "--effects", STICKY, cache=tmp_path).returncode == 0
    refused = command("validate", scenario, cache=tmp_path)
    assert refused.returncode == 2
    assert "unknown robot.effects setting 'sticky_spot'" in refused.stderr
    assert "StickySpotSection" in command("schema", "--effects", STICKY, cache=tmp_path).stdout


def test_a_missing_file_is_wrong_use(tmp_path):
    refused = command("effects", "--effects", tmp_path / "nothing.py", cache=tmp_path)
    assert refused.returncode == 2
    assert "no such file" in refused.stderr
    assert "Traceback" not in refused.stderr


def test_an_installed_package_announces_its_effects(clean_catalogue, monkeypatch):
    (effect,) = effects_of(STICKY)
    point = importlib.metadata.EntryPoint("sticky", "nowhere:EFFECT", "fsm_calib.effects")
    monkeypatch.setattr(type(point), "load", lambda self: effect)
    monkeypatch.setattr("fsm_calib.world2d.effects.outside.entry_points", lambda group: [point])
    assert list(outside_effects()) == [effect]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('family="patch"', 'family="pach"', "unknown family 'pach'. Did you mean patch?"),
        ('regimes=("place",)', 'regimes=("plaice",)', "unknown regime 'plaice'. Did you mean place"),
        ('where="disc"', 'where="disk"', "unknown where 'disk'. Did you mean disc?"),
        ('"F_s", "N"', '"F_s", "kgf"', "parameter pull: unknown unit 'kgf'. Did you mean kg?"),
        ('"forward", "turn"', '"foward", "turn"', "unknown channel 'foward'. Did you mean forward?"),
        ('where="disc"', 'where="disc", acts_on="dragg"', "unknown acts_on 'dragg'. Did you mean drag?"),
        ('{"step": stick}', '{"stpe": stick}', "unknown hook 'stpe'. Did you mean "),
        ('where="disc"', 'where="area"', "needs parameters x, y, half_x, half_y; missing: half_x, half_y"),
        ('reads=("place", "heading")', 'reads=("heading",)', "its step reads PLACE_X and PLACE_Y"),
        ('@njit(error_model="numpy")', "", "the hook step is not compiled"),
        ("0.0, 8.0, 1.2,", "0.0, 1.0, 1.2,", "pull: typical is 1.2, not within 0 to 1 N"),
        ("with {pull}.", "with {pul}.", "unknown parameter in the sentence 'pul'. Did you mean pull?"),
        ("EFFECT = Effect(", "MINE = Effect(", "declares no effect"),
        ("from numba import njit", "from nomba import njit", "No module named 'nomba'"),
    ],
)
def test_what_is_wrong_in_a_file_is_said_with_the_nearest_word(tmp_path, old, new, said):
    with pytest.raises(InputError) as error:
        effects_of(changed(tmp_path, old, new))
    assert said in str(error.value)
    assert "mine.py" in str(error.value)


def test_a_name_that_is_taken_is_refused_and_nothing_is_added(clean_catalogue, tmp_path):
    file = changed(tmp_path, 'name="sticky_spot"', 'name="floor_tilt"')
    with pytest.raises(InputError, match="there is an effect of the name 'floor_tilt'"):
        add_effects([STICKY, file])
    assert "sticky_spot" not in registry()
