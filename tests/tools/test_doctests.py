"""The examples in the module docstrings are true."""

from __future__ import annotations

import doctest
import importlib

import pytest

MODULES = [
    "camtools",
    "accuracy",
    "csource",
    "cam_channels",
    "cam_check",
    "cam_contact",
    "cam_design",
    "cam_generate",
    "cam_lift",
    "cam_motion",
    "cam_plots",
    "cam_speed",
    "cam_summary",
    "cycles",
    "elf_flow",
    "elf_image",
    "elf_longest",
    "elf_loops",
    "elf_rules",
    "elf_sizes",
    "elf_stack",
    "elfcheck",
    "errors",
    "estimate",
    "evaluate",
    "feasibility",
    "flash",
    "generate",
    "geometry",
    "image",
    "misra",
    "mkgcode",
    "mktables",
    "ngc",
    "ngc_profile",
    "output",
    "part",
    "part_cam",
    "part_errors",
    "part_file",
    "path",
    "path_plots",
    "path_study",
    "pipeline",
    "plots",
    "quantise",
    "same_bytes",
    "search",
    "sections",
    "stepper",
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
