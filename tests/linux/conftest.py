# SPDX-License-Identifier: Apache-2.0
"""The kernel, the part and the programs that all tests here share."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from camsim_cases import CAMSIM
from kernel import CONTROLLER, MACHINE_FILE, InProcess, Kernel, NoKernelError, Result, find_kernel

BUSY = -25  # cam_err_busy


@pytest.fixture(scope="session")
def kernel() -> Kernel:
    """Return the kernel; without one the tests are skipped, but not where CI runs them."""
    assert CONTROLLER.exists(), f"{CONTROLLER} is missing: build the preset linux"
    try:
        return find_kernel()
    except NoKernelError as err:
        if os.environ.get("CI"):
            raise
        pytest.skip(f"no kernel with vcan and gpio-sim: {err}")


@pytest.fixture(scope="session")
def in_process(
    table_of: Callable[[str], Path], tmp_path_factory: pytest.TempPathFactory
) -> InProcess:
    """Cut the part in the simulator's own process once."""
    return InProcess(table_of("perkins240"), tmp_path_factory.mktemp("in_process"))


def config_text(folder: Path, **values: Any) -> str:
    """Return a configuration file; values are given as section__key."""
    settings: dict[str, dict[str, Any]] = {
        "can": {"interface": "vcan0"},
        "table": {"file": str(folder / "table.camtab")},
    }
    for name, value in values.items():
        section, key = name.split("__")
        settings.setdefault(section, {})[key] = value
    lines = []
    for section, keys in settings.items():
        lines += [f"[{section}]", *(f"{key} = {json.dumps(value)}" for key, value in keys.items())]
    return "\n".join(lines) + "\n"


@pytest.fixture
def play(
    kernel: Kernel, table_of: Callable[[str], Path], in_process: InProcess, tmp_path: Path
) -> Callable[..., Result]:
    """Return a function that plays a scenario in a folder of its own."""
    table = table_of("perkins240")

    def run(scenario: str, *machine_words: str, folder: str = "out", **options: Any) -> Result:
        out = tmp_path / folder
        out.mkdir()
        shutil.copy(table, out / "table.camtab")
        setup = {
            "out": str(out),
            "camsim": str(CAMSIM),
            "controller": str(CONTROLLER),
            "table": str(table),
            "machine": str(MACHINE_FILE),
            "machine_words": machine_words,
            "parameters": list(in_process.summary["parameters"].values()),
            "busy": BUSY,
        }
        config = config_text(out, **options.pop("config", {}))
        result = kernel.play(scenario, setup, config, **options)
        assert result.status == 0, result.message + "\n" + (out / "result.json").read_text()
        return result

    return run
