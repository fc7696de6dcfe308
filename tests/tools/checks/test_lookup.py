# SPDX-License-Identifier: Apache-2.0
"""The look-up pages of parameters and CAN messages are what their sources give."""

from camtools.base.project_paths import ROOT
from camtools.link.messages import DATABASE
from camtools.link.parameters import INFOS
from checks import lookup


def test_pages_are_what_the_sources_give() -> None:
    """After a change of parameters or messages the pages are written anew."""
    for name, text in lookup.pages().items():
        assert (ROOT / name).read_text("utf-8") == text, f"{name}: checks.lookup --write"


def test_no_parameter_and_no_message_is_missing() -> None:
    """Every parameter has one row."""
    parameters, messages = lookup.pages().values()
    names = {f"| `{name}` |" for name in INFOS}
    assert {name for name in names if parameters.count(name) != 1} == set()
    assert {m.name for m in DATABASE.messages if f"\n## {m.name}, 0x" not in messages} == set()
    assert "| -21 | `param_range` |" in messages
