# SPDX-License-Identifier: Apache-2.0
"""camsim bus refuses what is wrong before it touches anything; tests/linux shows what it does."""

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.tools.cases.camsim_cases import ROOT, camsim, only_error


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ((), "no --can"),
        (("--can",), "--can: value missing"),
        (("--can", "nocan7"), "nocan7: no such interface"),
        (("--can", "lo", "--rpm", "300"), "set it in the controller"),
        (("--can", "lo", "--set", "k1_ns=1"), "set it in the controller"),
        (("--can", "lo", "--sections", "s.csv"), "an option of camsim run only"),
        (("--can", "lo", "--tick-hz", "20"), "100 .. 4000"),
        (("--can", "lo", "--encoder-modulus", "100.5"), "not whole"),
        (("--can", "lo", "--without", "w"), "encoder, u, x, z or spindle"),
        (("--can", "lo", "--inject", "late-tick@0:100"), "cannot happen here"),
        (("--can", "lo", "--inject", "node-fault@0:1"), "a drive, 2 .. 5"),
        (("--can", "lo", "--inject", "fire@0"), "camsim bus --help"),
        (("--can", "lo", "--nonsense"), "bus: --nonsense: unknown option"),
    ],
)
def test_wrong_words_are_refused(
    words: tuple[str, ...], message: str, table_of: Callable[[str], Path], tmp_path: Path
) -> None:
    """One line that names what is wrong; no file is left."""
    outputs = ("--trace", tmp_path / "trace", "--summary", tmp_path / "summary")
    done = camsim("bus", table_of("perkins240"), *outputs, *words)
    assert message in only_error(done)
    assert list(tmp_path.iterdir()) == []


def test_missing_table_is_refused() -> None:
    """The message names the command and its help."""
    assert "bus: give one TABLE" in only_error(camsim("bus", "--can", "vcan0"))


def test_machine_that_takes_forces_is_refused(table_of: Callable[[str], Path]) -> None:
    """The drives on the bus close their own loops."""
    real = ROOT / "host_sim" / "machines" / "real.toml"
    done = camsim("bus", table_of("perkins240"), "--can", "vcan0", "--machine", real)
    assert "the drives on the bus take positions" in only_error(done)


def test_help_lists_the_options() -> None:
    """Help goes to standard output."""
    done = camsim("bus", "--help")
    assert done.returncode == 0 and "--gpiochip" in done.stdout


def test_faults_of_the_bus_cannot_happen_in_a_run(table_of: Callable[[str], Path]) -> None:
    """A run has no nodes that could die."""
    done = camsim("run", table_of("perkins240"), "--inject", "node-dead@0:2")
    assert "cannot happen here; camsim run --help" in only_error(done)
