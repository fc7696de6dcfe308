"""What the tests of the simulator share."""

from collections.abc import Callable
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def table(table_of: Callable[[str], Path]) -> Path:
    """Return the table of the Perkins 240 skirt, its report beside it."""
    return table_of("perkins240")


@pytest.fixture(scope="session")
def oval30(table_of: Callable[[str], Path]) -> Path:
    """Return the table of an oval with 1 mm of tool motion, its report beside it."""
    return table_of("oval30")
