"""The kernel, the part and the programs that all tests here share."""

import os
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from tests.linux.kernel import (
    CONTROLLER,
    FEED_MM,
    MACHINE_FILE,
    BrokenKernelError,
    InProcess,
    Kernel,
    NoKernelError,
    Result,
    find_kernel,
)
from tests.tools.cases.camsim_cases import CAMSIM

BUSY = -25  # cam_err_busy
CONFIG = """\
[thread]
tick_hz = 1000
[can]
interface = "vcan0"
[table]
file = "{out}/table.camtab"
[operator]
acknowledge = "waived"
key = "KEY"
"""


@pytest.fixture(scope="session")
def kernel() -> Kernel:
    """Return the kernel; without one the tests are skipped, but not where it is to be built."""
    assert CONTROLLER.exists(), f"{CONTROLLER} is missing: build the preset linux"
    try:
        return find_kernel()
    except NoKernelError as err:
        if os.environ.get("CAMTURN_KERNEL") == "build":
            raise
        pytest.skip(f"no kernel with vcan and gpio-sim: {err}")
    except BrokenKernelError as err:
        pytest.fail(str(err), pytrace=False)


@pytest.fixture(scope="session")
def in_process(
    table_of: Callable[[str], Path], tmp_path_factory: pytest.TempPathFactory
) -> InProcess:
    """Cut the part in the simulator's own process once."""
    return InProcess(table_of("perkins240"), tmp_path_factory.mktemp("in_process"))


@pytest.fixture
def play(
    kernel: Kernel, table_of: Callable[[str], Path], in_process: InProcess, tmp_path: Path
) -> Callable[..., Result]:
    """Return a function that plays a scenario in a folder of its own."""
    table = table_of("perkins240")

    def run(
        scenario: str,
        *machine_words: str,
        folder: str = "out",
        feed_mm: float = FEED_MM,
        parameters: Mapping[str, int] | None = None,
        other_part: str = "perkins240",
        killed_after_s: float = 0.1,
    ) -> Result:
        out = tmp_path / folder
        out.mkdir()
        shutil.copy(table, out / "table.camtab")
        (out / "camturn.toml").write_text(CONFIG.format(out=out))
        values = in_process.summary["parameters"] | {"feed_nm": round(feed_mm * 1e6)}
        values |= parameters or {}
        setup = {
            "out": str(out),
            "camsim": str(CAMSIM),
            "controller": str(CONTROLLER),
            "table": str(table),
            "other_table": str(table_of(other_part)),
            "machine": str(MACHINE_FILE),
            "machine_words": machine_words,
            "parameters": list(values.values()),
            "busy": BUSY,
            "killed_after_s": killed_after_s,
        }
        result = kernel.play(scenario, setup)
        assert result.status == 0, result.report()
        return result

    return run
