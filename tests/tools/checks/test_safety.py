"""The safety case: its pages are what its source says, and what it names is there."""

from typing import Any

import pytest

from checks.safety import SOURCE, pages, problems, read_case


@pytest.fixture(scope="module")
def case() -> dict[str, Any]:
    """Return the safety case of the project."""
    return read_case()


def test_pages_are_what_the_source_says(case: dict[str, Any]) -> None:
    """Whoever changes the source, or a figure, writes the pages anew."""
    assert problems(case) == []
    for name, text in pages(case).items():
        assert (SOURCE.parent / name).read_text(encoding="utf-8") == text, name
