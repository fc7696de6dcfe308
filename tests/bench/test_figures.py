# SPDX-License-Identifier: Apache-2.0
"""Every figure that a document quotes is the recorded one, and the record is what is measured."""

from __future__ import annotations

import doctest

import figures
import pytest
from figures import CASES, CORES, Case, core_figures, documents, measure, printed, quotes, recorded


def test_examples_are_true() -> None:
    """What the examples of the module show is what it does."""
    result = doctest.testmod(figures)
    assert result.attempted
    assert not result.failed


def test_documents_quote_what_is_recorded() -> None:
    """A number with a key is the record's, to the digits that are printed."""
    known = recorded()
    wrong = [
        f"{document.name}: {key} is {printed(number, known[key])}, not {number}"
        for document in documents()
        for number, key in quotes(document.read_text())
        if printed(number, known[key]) != number
    ]
    assert not wrong, f"{wrong}; tests/bench/figures.py mends the documents"


def test_every_recorded_figure_is_quoted() -> None:
    """Nothing is recorded that no document tells, and no document tells what is not recorded."""
    quoted = {key for document in documents() for _, key in quotes(document.read_text())}
    assert quoted == set(recorded())


def _assert_recorded(measured: dict[str, float]) -> None:
    """Compare to half of the last digit that a document prints: processors differ beyond it."""
    decimals = {
        key: len(number.partition(".")[2])
        for document in documents()
        for number, key in quotes(document.read_text())
    }
    known = recorded()
    changed = {
        key: f"{value}, recorded {known[key]}"
        for key, value in measured.items()
        if abs(value - known[key]) > 0.5 * 10.0 ** -decimals[key]
    }
    assert not changed


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_the_simulator_still_gives_the_recorded_figures(case: Case) -> None:
    """Table and cut of a case come out as recorded, on any machine."""
    _assert_recorded(measure(case))


@pytest.mark.parametrize("core", CORES)
def test_the_cores_still_give_the_recorded_figures(core: str) -> None:
    """The budget tests of the emulated cores counted what is recorded."""
    _assert_recorded(core_figures(core))
