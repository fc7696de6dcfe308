# SPDX-License-Identifier: Apache-2.0
"""What the tests of skirts share."""

import pytest

from camtools.skirt.table.generate import GeneratedSkirt
from tests.tools.cases.cut_cases import skirt_of


@pytest.fixture(scope="session")
def modulated() -> GeneratedSkirt:
    """Return the table of the part that is turned with an even removal rate."""
    return skirt_of("perkins240_equal_volume")
