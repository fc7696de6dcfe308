# SPDX-License-Identifier: Apache-2.0
"""What the tests of force drives share."""

from collections.abc import Iterator

import pytest

from tests.tools.cases.drive_plant import designed


@pytest.fixture(scope="package", autouse=True)
def _loops() -> Iterator[None]:
    """Design the loop of a drive once."""
    with pytest.MonkeyPatch.context() as patch:
        for user in ("judgement", "proposal"):
            patch.setattr(f"camtools.tune.{user}.best", designed)
        yield
