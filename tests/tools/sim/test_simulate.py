"""The simulator in this process gives what the program writes, and leaves nothing behind."""

import json
import re
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError
from camtools.sim.binding import PROTOTYPES, SimSession
from camtools.sim.machine_file import Machine
from camtools.sim.results import STATES
from camtools.sim.simulate import Result, begun, simulate
from tests.tools.cases.camsim_cases import ROOT, camsim
from tests.tools.cases.part_cases import refused
from tests.tools.cases.prototypes import declared_in, named

HEADER = ROOT / "host_sim" / "api" / "sim_api.h"
ROUGH = ROOT / "host_sim" / "machines" / "rough.toml"
CUT = ("--rpm", "2500", "--turns-limit", "3")
# What the clock of this computer shows, in every summary.
CLOCK = re.compile(r'^\t"(wall_time_s|ticks_per_s)":.*$', re.MULTILINE)


def test_results_are_those_of_the_program(table: Path, tmp_path: Path) -> None:
    """Every number of the surface, and every 9th row of the trace; the summary is the same text."""
    surface, trace, summary = (tmp_path / f"{name}.csv" for name in ("a", "b", "c"))
    outs = ("--surface", surface, "--trace", trace, "--summary", summary)
    assert camsim("run", table, *CUT, "--machine", ROUGH, *outs).returncode in (0, 1)
    result = simulate(table, ROUGH, rpm=2500, turns=3, trace=True)
    read = np.loadtxt(surface, delimiter=",", skiprows=1)
    assert np.array_equal(result.surface.view(np.float64).reshape(read.shape), read)
    names, *lines = trace.read_text().splitlines()
    assert (",".join(result.trace.dtype.names or ()), result.trace.size) == (names, len(lines))
    number: dict[str, Callable[[str], float]] = {
        "state": STATES.index,
        "faults": lambda cell: int(cell, 16),
    }
    columns = zip(*(line.split(",") for line in lines[::9]), strict=True)
    for name, cells in zip(names.split(","), columns, strict=True):
        numbers = [number.get(name, float)(cell) for cell in cells]
        assert np.array_equal(result.trace[name][::9], numbers), name
    assert CLOCK.sub("", result.summary_text) == CLOCK.sub("", summary.read_text())
    assert simulate(table, rpm=2500, turns=1).trace.size == 0


def same(one: Result, other: Result) -> bool:
    """Return whether two cuts came to the same."""
    texts = [CLOCK.sub("", result.summary_text) for result in (one, other)]
    return texts[0] == texts[1] and one.surface.tobytes() == other.surface.tobytes()


def test_cut_leaves_nothing_behind(table: Path) -> None:
    """After cuts on another machine, with a fault and refused, the first one comes again."""
    first = simulate(table, rpm=2500, turns=3)
    simulate(table, "piezo", rpm=1500, turns=2, set={"k1_ns": 300000}, seed=7)
    fault = simulate(table, rpm=2500, turns=3, options=["--inject", "estop@0.01"])
    assert (fault.status, fault.summary["first_faults"]) == (1, ["estop"])
    assert "fault estop" in fault.message
    with pytest.raises(CamtoolsError, match="infeasible"):
        simulate(table, rpm=50000)
    assert same(first, simulate(table, rpm=2500, turns=3))


def test_machine_by_name_path_text_and_tables(table: Path) -> None:
    """A machine is given in four ways, and all of them cut the same."""
    tables = {"machine": {"name": "slow"}, "u": {"bandwidth_hz": 250}}
    text = '[machine]\nname = "slow"\n[u]\nbandwidth_hz = 250\n'
    by_text = simulate(table, Machine("slow.toml", text), rpm=2000, turns=2)
    assert same(by_text, simulate(table, tables, rpm=2000, turns=2))
    by_name = simulate(table, "rough", rpm=2000, turns=2)
    assert same(by_name, simulate(table, ROUGH, rpm=2000, turns=2))
    assert not same(by_name, by_text)


@pytest.mark.parametrize(
    ("words", "machine", "told"),
    [
        (["--trace", "t.csv"], None, "--trace: results come back in memory"),
        (["--no-such"], None, "unknown option"),
        ([], Machine("m.toml", "[u]\nbandwidth_hz = -1\n"), "m.toml: line 2: u.bandwidth_hz"),
        (["--machine", "x.toml"], Machine("m.toml", ""), "x.toml"),
        (["--set", "k1_ns=x"], None, "--set k1_ns=x"),
        (["--help"], None, "camsim run --help"),
    ],
)
def test_refusals_are_those_of_the_program(
    table: Path, words: list[str], machine: Machine | None, told: str
) -> None:
    """One line says what is wrong; the next cut is as ever."""
    assert told in refused(lambda: simulate(table, machine, options=words))
    assert simulate(table, rpm=2500, turns=1).status == 0


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"rpm": -1.0}, "rpm = -1.0: out of range"),
        ({"feed": 0.0}, "feed = 0.0: out of range"),
        ({"turns": -3.0}, "turns = -3.0: out of range"),
        ({"seed": -1}, "seed = -1: out of range"),
        ({"set": {"k1_ns": 10**12}}, "set: k1_ns = 1e+12: out of range"),
        ({"machine": "none"}, "machine = none: no such machine"),
        ({"options": ["--rpm", "-1"]}, "--rpm -1: out of range"),
    ],
)
def test_what_is_wrong_names_its_argument(table: Path, given: dict[str, Any], told: str) -> None:
    """A caller of simulate knows no options of camsim but those given."""
    assert refused(lambda: simulate(table, **given)).startswith(told)


def test_result_is_shown_in_one_line(table: Path) -> None:
    """In a notebook it is the last line of a cell; the surface has 15 000 rows."""
    shown = repr(simulate(table, rpm=2500, turns=1))
    assert re.fullmatch(r"<Result status 0, stopped, form error 0\.0\d+ um>", shown)


def test_second_session_is_refused_until_the_first_ends(table: Path) -> None:
    """Firmware and port are one per process."""
    with SimSession() as one, SimSession() as other:
        one.begin([str(table)])
        with pytest.raises(CamtoolsError, match="another cut is open"):
            other.begin([str(table)])
        one.close()
        other.begin([str(table)])
        assert other.progress() < 1e-3
        assert other.run(1000)
        assert 0 < other.progress() < 0.01


def test_cuts_of_other_threads_wait(table: Path) -> None:
    """Until the first one ends."""
    ended: list[float] = []

    def other() -> None:
        ended.append(simulate(table, rpm=2500, turns=1).status)

    thread = threading.Thread(target=other)
    with begun([str(table), *CUT]) as session:
        thread.start()
        session.run(1000)
        assert ended == []
    thread.join()
    assert ended == [0]


def test_prototypes_are_those_of_the_header() -> None:
    """Compare the arguments of every declaration with those that ctypes is told."""
    assert declared_in(HEADER, {}) == named(PROTOTYPES)


def test_progress_rises_to_the_end(table: Path) -> None:
    """The share that is done is told now and then."""
    told: list[float] = []
    result = simulate(table, rpm=2500, progress=told.append)
    assert told == sorted(told)
    assert 0 < told[-1] <= 1
    assert result.form_error_um == json.loads(result.summary_text)["form_error_um"]["max"]
