"""The kernel for the Linux port: this computer's, or one of our own."""

from pathlib import Path

import pytest

from tests.linux.kernel import Kernel

pytest_plugins = ["tests.linux.linux_fixtures"]


@pytest.mark.kernel
def test_kernel_runs_a_command(kernel: Kernel, tmp_path: Path) -> None:
    """It has both CAN interfaces and the chip with the lines."""
    process = kernel.start(tmp_path, "sh", "-c", "ls /sys/class/net; cat $CAMTURN_GPIOSIM/*/value")
    said, _ = process.communicate()
    assert process.returncode == 0, said
    assert {"vcan0", "vcan1", "0"} <= set(said.split())
