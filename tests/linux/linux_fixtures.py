# SPDX-License-Identifier: Apache-2.0
"""The kernel, the part and the programs that all tests here share."""

import json
import os
import shutil
import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import pytest

from tests.linux.inside import SECRET
from tests.linux.kernel import (
    CONTROLLER,
    END_S,
    FEED_MM,
    MACHINE_FILE,
    BrokenKernelError,
    InProcess,
    Kernel,
    NoKernelError,
    PortTests,
    Result,
    find_kernel,
)
from tests.tools.cases.camsim_cases import CAMSIM

BUSY = -25  # cam_err_busy
LINES = ("estop", "ready", "index", "enable", "fault", "in_cut")
PORT_TEST, PORT_LIMIT_S = "test_own_tests_of_the_port", 400
PORT_FILES = ("tests/linux/test_linux_port.py", "tests/linux/test_linux_set_up.py")
Config = Mapping[str, Mapping[str, str | int | bool]]


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
    except BrokenKernelError as err:
        pytest.fail(str(err), pytrace=False)


@pytest.fixture(scope="session", autouse=True)
def port_tests(
    request: pytest.FixtureRequest, kernel: Kernel, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[PortTests | None]:
    """Start the tests of PORT_FILES inside, where they are wanted, beside all others."""
    if not kernel.is_own or not any(PORT_TEST in item.name for item in request.session.items):
        yield None
        return
    folder = tmp_path_factory.mktemp("port")
    report = folder / "port.xml"
    words = ("-m", "pytest", "-p", "no:cacheprovider", "-c", "tools/pyproject.toml", "-q")
    # Not where those of a user outside may lie, whom root inside cannot pass over.
    what = (*PORT_FILES, f"--junitxml={report}", "--basetemp=/run/port-tests")
    process = kernel.start(folder, sys.executable, *words, *what, limit_s=PORT_LIMIT_S)
    yield PortTests(process, report, PORT_LIMIT_S)
    process.terminate()
    process.wait(END_S)


@pytest.fixture(scope="session")
def in_process(
    table_of: Callable[[str], Path], tmp_path_factory: pytest.TempPathFactory
) -> InProcess:
    """Cut the part in the simulator's own process once."""
    return InProcess(table_of("perkins240"), tmp_path_factory.mktemp("in_process"))


def config_text(config: Config) -> str:
    """Return a configuration file of camturn-linux."""
    lines = []
    for section, keys in config.items():
        lines += [f"[{section}]", *(f"{key} = {json.dumps(value)}" for key, value in keys.items())]
    return "\n".join(lines) + "\n"


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
        config: Config | None = None,
        parameters: Mapping[str, int] | None = None,
        other_part: str = "perkins240",
        second_node: int = 64,
        killed_after_s: float = 0.1,
        is_virtual: bool = True,
    ) -> Result:
        out = tmp_path / folder
        out.mkdir()
        shutil.copy(table, out / "table.camtab")
        base: Config = {
            "thread": {"tick_hz": 1000},
            "can": {"interface": "vcan0"},
            "table": {"file": f"{out}/table.camtab"},
            "operator": {"acknowledge": "waived", "secret": f"{out}/secret"},
        }
        (out / "secret").write_text(SECRET)
        (out / "secret").chmod(0o600)
        alone: Config = {"encoder": {"index": "position"}, "gpio": dict.fromkeys(LINES, "none")}
        (out / "camturn.toml").write_text(config_text({**base, **(config or {})}))
        second = {**base, **alone, "can": {**base["can"], "node": second_node}}
        (out / "second.toml").write_text(config_text(second))
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
            "second_node": second_node,
            "killed_after_s": killed_after_s,
        }
        result = kernel.play(scenario, setup, is_virtual=is_virtual)
        assert result.status == 0, result.report()
        return result

    return run
