"""The form and the text are one: a change of a field changes that value and nothing else."""

import tomllib
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from camtools.base.errors import CamtoolsError
from camtools.panel.design.document import edited, lines_of, shown_text, typed
from camtools.panel.design.part_library import Draft
from camtools.part.schema import Key
from camtools.pipeline.load import keys_of, kind_of
from tests.tools.cases.preview_cases import PARTS, text_of

NAMES = sorted(path.stem for path in PARTS.glob("*.toml"))


def fields_of(text: str) -> list[Key]:
    """Return all fields of the form of a text."""
    tree = tomllib.loads(text)
    return [key for table in keys_of(kind_of(tree).name).tables(tree) for key in table.keys]


def values_of(node: object, path: tuple[str, ...] = ()) -> dict[str, Any]:
    """Return all values of a text by dotted names."""
    if isinstance(node, list) and node and isinstance(node[0], dict):
        node = dict(enumerate(node))
    if not isinstance(node, dict):
        return {".".join(path): node}
    inner = (values_of(one, (*path, str(name))) for name, one in node.items())
    return {name: value for found in inner for name, value in found.items()}


@pytest.mark.parametrize("name", NAMES)
def test_the_form_has_every_value_of_the_text(name: str) -> None:
    """Each key has a field with its value and line; what is shown, typed again, is the value."""
    text = text_of(name)
    fields = {field.dotted: field for field in fields_of(text) if field.value is not None}
    assert {key: field.value for key, field in fields.items()} == values_of(tomllib.loads(text))
    lines, places = text.splitlines(), lines_of(text, fields)
    for key, field in fields.items():
        assert lines[places[key] - 1].lstrip().split(" ")[0] == field.name
        if field.sort != "other":
            assert typed(field, shown_text(field.value)) == field.value, key


@st.composite
def changes(draw: st.DrawFn) -> tuple[str, Key, Any]:
    """Draw an example, one of its fields, and a value for it."""
    text = text_of(draw(st.sampled_from(NAMES)))
    field = draw(st.sampled_from([one for one in fields_of(text) if one.sort != "other"]))
    number = st.one_of(
        st.integers(-10_000, 10_000),
        st.floats(-1e6, 1e6, allow_nan=False).map(lambda one: float(f"{one:.6g}")),
    )
    values = {
        "number": number,
        "whole": st.integers(0, 1000),
        "choice": st.sampled_from(field.choices or ("a",)),
        "switch": st.booleans(),
        "text": st.text(min_size=1, max_size=20),
        "numbers": st.one_of(number, st.lists(number, min_size=1, max_size=5)),
    }
    return text, field, draw(values[field.sort])


def without_line(text: str, field: Key) -> tuple[str, str]:
    """Return the text before the line of a key, and after its value's last line."""
    lines = text.splitlines(keepends=True)
    begin = lines_of(text, [field.dotted])[field.dotted] - 1
    for end in range(begin + 1, len(lines) + 1):
        try:
            tomllib.loads("".join(lines[begin:end]))
        except tomllib.TOMLDecodeError:
            continue
        break
    return "".join(lines[:begin]), "".join(lines[end:])


def same(one: object, other: object) -> bool:
    """Return whether values are equal and of one type: 1, 1.0 and true are not."""
    return repr(one) == repr(other)


@pytest.mark.long
@settings(max_examples=120, suppress_health_check=[HealthCheck.too_slow])
@given(changes())
def test_a_change_keeps_the_rest_byte_for_byte(change: tuple[str, Key, Any]) -> None:
    """Lines before and after the key are as they were; of its own line the comment stays."""
    text, field, value = change
    changed = edited(text, field.path, value)
    values = values_of(tomllib.loads(changed))
    assert same(values[field.dotted], value)
    if field.value is None:  # a key, or a table with it, is added
        assert edited(changed, field.path, None).rstrip("\n").startswith(text.rstrip("\n")[:200])
        rest = {name: one for name, one in values.items() if name != field.dotted}
        assert same(rest, values_of(tomllib.loads(text)))
        assert [line for line in text.splitlines() if line not in changed.splitlines()] == []
        return
    assert without_line(changed, field) == without_line(text, field)
    line = text.splitlines()[lines_of(text, [field.dotted])[field.dotted] - 1]
    if "  #" in line and "[" not in line:
        comment = line[line.index("  #") :].strip()
        number = lines_of(changed, [field.dotted])[field.dotted]
        assert comment in changed.splitlines()[number - 1]


@settings(max_examples=6, suppress_health_check=[HealthCheck.too_slow])
@given(changes())
def test_there_and_back_is_the_same_text(change: tuple[str, Key, Any]) -> None:
    """The old value, set again, gives a text of the same values; a key that was added goes."""
    text, field, value = change
    back = edited(edited(text, field.path, value), field.path, field.value)
    before, after = (values_of(tomllib.loads(one)) for one in (text, back))
    assert same(after, before)


def test_entries_of_a_list_that_stay_keep_their_digits() -> None:
    """91.940 does not become 91.94 because its neighbour changes."""
    text = "[piston.profile]\ndiameter_mm = [91.940, 92.0,\n  91.985] # measured\n"
    path = ("piston", "profile", "diameter_mm")
    wanted = text.replace("92.0,", "92.5,")
    assert edited(text, path, [91.94, 92.5, 91.985]) == wanted


def test_a_text_that_is_no_toml_is_left_alone() -> None:
    """The form says what is wrong instead of guessing."""
    with pytest.raises(CamtoolsError, match="not TOML"):
        edited("[process\n", ("process", "feed_mm"), 1.0)
    with pytest.raises(CamtoolsError, match="change it in the text"):
        edited("a = 1\n", ("a", "b"), 1.0)


ODD = """a = '''
[process]
feed_mm = 1
'''
# [tool]
b = "[x]" # c = 1
[process]
feed_mm = 2
d.e = [
  1]
f = {g = 1}
[cam]
[[cam.lobe]]
[tool]
[[cam.lobe]]
z_mm = 1
"""


@pytest.mark.parametrize(
    ("field", "line"),
    [
        ("process.feed_mm", 8),
        ("process.d.e", 9),
        ("process.f.g", 11),
        ("process.missing", 7),
        ("tool.c", 14),
        ("cam.lobe.1.z_mm", 16),
        ("cam.lobe.0.z_mm", 13),
        ("process.f.missing", 11),
        ("missing.too", None),
    ],
)
def test_line_of_a_field_or_of_its_table(field: str, line: int | None) -> None:
    """What looks like a table inside a string or a comment is none."""
    assert lines_of(ODD, [field]).get(field) == line


@given(st.lists(st.text(max_size=3), max_size=20))
def test_undo_leads_back_step_by_step(texts: list[str]) -> None:
    """All steps undone give the first text, redone the last one."""
    draft = Draft("start")
    for i, text in enumerate(texts):
        draft.change(text, float(i), is_step=True)
    last = draft.text
    for _ in texts:
        draft.undo()
    assert draft.text == "start"
    for _ in texts:
        draft.redo()
    assert draft.text == last
