"""YAML without surprises, and the place of every value."""

from __future__ import annotations

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fsm_calib.errors import FsmCalibError, InputError, ManyErrors
from fsm_calib.scenario.yaml_source import parse_yaml, read_yaml


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1e-3", 1e-3),
        ("1E5", 1e5),
        (".5", 0.5),
        ("-7", -7),
        ("010", 10),
        ("0x1F", 31),
        ("0o17", 15),
        ("on", "on"),
        ("no", "no"),
        ("12:30:45", "12:30:45"),
        ("2026-11-21", "2026-11-21"),
        ("1_000", "1_000"),
        ("'1'", "1"),
        ("true", True),
        ("~", None),
        ("", None),
    ],
)
def test_plain_scalars_follow_yaml_1_2(text: str, expected: object) -> None:
    value = parse_yaml(f"a: {text}").data["a"]
    assert value == expected
    assert type(value) is type(expected)


def test_every_repeated_key_is_reported_with_its_place_and_the_first() -> None:
    with pytest.raises(ManyErrors) as caught:
        parse_yaml("a: 1\na: 2\nb: {c: 1, c: 2}", "x.yaml")
    assert str(caught.value).splitlines() == [
        "x.yaml:2:1: the key 'a' is given twice. Keep one of them; the first is at x.yaml:1:1.",
        "x.yaml:3:11: the key 'c' is given twice. Keep one of them; the first is at x.yaml:3:5.",
    ]


@pytest.mark.parametrize(
    "text",
    ["a: [1,", "a: 'x", "\ta: 1", "a: b: c", "a: \x01", "%YAML 9", "a: &x [*x]", "? [a]\n: 1", "[" * 5000],
)
def test_what_is_no_yaml_is_one_input_error(text: str) -> None:
    with pytest.raises(InputError, match=r"x\.yaml"):
        parse_yaml(text, "x.yaml")


@pytest.mark.parametrize("tag", ["!!python/object:os.system", "!!set", "!mine"])
@pytest.mark.parametrize("value", ["x", "{a: 1}", "[1]"])
def test_no_tag_builds_an_object(tag: str, value: str) -> None:
    with pytest.raises(InputError, match="not accepted"):
        parse_yaml(f"a: {tag} {value}")


def test_an_alias_bomb_is_refused() -> None:
    lines = ["a0: &a0 [1,1,1,1,1,1,1,1,1,1]"]
    lines += [f"a{n}: &a{n} [{','.join([f'*a{n - 1}'] * 10)}]" for n in range(1, 9)]
    with pytest.raises(InputError, match="more than"):
        parse_yaml("\n".join(lines))


def test_places_of_values_and_keys_are_line_and_column_from_one() -> None:
    document = parse_yaml("a: 1\nb:\n  - {c: 2}\n  - d: 3\n", "x.yaml")
    assert document.where(("b", 1, "d")) == "x.yaml:4:8"
    assert document.where(("b", 0, "c"), key=True) == "x.yaml:3:6"
    assert document.where(("b", 0, "missing")) == "x.yaml:3:5"


def test_a_file_that_is_not_utf8_names_its_line(tmp_path) -> None:
    path = tmp_path / "bad.yaml"
    path.write_bytes(b"a: 1\nb: \xff\n")
    with pytest.raises(InputError, match=r"bad\.yaml:2:1: the file is not UTF-8"):
        read_yaml(path)


WORDS = st.text(alphabet=st.characters(exclude_categories=["C", "Z"]), max_size=6)


@given(
    st.recursive(
        st.none()
        | st.booleans()
        | st.integers(-(10**9), 10**9)
        | st.floats(allow_nan=False, allow_infinity=False)
        | WORDS,
        lambda inner: st.lists(inner, max_size=3) | st.dictionaries(WORDS, inner, max_size=3),
        max_leaves=8,
    )
)
@settings(max_examples=60, deadline=None)
def test_json_is_read_as_json_reads_it(value: object) -> None:
    text = json.dumps(value, ensure_ascii=False)
    assert parse_yaml(text).data == json.loads(text)


@given(st.text(alphabet="ab:-[]{}&*!|>'\"#%@ \n\t1.e?,", max_size=40))
@settings(max_examples=300, deadline=None)
def test_any_text_is_read_or_is_one_of_our_errors(text: str) -> None:
    try:
        parse_yaml(text)
    except FsmCalibError as error:
        sentence = str(error)
    else:
        sentence = "fine"
    assert sentence
