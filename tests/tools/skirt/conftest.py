"""What the tests of skirts share."""

import pytest

from camtools.skirt.table.generate import GeneratedSkirt, generate
from tests.tools.cases.part_cases import ROOT, load_part


@pytest.fixture(scope="session")
def modulated() -> GeneratedSkirt:
    """Return the table of a short part that is turned with an even removal rate."""
    return generate(load_part(ROOT / "tests" / "scenarios" / "cases" / "parts" / "modulated.toml"))
