"""The examples in the module docstrings are true, and every module has one."""

import doctest
import importlib
import pkgutil
from collections.abc import Iterator

import pytest

import camtools
import checks

# They show nothing without a bus, a whole program or a cut.
WITHOUT = {
    "camtools.cli.camctl",
    "camtools.link.download",
    "camtools.ngc.full_program",
}
# They draw in a page of a browser: tests/browser shows what they do. Their examples are true, too.
DRAWING = (
    *("camtools.panel.operate.", "camtools.panel.pages."),
    *("camtools.panel.page_frame", "camtools.panel.pieces"),
)


def modules() -> Iterator[str]:
    """Return the names of all modules of the packages, the packages themselves left out."""
    yield "camtools"
    for package in (camtools, checks):
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            if not module.ispkg:
                yield module.name


PLOTS = sorted(name for name in modules() if name.endswith("plots"))


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("name", sorted(set(modules()) - WITHOUT))
def test_module_example(name: str) -> None:
    """The module's docstring holds an example, and it gives what it says."""
    check_example(name)


@pytest.mark.long
@pytest.mark.parametrize("name", PLOTS)
def test_pictures_of_an_example_are_drawn(name: str) -> None:
    """Drawing refuses none of them."""
    check_example(name)


def check_example(name: str) -> None:
    """Run the example of a module."""
    result = doctest.testmod(importlib.import_module(name))
    assert result.attempted > 0 or name.startswith(DRAWING)
    assert result.failed == 0
