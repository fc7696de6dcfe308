"""What the tests of force drives share."""

from collections.abc import Iterator

import pytest

from tests.tools.cases.command_cases import undraw
from tests.tools.cases.drive_plant import designed


@pytest.fixture(scope="module", autouse=True)
def _loops() -> Iterator[None]:
    """Design the loop of a drive once; leave pictures empty, which a module's example draws."""
    with pytest.MonkeyPatch.context() as patch:
        undraw(patch)
        patch.setattr("camtools.tune.judgement.best", designed)
        yield
