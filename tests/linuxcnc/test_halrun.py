"""The HAL component in LinuxCNC's own threads: the same cut, handshake, faults, refusals."""

import re
import time
from pathlib import Path

import numpy as np
import pytest

from checks.patience import limit_s
from tests.linuxcnc.halbox import Halbox
from tests.linuxcnc.replays import COMMANDED, Cut, Whole, cut, replay
from tests.tools.cases.part_cases import ROOT, TableOf

pytest_plugins = ["tests.linuxcnc.halrun_fixtures"]

HERE = ROOT / "hal" / "linuxcnc"
IN_HAL = r"camturn\.(?!comp\b|so\b)([a-z][a-z0-9-]*)"
LOAD = "loadrt camturn table={} tick_hz=1000\n"
THREAD = "loadrt threads name1=servo period1=1000000\naddf camturn.update servo\n"
ENABLED, FAULT, IN_CUT = 1, 2, 4  # bits of the outputs


def differences(found: Whole, recorded: Cut) -> str:
    """Return "" when every command of every tick is the same, else the first that is not."""
    due = recorded.commanded
    if found.shape == due.shape and bool((found == due).all()):
        return ""
    n = min(len(found), len(due))
    tick, column = np.argwhere(found[:n] != due[:n])[0] if n else (0, 0)
    return f"{len(found)} of {len(due)} ticks; tick {tick}: {COMMANDED[column]} is {found[tick]}"


@pytest.mark.parametrize("tick_hz", [1000, pytest.param(20000, marks=pytest.mark.long)])
def test_every_command_of_a_cut_is_that_of_camsim(
    box: Halbox, table_of: TableOf, tmp_path: Path, tick_hz: int
) -> None:
    """Enable, homing, engaging, cutting, stop (M65), disengaging: to the bit, at both ends."""
    machine = tmp_path / "machine.toml"
    machine.write_text(f"[machine]\ntick_hz = {tick_hz}\n")
    words = ("--machine", machine, "--rpm", "1000", "--turns-limit", "3")
    recorded = cut(table_of("perkins240"), tmp_path, *words)
    found = replay(box, recorded)
    assert differences(found, recorded) == ""
    in_cut = (found[:, -1] & IN_CUT) != 0
    assert [state == "cutting" for state in recorded.states] == in_cut.tolist()


@pytest.mark.long
def test_fault_is_that_of_camsim_and_is_said(
    box: Halbox, table_of: TableOf, tmp_path: Path
) -> None:
    """The emergency stop opens in the cut: the same retract and end, and a line for people."""
    words = ("--rpm", "1000", "--inject", "estop@0.05")
    recorded = cut(table_of("perkins240"), tmp_path, *words)
    found = replay(box, recorded)
    assert differences(found, recorded) == ""
    assert found[-1, -1] & (ENABLED | FAULT) == FAULT
    box.wait_said("camturn: fault estop: ")


FORCE = "u_force_quantum_un=20000 u_force_latency_ns=75000"


@pytest.mark.long
@pytest.mark.parametrize("fault", ["", "u-limit@0.05:1", "u-limit@0.05:-1"])
def test_force_of_u_is_that_of_camsim(
    box: Halbox, table_of: TableOf, tmp_path: Path, fault: str
) -> None:
    """Every force of a cut to the bit; a limit switch ends it by its fault."""
    machine = tmp_path / "machine.toml"
    machine.write_text('[u]\nkind = "force"\n')
    words = ("--machine", machine, "--rpm", "1000", "--turns-limit", "3")
    recorded = cut(table_of("perkins240"), tmp_path, *words, *(fault and ("--inject", fault)))
    found = replay(box, recorded, more=FORCE)
    assert np.abs(found[:, COMMANDED.index("out_force_q6")]).max() > 64 * 10_000
    assert differences(found, recorded) == ""
    if fault:
        box.wait_said("camturn: fault u_travel: ")
    assert bool(fault) or "camturn: fault u_travel" not in box.said()  # then the scale stands


def test_what_cannot_work_is_refused(box: Halbox, table_of: TableOf) -> None:
    """The component does not load, and prints what to give."""
    (box.folder / "part.camtab").write_bytes(table_of("perkins240").read_bytes())
    damaged = bytearray(table_of("perkins240").read_bytes())
    damaged[len(damaged) // 2] ^= 1
    (box.folder / "damaged.camtab").write_bytes(damaged)
    for words, said in (
        ("u_force_quantum_un=20000 measures_u=0",
         "u_force_quantum_un=20000: needs the scale of U; connect u-fb and"),
        ("u_force_quantum_un=1000001",
         "u_force_quantum_un=1000001: out of range; give 0 .. 1000000"),
        ("u_force_latency_ns=-1", "u_force_latency_ns=-1: out of range; give 0 .. 10000000"),
        ("table=/nowhere/part.camtab",
         "table=/nowhere/part.camtab: No such file or directory; give"),
        ("table=", "table=: no table is given; loadrt camturn table="),
        ("table=./damaged.camtab", "./damaged.camtab: refused: "),
    ):  # fmt: skip
        table = "" if "table=" in words else "table=./part.camtab "
        line = f"loadrt camturn {table}{words}".removesuffix(" table=")
        assert box.load(f"{line} tick_hz=1000\n") != 0, words
        assert f"camturn: {said}" in box.said()


def set_and_wait(box: Halbox, pin: str, status: str, says: str = "") -> None:
    """Give a command by its rising edge, again if a busy machine misses it; wait for its end."""
    for _ in range(20):
        for value in (0, 1):
            assert box.load(f"setp camturn.{pin} {value}\n") == 0
            time.sleep(limit_s(0.05))  # a hundred rounds of the slow side
        box.wait(f"camturn.{status}", "FALSE")
        if says in box.said():
            return
    raise AssertionError(box.said())


@pytest.mark.long
def test_table_is_changed_while_hal_runs(box: Halbox, table_of: TableOf) -> None:
    """The file is read again on request: another table is used, a damaged one refused."""
    part = box.folder / "part.camtab"
    good = table_of("perkins240").read_bytes()
    part.write_bytes(good)
    part.chmod(0o644)
    assert box.load(LOAD.format(part) + THREAD + "addf camturn.poll servo\nstart\n") == 0
    part.write_bytes(table_of("perkins240_x30").read_bytes())
    set_and_wait(box, "reload-table", "reloading")
    assert box.get("camturn.error-number") == "0"
    part.write_bytes(good[:-1])
    set_and_wait(box, "reload-table", "reloading", "camturn: table: refused: ")
    part.unlink()
    set_and_wait(box, "reload-table", "reloading", "No such file or directory")


def names_in_documents() -> set[str]:
    """Return what documents and samples name: camturn.NAME, and `NAME` in tables of pins."""
    files = [*HERE.glob("*.md"), HERE.parent / "RETROFIT.md", *HERE.glob("*/*.hal")]
    named = {name for file in files for name in re.findall(IN_HAL, file.read_text())}
    pins = (HERE / "README.md").read_text().split("## Pins")[1].split("**Parameters**")[0]
    rows = re.findall(r"^\|([^|]*)\|", pins + (HERE / "ETHERCAT.md").read_text(), re.MULTILINE)
    return named | {name for row in rows for name in re.findall(r"`([a-z][a-z0-9-]+)`", row)}


def test_names_in_documents_are_those_of_the_component(box: Halbox, table_of: TableOf) -> None:
    """Pins, parameters and functions in README, ETHERCAT and the samples."""
    (box.folder / "part.camtab").write_bytes(table_of("perkins240").read_bytes())
    assert box.load(LOAD.format("./part.camtab")) == 0, box.said()
    shown = "".join(box.ask("-s", "show", kind) for kind in ("pin", "param", "funct"))
    there = set(re.findall(IN_HAL, shown))
    assert {"u-cmd", "u-acc", "lead-ns", "update"} <= there
    assert names_in_documents() - there == set()


@pytest.mark.long
def test_thread_at_another_rate_is_an_open_emergency_stop(box: Halbox, table_of: TableOf) -> None:
    """The first enable is refused, and a line names both rates."""
    (box.folder / "part.camtab").write_bytes(table_of("perkins240").read_bytes())
    load = LOAD.format("./part.camtab").replace("1000", "5000")
    wire = "setp camturn.estop-ok 1\nsetp camturn.drive-ready 1\n"
    start = "addf camturn.poll servo\nstart\nsetp camturn.enable 1\n"
    assert box.load(load + THREAD + wire + start) == 0, box.said()
    box.wait("camturn.error-number", "-27")
    box.wait_said("has a period of 1000000 ns, but tick_hz = 5000 was given")
    box.wait_said("camturn: enable: refused: ")
    assert box.get("camturn.state-number") == "0"


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "whole", "rest", "pin"),
    [("x_trim_nm", 100000, 20000, "x-trim 0.08"), ("phase_udeg", 33000000, 3000000, "phase 30")],
)
def test_trims_are_added_to_parameters(
    box: Halbox, table_of: TableOf, tmp_path: Path, name: str, whole: int, rest: int, pin: str
) -> None:
    """A cut with a part of the value by the pin is that of camsim with the whole parameter."""
    words = ("--rpm", "1000", "--turns-limit", "3", "--set", f"{name}={whole}")
    recorded = cut(table_of("perkins240"), tmp_path, *words)
    recorded.params[name] = rest
    found = replay(box, recorded, pins=f"setp camturn.{pin}\n")
    assert differences(found, recorded) == ""


@pytest.mark.long
def test_parameter_out_of_range_is_set_back(box: Halbox, table_of: TableOf) -> None:
    """A value that is refused does not stay where people read it."""
    (box.folder / "part.camtab").write_bytes(table_of("perkins240").read_bytes())
    start = "addf camturn.poll servo\nstart\nsetp camturn.lead-ns -1\n"
    assert box.load(LOAD.format("./part.camtab") + THREAD + start) == 0, box.said()
    box.wait("camturn.lead-ns", "100000")
    box.wait_said("camturn: lead_ns = -1: refused: ")
    box.wait_said("; give 0 .. 20000000")
    assert box.load("setp camturn.x-trim 5\n") == 0
    box.wait("camturn.x-trim-nm", "-5000000")
    box.wait_said("camturn: x_trim_nm = 5000000: refused: ")
