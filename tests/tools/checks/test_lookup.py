"""The DBC's lists, its C and the look-up pages are what their sources give."""

import re

import pytest

from camtools.base.errors import CamtoolsError
from camtools.base.project import ROOT
from camtools.link.kept_values import INFOS
from camtools.link.messages import DATABASE
from checks import dbc, lookup, machinefile, partfile


def test_pages_are_what_the_sources_give() -> None:
    """After a change of parameters, messages, keys or cantools they are written anew."""
    for module in (lookup, machinefile, partfile):
        for name, text in module.pages().items():
            assert (ROOT / name).read_text("utf-8") == text, f"{name}: {module.__name__} --write"


def test_no_parameter_and_no_message_is_missing() -> None:
    """Every parameter has one row."""
    _, parameters, messages, *_ = lookup.pages().values()
    names = {f"| `{name}` |" for name in INFOS}
    assert {name for name in names if parameters.count(name) != 1} == set()
    assert {m.name for m in DATABASE.messages if f"\n## {m.name}, 0x" not in messages} == set()
    assert "| -21 | `param_range` |" in messages


def test_lists_of_the_dbc_are_written_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    """New parameters, errors and faults come in; a list without a place is refused."""
    more = (
        dbc.headers()
        .replace(" X(counts_per_turn,", ' X(new_nm, 0, 0, 1, 0, "x") \\\n    X(counts_per_turn,')
        .replace(" X(image_size, ", ' X(new_error, -99, "new") \\\n X(image_size, ')
        .replace(" X(estop, ", ' X(new_fault, "a new fault") X(estop, ')
    )
    made = dbc.dbc_text(more)
    assert made.count(' parameter 0 "new_nm" 1 "counts_per_turn"') == 2
    assert made.count('-99 "new_error"') == 2
    assert " SG_ fault_new_fault : 32|1@1+" in made and " SG_ fault_estop : 33|1@1+" in made
    assert 'CM_ SG_ 448 fault_new_fault "A new fault.";' in made
    monkeypatch.setattr(dbc, "DBC", "firmware/PARAMETERS.md")
    with pytest.raises(CamtoolsError, match="places"):
        dbc.dbc_text(more)


def test_c_of_the_messages_depends_on_the_messages_alone() -> None:
    """Neither day nor version is in it, nor floating point; cantools' licence is."""
    made = [text for path, text in lookup.pages().items() if path.endswith((".c", ".h"))]
    assert len(made) == 2
    for text in made:
        licence, code = text.split("*/", 1)
        assert "The MIT License (MIT)" in licence and "THE SOFTWARE IS PROVIDED" in licence
        assert not re.search(r"cantools version|\b20[2-9]\d\b", text)
        assert not re.search(r"\b(double|float|20\d\d \d|version)\b|phys_range", code)
        assert "int camturn_state_pack(" in code
