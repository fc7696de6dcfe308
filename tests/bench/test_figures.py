"""FIGURES.md has the recorded figures, and the record is what is measured."""

import pytest

from tests.bench import figures
from tests.bench.figures import (
    CASES,
    CORES,
    PAGE,
    TEMPLATE,
    Case,
    core_figures,
    decimals,
    measure,
    recorded,
)

OF_ONE_SKIRT = [case for case in CASES if case.part == "perkins240"]


def test_the_page_has_what_is_recorded() -> None:
    """Every figure of the record is on the page; figures.py writes it."""
    assert set(decimals(TEMPLATE.read_text())) == set(recorded())
    assert PAGE.read_text() == figures.page(), "run tests/bench/figures.py"


def _assert_recorded(measured: dict[str, float]) -> None:
    """Compare to half of the last digit of the page: processors differ beyond it."""
    known, shown = recorded(), decimals(TEMPLATE.read_text())
    changed = {
        key: f"{value}, recorded {known[key]}"
        for key, value in measured.items()
        if abs(value - known[key]) > 0.5 * 10.0 ** -shown[key]
    }
    assert not changed


@pytest.mark.long
@pytest.mark.parametrize("case", OF_ONE_SKIRT, ids=lambda case: case.name)
def test_the_simulator_still_gives_the_recorded_figures(case: Case) -> None:
    """Table and cut of a case come out as recorded, on any machine.

    Cuts of cams and larger pistons take minutes: figures.py measures them for the record, and tests
    of their kinds judge them by their drawings.
    """
    _assert_recorded(measure(case))


@pytest.mark.long
@pytest.mark.parametrize("core", CORES)
def test_the_cores_still_give_the_recorded_figures(core: str) -> None:
    """The budget tests of the emulated cores counted what is recorded."""
    _assert_recorded(core_figures(core))
