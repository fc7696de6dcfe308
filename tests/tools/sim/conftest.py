"""What the tests of the simulator share."""

from pathlib import Path

import pytest

from tests.tools.cases.part_cases import TableOf


@pytest.fixture(scope="session")
def table(table_of: TableOf) -> Path:
    """Return the table of the Perkins 240 skirt, its report beside it."""
    return table_of("perkins240")


@pytest.fixture(scope="session")
def oval30(table_of: TableOf) -> Path:
    """Return the table of an oval with 1 mm of tool motion, its report beside it."""
    return table_of("oval30")
