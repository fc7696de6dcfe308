# SPDX-License-Identifier: Apache-2.0
"""The DBC's lists and the look-up pages of parameters and messages are what their sources give."""

import pytest

from camtools.base.errors import CamtoolsError
from camtools.base.project_paths import ROOT
from camtools.link.messages import DATABASE
from camtools.link.parameters import INFOS
from checks import dbc_lists, lookup


def test_pages_are_what_the_sources_give() -> None:
    """After a change of parameters or messages the pages are written anew."""
    for name, text in lookup.pages().items():
        assert (ROOT / name).read_text("utf-8") == text, f"{name}: checks.lookup --write"


def test_no_parameter_and_no_message_is_missing() -> None:
    """Every parameter has one row."""
    _, parameters, messages = lookup.pages().values()
    names = {f"| `{name}` |" for name in INFOS}
    assert {name for name in names if parameters.count(name) != 1} == set()
    assert {m.name for m in DATABASE.messages if f"\n## {m.name}, 0x" not in messages} == set()
    assert "| -21 | `param_range` |" in messages


def test_lists_of_the_dbc_are_written_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    """New parameters, errors and faults come in; a list without a place is refused."""
    more = (
        dbc_lists.headers()
        .replace(
            " X(counts_per_turn,",
            ' X(new_nm, 0, 0, 1, 0, "x") \\\n    X(counts_per_turn,',
        )
        .replace(" X(image_size, ", ' X(new_error, -99, "new") \\\n X(image_size, ')
        .replace(" X(estop, ", ' X(new_fault, "a new fault") X(estop, ')
    )
    dbc = dbc_lists.dbc_text(more)
    assert dbc.count(' parameter 0 "new_nm" 1 "counts_per_turn"') == 2
    assert dbc.count('-99 "new_error"') == 2
    assert " SG_ fault_new_fault : 32|1@1+" in dbc and " SG_ fault_estop : 33|1@1+" in dbc
    assert 'CM_ SG_ 448 fault_new_fault "A new fault.";' in dbc
    monkeypatch.setattr(dbc_lists, "DBC", "firmware/PARAMETERS.md")
    with pytest.raises(CamtoolsError, match="places"):
        dbc_lists.dbc_text(more)
