"""The examples in the module docstrings are true."""

from __future__ import annotations

import doctest
import importlib

import pytest

MODULES = [
    "camtools",
    "accuracy",
    "csource",
    "errors",
    "estimate",
    "evaluate",
    "feasibility",
    "flash",
    "generate",
    "geometry",
    "image",
    "mktables",
    "output",
    "part",
    "part_errors",
    "plots",
    "quantise",
    "search",
    "sections",
    "summary",
    "trade",
]


@pytest.mark.parametrize("name", MODULES)
def test_module_example(name: str) -> None:
    """The module's docstring holds an example, and it gives what it says."""
    module = importlib.import_module(name if name == "camtools" else f"camtools.{name}")
    result = doctest.testmod(module)
    assert result.attempted > 0
    assert result.failed == 0
