# SPDX-License-Identifier: Apache-2.0
"""The command: draws, cuts, tells; goes on where it was stopped; refuses in one line."""

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from camtools.base.errors import CamtoolsError
from camtools.cli.forecast import main
from camtools.forecast import parallel_cuts
from camtools.forecast.job import ForecastPlan, Question, plan_of
from camtools.forecast.one_cut import CutOutcome, cut_batch
from camtools.forecast.parallel_cuts import cut_all
from camtools.forecast.store import Store
from camtools.sim.simulate import simulate
from tests.tools.cases.background import PATIENCE_S
from tests.tools.cases.part_cases import PERKINS, environment

CUT = ("--turns", "2", "--workers", "1")
LEARNING = ("rehearse_turns", "learn_harmonics", "ripple_turns")
LAG = '[u.delay_us]\ndistribution = "uniform"\nlow = {}\nhigh = {}\n'


def vary(folder: Path, text: str = LAG.format(65, 85)) -> list[str]:
    """Write a V.toml; return the option for it."""
    path = folder / "v.toml"
    path.write_text(text)
    return ["--vary", str(path)]


def run(folder: Path, *words: str) -> int:
    """Run the command in this process."""
    return main([str(PERKINS), *CUT, "-o", str(folder), *words])


def plan(n_runs: int, **changed: object) -> ForecastPlan:
    """Return the plan of short cuts on the usual machines."""
    question = Question(PERKINS, None, None, n_runs, 1, None, ("--turns-limit", "1.0"), None)
    for name, value in changed.items():
        object.__setattr__(question, name, value)
    return plan_of(question)


def test_rows_are_the_cuts_of_the_machines(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], tmp_path_factory: pytest.TempPathFactory
) -> None:
    """Each row of the table is what a cut on that machine comes to, with the belief unchanged."""
    assert run(tmp_path / "out", *vary(tmp_path), "--runs", "9") == 0
    told = capsys.readouterr()
    assert "perkins240 on perkins240_machine.toml: form error\n" in told.out
    rows = pq.read_table(tmp_path / "out" / "runs.parquet").to_pylist()
    assert [row["run"] for row in rows] == list(range(9))
    assert all(65 <= row["u.delay_us"] <= 85 for row in rows)
    table = tmp_path_factory.mktemp("table") / "part.camtab"
    made = plan(1).task
    table.write_bytes(made.table)
    table.with_suffix(".json").write_bytes(made.design)
    machine = {"u": {"delay_us": rows[4]["u.delay_us"]}, "believed": {"u": {"delay_us": 75}}}
    result = simulate(table, machine, turns=2)
    assert rows[4]["form_max_um"] == result.form_error_um
    assert rows[4]["end"] == "stopped"


def test_error_grows_with_what_is_not_known(tmp_path: Path) -> None:
    """U is late by the difference: the error is the speed of U times that, at 2500 r/min."""
    off = [word for name in LEARNING for word in ("--set", f"{name}=0")]
    words = [*vary(tmp_path, LAG.format(95, 95.001)), "--runs", "1", "--turns", "1000", *off]
    assert run(tmp_path / "o", *words) == 0
    found = json.loads((tmp_path / "o" / "forecast.json").read_text())
    late_um = 75.0 * (4 * np.pi * 2500 / 60) * 20e-6  # amplitude x angular frequency x 20 us
    known_um = 0.15  # that the part has on this machine when everything is known
    assert found["form_error_um"][0]["value_um"] == pytest.approx(late_um, abs=known_um)
    assert found["within_tolerance"]["share"] == 0


def test_same_command_gives_the_same_and_cuts_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The store has all cuts; the files are the same to the byte."""
    assert run(tmp_path / "o", *vary(tmp_path), "--runs", "5") == 0
    first = {name.name: name.read_bytes() for name in (tmp_path / "o").glob("*.*")}
    assert set(first) == {"forecast.json", "forecast.png", "runs.parquet"}
    assert len(list((tmp_path / "o" / "store").iterdir())) == 1
    capsys.readouterr()
    assert run(tmp_path / "o", *vary(tmp_path), "--runs", "5") == 0
    assert capsys.readouterr().err == "forecast: 5 of 5 cuts are already done\n"
    assert first == {name.name: name.read_bytes() for name in (tmp_path / "o").glob("*.*")}


@pytest.mark.usefixtures("undrawn")
def test_more_runs_add_to_those_that_are_there(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """What a longer forecast finds is what it finds when it begins anew."""
    assert run(tmp_path / "a", *vary(tmp_path), "--runs", "8") == 0
    assert run(tmp_path / "a", *vary(tmp_path), "--runs", "20") == 0
    assert "forecast: 8 of 20 cuts are already done\n" in capsys.readouterr().err
    assert run(tmp_path / "b", *vary(tmp_path), "--runs", "20") == 0
    one, other = ((tmp_path / name / "runs.parquet").read_bytes() for name in "ab")
    assert one == other


def test_cuts_that_fail_are_counted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A stroke that is too small for some machines: refused cuts are shown and out of tolerance."""
    text = '[u.speed_mm_per_s]\ndistribution = "uniform"\nlow = 20\nhigh = 100\n'
    machine = tmp_path / "m.toml"
    machine.write_text("[encoder]\ncounts_per_turn = 65536\n")
    words = ["--machine", str(machine), "--runs", "16", "--tolerance-um", "50"]
    # What is believed stays, so the controller starts: a drive too slow for it makes the error.
    assert run(tmp_path / "o", *vary(tmp_path, text), *words) == 0
    found = json.loads((tmp_path / "o" / "forecast.json").read_text())
    assert sum(found["ends"].values()) == 16
    failed = 16 - found["ends"]["gauged"]
    assert failed > 0
    assert found["within_tolerance"]["share"] <= 1 - failed / 16
    assert found["form_error_um"][-1]["value_um"] is None
    assert "cuts, counted as out of tolerance" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["--runs", "0"], "forecast: --runs 0: out of range; give 1 .. 1000000"),
        (["--seed", "-1"], "forecast: --seed -1: out of range"),
        (["--turns", "nan"], "forecast: --turns nan: must be a finite number above 0"),
        (["--tolerance-um", "0"], "forecast: --tolerance-um 0.0: must be a finite number"),
        (["--machine", "nowhere"], "forecast: --machine nowhere: no such machine"),
        (["--vary", "/nowhere.toml"], "forecast: /nowhere.toml: cannot be read: No such file"),
        (["--set", "k1_ns"], "forecast: --set k1_ns: give PARAM=VALUE"),
        (["--rpm", "9000"], "forecast: --rpm 9000: infeasible"),
    ],
)
def test_refusals_write_nothing(
    words: list[str], told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One line, status 2, no folder."""
    assert main([str(PERKINS), *words, "-o", str(tmp_path / "o")]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1, lines
    assert lines[0].startswith(told)
    assert not (tmp_path / "o").exists()


def test_number_no_machine_may_have_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The ends of a distribution are asked of the simulator before anything is cut."""
    text = '[u.damping]\ndistribution = "uniform"\nlow = 0.01\nhigh = 1\n'
    assert run(tmp_path / "o", *vary(tmp_path, text)) == 2
    line = capsys.readouterr().err
    assert f"{tmp_path}/v.toml: u.damping: low reaches to 0.01: u.damping = 0.01: " in line
    assert not (tmp_path / "o").exists()


def test_foreign_file_in_the_store_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It is named, with what to do."""
    (tmp_path / "o" / "store").mkdir(parents=True)
    (tmp_path / "o" / "store" / "x.parquet").write_bytes(b"nothing")
    assert run(tmp_path / "o", "--runs", "1") == 2
    assert "store/x.parquet: not a result of tools/forecast" in capsys.readouterr().err


def test_worker_with_another_simulator_is_refused() -> None:
    """Results of two builds are not mixed."""
    task = plan(1).task._replace(build="another")
    assert "another simulator" in str(cut_batch(task, [""]))
    with pytest.raises(CamtoolsError, match="build the same version"):
        cut_all(task, [""], lambda _: None, n_workers=1)


def test_all_cuts_failing_is_an_error(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The reason of the first is told; the cuts are kept."""
    text = '[u.speed_mm_per_s]\ndistribution = "uniform"\nlow = 1\nhigh = 2\n'
    assert run(tmp_path / "o", *vary(tmp_path, text), "--runs", "2") == 2
    told = capsys.readouterr().err.splitlines()[-1]
    assert told.startswith("forecast: none of 2 cuts was gauged; the first: ")
    assert "fault following_error" in told
    assert len(Store(tmp_path / "o" / "store").found) == 2
    assert not (tmp_path / "o" / "runs.parquet").exists()


@pytest.fixture
def scheduler() -> Iterator[str]:
    """Start a Dask cluster in a process that is not ours, as on other computers."""
    from distributed import LocalCluster

    with LocalCluster(
        n_workers=1, threads_per_worker=2, dashboard_address="127.0.0.1:0", silence_logs=50
    ) as cluster:
        yield cluster.scheduler_address


def test_scheduler_that_does_not_answer_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nobody listens, or the address is none: one line, nothing is written."""
    monkeypatch.setattr(parallel_cuts, "_CONNECT_S", 0.2)
    for address in ("tcp://127.0.0.1:9", "nothing"):
        assert run(tmp_path / "o", "--runs", "1", "--scheduler", address) == 2
        line = capsys.readouterr().err
        assert line.startswith(f"forecast: --scheduler {address}: does not answer; give tcp://")
        assert len(line.splitlines()) == 1
    assert not (tmp_path / "o").exists()


def test_scheduler_without_a_worker_is_refused() -> None:
    """The line tells how to start one."""
    from distributed import LocalCluster

    asked = plan(1)
    with LocalCluster(n_workers=0, dashboard_address="127.0.0.1:0", silence_logs=50) as cluster:
        address = cluster.scheduler_address
        with pytest.raises(CamtoolsError, match="has no worker; start `dask worker"):
            cut_all(asked.task, asked.texts, lambda _: None, scheduler=address)


def test_cluster_cuts_the_same(tmp_path: Path, scheduler: str) -> None:
    """Outcomes of a scheduler's workers, of several threads each, are those of this process."""
    asked = plan(24)
    there: list[CutOutcome] = []
    cut_all(asked.task, asked.texts, there.extend, scheduler=scheduler)
    here = cut_batch(asked.task, asked.texts[:8])
    assert len(there) == 24
    by_key = {one.key: one for one in there}
    for one in here:
        assert isinstance(one, CutOutcome)
        assert by_key[one.key]._replace(wall_s=0) == one._replace(wall_s=0)


def test_interrupted_forecast_goes_on(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Ctrl-C reaches all processes: status 130, one line, a whole store; then the rest is cut."""
    words = [str(PERKINS), "--runs", "400", "--workers", "2", "-o", str(tmp_path / "o")]
    command = [sys.executable, "-m", "camtools.cli.forecast", *words, "--turns", "5"]
    store = tmp_path / "o" / "store"
    with subprocess.Popen(
        command, env=environment(), start_new_session=True, stderr=subprocess.PIPE, text=True
    ) as process:
        deadline = time.monotonic() + PATIENCE_S
        while len(list(store.glob("*.parquet"))) < 1 and time.monotonic() < deadline:
            time.sleep(0.05)
        os.killpg(process.pid, signal.SIGINT)
        told = process.communicate(timeout=PATIENCE_S)[1].splitlines()
    assert process.returncode == 130, told
    assert (
        told[-1] == "forecast: interrupted; finished cuts are kept; repeat the command to continue"
    )
    assert all(line.startswith("forecast: ") for line in told), told
    n_kept = len(Store(store).found)
    assert 8 <= n_kept < 400
    assert list((tmp_path / "o").iterdir()) == [store]
    words[2] = str(n_kept + 8)
    assert main([*words, "--turns", "5"]) == 0
    assert "cuts are already done" in capsys.readouterr().err.splitlines()[0]
    assert pq.read_table(tmp_path / "o" / "runs.parquet").num_rows == n_kept + 8
