"""What resolutions cost is what the documents say, and what the equations let expect."""

from pathlib import Path

import pytest

from tests.bench import resolution
from tests.bench.resolution import DEFAULT, PORTS, ROWS, Shape, bound_um, cut_row_um, cut_um

Lines = list[list[str]]


@pytest.fixture(scope="module")
def table(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the table of the part, with its report beside it."""
    return resolution.make_table(tmp_path_factory.mktemp("resolution"))


@pytest.fixture(scope="module")
def shape(table: Path) -> Shape:
    """Return what the bounds need of the part."""
    return resolution.shape_of(table)


def recorded(name: str) -> Lines:
    """Return the cells of a document's table, without its head."""
    lines = resolution.recorded(name)[1].splitlines()[2:]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


@pytest.mark.long
def test_the_first_table_is_recorded(table: Path, shape: Shape) -> None:
    """Every row is what camsim and its equation give: `tests/bench/resolution --record`."""
    found = []
    for row in ROWS:
        bound = bound_um(row, shape)
        right = "-" if bound is None else f"{bound:.3f}"
        found.append([row.what, row.value, f"{cut_row_um(table, row):.3f}", right])
    assert found == recorded("resolution")


def test_bounds_hold() -> None:
    """No row is worse than its bound and what is left anyway; those of X and the delay are met."""
    (_, _, left_um, _), *rows = recorded("resolution")
    for what, value, found, bound in rows:
        limit_um = float(bound) * (1.35 if what == "tick" else 1.02) + float(left_um) + 0.001
        assert float(found) <= limit_um, (what, value)
        if what in {"step of X", "delay not in lead_ns", "tick"}:
            share = 0.6 if what == "tick" else 0.8
            assert float(found) >= share * float(bound), (what, value)


@pytest.mark.long
@pytest.mark.parametrize(("port", "rpm"), [(0, 2500), (1, 1000), (4, 2500)])
def test_ports_are_recorded(table: Path, port: int, rpm: int) -> None:
    """Some cells of the second table; the command that writes it makes them all."""
    name, keys = PORTS[port]
    cells = next(line for line in recorded("ports") if line[0] == name)
    column = 1 + resolution.SPEEDS.index(rpm)
    assert cells[column] == f"{cut_um(table, {**DEFAULT, **keys}, rpm):.2f}"
