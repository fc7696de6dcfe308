# SPDX-License-Identifier: Apache-2.0
"""`camsim params`: what the controller is configured with."""

from pathlib import Path

import pytest

from camtools.link.messages import NUMBERS
from tests.tools.cases.camsim_cases import camsim, only_error


def test_every_parameter_is_there(table: Path, tmp_path: Path) -> None:
    """In the order of the list, behind the tick rate; what is set counts."""
    machine = tmp_path / "m.toml"
    machine.write_text("[machine]\ntick_hz = 25000\n[controller]\nk1_ns = 700000\n", "ascii")
    done = camsim("params", table, "--machine", machine, "--set", "lead_ns=5000")
    assert done.returncode == 0, done.stderr
    header, *rows = done.stdout.splitlines()
    found = dict(row.split(",") for row in rows)
    assert header == "name,value"
    assert list(found) == ["tick_hz", "planned_turns", "planned_s", *NUMBERS["parameter"]]
    # 62 mm at 0.1 mm, and half of the feed's ramp of 30 turns at each end.
    assert found["planned_turns"] == "680"
    assert (found["tick_hz"], found["k1_ns"], found["lead_ns"]) == ("25000", "700000", "5000")


def test_what_has_no_meaning_is_refused(table: Path) -> None:
    """Outputs of a run and bad parameters, one line each."""
    says = {
        ("--summary", "s.json"): "params: s.json: an output of camsim run; leave it out",
        ("--set", "k1_ns=-1"): "k1_ns = -1: out of range",
    }
    for words, said in says.items():
        assert said in only_error(camsim("params", table, *words))


@pytest.mark.parametrize("mass_kg", [0.2, 10, 40])
def test_loop_of_any_slide_fits_the_controller(table: Path, tmp_path: Path, mass_kg: float) -> None:
    """The loop that follows from a force drive, however heavy, is accepted."""
    machine = tmp_path / "m.toml"
    drive = f'[u]\nkind = "force"\nmass_kg = {mass_kg}\ndelay_us = 5\namplifier_hz = 3000\n'
    limits = "acceleration_mm_per_s2 = 50000\nforce_limit_n = 3000\n"
    machine.write_text(drive + limits, "ascii")
    done = camsim("run", table, "--machine", machine, "--feed", "1", "--turns-limit", "1")
    assert "refused" not in done.stderr
    assert done.returncode == 0, done.stderr
