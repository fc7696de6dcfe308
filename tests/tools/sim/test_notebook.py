"""The notebook of the documentation runs and prints what it shows."""

import re
from typing import Any

import pytest

from tests.tools.cases.camsim_cases import ROOT
from tests.tools.cases.notebook_cases import code_cells, kept, printed

NOTEBOOK = ROOT / "tools" / "docs" / "SIMULATE.ipynb"
NUMBER = re.compile(r"-?\d+\.\d+")


def test_notebook_prints_what_it_shows() -> None:
    """Word for word; decimal numbers within a tenth, since better control changes them."""
    space: dict[str, Any] = {}
    _, cells = code_cells(NOTEBOOK)
    assert len(cells) >= 5
    for cell in cells:
        found, shown = printed(cell["source"], space), kept(cell)
        assert NUMBER.sub("#", found) == NUMBER.sub("#", shown)
        ours = [float(word) for word in NUMBER.findall(found)]
        theirs = [float(word) for word in NUMBER.findall(shown)]
        assert ours == pytest.approx(theirs, rel=0.1, abs=0.1)


def test_notebook_is_small() -> None:
    """No pictures as text: 20 kB at most."""
    assert NOTEBOOK.stat().st_size < 20_000
