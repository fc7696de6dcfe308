"""Runs are kept, cut one after the other, stopped, and compared by their own numbers."""

import asyncio
import json
import sys
import time
from dataclasses import asdict
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError
from camtools.panel.runs import compare
from camtools.panel.runs.compare import (
    N_ANGLES,
    N_HEIGHTS,
    differing,
    error_curves,
    error_map,
    figures_of,
    heights_of,
    over_height,
    scale_of,
    section_error,
    settings_rows,
)
from camtools.panel.runs.run_queue import MOST_WAITING, RunQueue
from camtools.panel.runs.store import DONE, FAILED, OWN, STOPPED, WAITING, RunOptions, RunStore
from camtools.sim.machine_file import names
from checks.patience import limit_s
from tests.tools.cases.command_cases import job_of

SUMMARY = {
    "run_wall_time_s": 2.0,
    "part": "skirt",
    "machine": "default",
    "form_error_um": {"max": 0.5, "rms": 0.2, "tolerance": 1.0, "max_at_z_mm": 7.0},
    "following_error_um": {"max": 0.4, "rms": 0.1},
    "end": "done",
    "is_good": True,
    "seed": 1,
    "cut": {"spindle_rpm": 600, "feed_mm": 0.1, "turns": 100},
    "table_bytes": 3456,
    "table_crc32": 1,
}
# A program in place of tools/run: it tells how far it is, and writes a summary unless told not to.
CUT = """
import json, sys, time
sys.stderr.write("run: making the table of part.toml\\n")
sys.stderr.write("camsim:  50.0 %, 1.0 s of machine time, about 7 s left\\r")
sys.stderr.flush()
if "600.0" in sys.argv:
    time.sleep(60)
if "601.0" in sys.argv:
    sys.stderr.write("run: part.toml: process.feed_mm = 0: must be above 0; give mm per turn\\n")
    sys.exit(2)
open("summary.json", "w").write(open("given.json").read())
open("report.html", "w").write("<p>report</p>")
"""


@pytest.fixture
def store(tmp_path: Path) -> RunStore:
    """Return an empty place for runs."""
    return RunStore(tmp_path / "runs", tmp_path / "run")


def kept(store: RunStore, name: str, at_s: float, **changes: object) -> str:
    """Keep a finished run; return its key."""
    folder = store.new(name, "[part]\nname = 'skirt'\n", RunOptions(), at_s=at_s)
    (folder / "summary.json").write_text(json.dumps(SUMMARY | changes))
    store.note(folder, {"status": DONE})
    return f"{OWN}/{folder.name}"


def test_runs_are_numbered_and_read_back(store: RunStore) -> None:
    """NAME-NNN, with what they were cut with and what came of it, the newest first."""
    first, second = kept(store, "skirt", 10.0), kept(store, "skirt", 20.0)
    assert [run.key for run in store.runs()] == [second, first]
    run = store.run(first)
    assert (run.name, run.verdict) == ("skirt-001", "within tolerance")
    assert (run.form_um, run.following_um) == (0.5, 0.4)


@pytest.mark.parametrize("key", ["", "own/..", "own/../x", "own//etc", "other/a", "own/a b", "x/y"])
def test_keys_lead_nowhere_else(store: RunStore, key: str) -> None:
    """A key that no run has is refused, whatever is in it."""
    kept(store, "skirt", 10.0)
    for action in (store.run, store.remove):
        with pytest.raises(CamtoolsError, match="no such run"):
            action(key)
    assert len(store.runs()) == 1


def test_a_link_is_no_run(store: RunStore, tmp_path: Path) -> None:
    """A folder of somebody else, linked into the place, is neither shown nor removed."""
    kept(store, "skirt", 10.0)
    (tmp_path / "runs" / "link-001").symlink_to(tmp_path / "runs" / "skirt-001")
    assert len(store.runs()) == 1
    with pytest.raises(CamtoolsError):
        store.remove("own/link-001")


def test_runs_of_tools_run_are_read_only(store: RunStore, tmp_path: Path) -> None:
    """They are listed by their summary, and stay."""
    other = tmp_path / "run" / "perkins240"
    other.mkdir(parents=True)
    (other / "summary.json").write_text(json.dumps(SUMMARY))
    (tmp_path / "run" / "notes").mkdir()
    [run] = store.runs()
    assert (run.place, run.verdict) == ("tools-run", "within tolerance")
    with pytest.raises(CamtoolsError, match="tools/run --keep"):
        store.remove(run.key)


def test_the_oldest_runs_go_first(store: RunStore) -> None:
    """So many are kept and so many bytes; what waits or goes on is never removed."""
    for i in range(5):
        kept(store, "skirt", float(i))
    store.new("skirt", "x", RunOptions(), at_s=-1.0)
    assert store.tidy(most_runs=3) == ["skirt-002", "skirt-001"]
    assert store.tidy(most_runs=9, most_bytes=1) == ["skirt-004", "skirt-003"]
    assert [run.status for run in store.runs()] == [DONE, WAITING]


def test_what_an_earlier_panel_left_is_stopped(store: RunStore) -> None:
    """Nothing goes on that nobody watches."""
    store.new("skirt", "x", RunOptions(), at_s=0.0)
    store.end_lost()
    assert [run.status for run in store.runs()] == [STOPPED]


class Watched(RunQueue):
    """Runs whose progress is noted."""

    seen: ClassVar[list[str]] = []

    def _take(self, line: bytes) -> None:
        super()._take(line)
        self.seen.append(f"{self.progress.text} {self.progress.left_s}")


def cut(store: RunStore, *many: RunOptions, stop: bool = False) -> list[str]:
    """Cut runs by the program in place of tools/run; return what was told of progress."""
    Watched.seen.clear()

    async def whole() -> None:
        queue = Watched(store, [sys.executable, "-c", CUT])
        given = {"given.json": json.dumps(SUMMARY).encode()}
        for options in many:
            folder = store.new("skirt", "x", options, at_s=time.time(), files=given)
            queue.add(folder, options)
        if stop:
            async with asyncio.timeout(limit_s()):
                while queue.progress.left_s is None:
                    await asyncio.sleep(0.01)
            assert queue.running is not None
            queue.stop(queue.waiting[0])
            queue.stop(queue.running.name)
        async with asyncio.timeout(limit_s()):
            while queue.running or queue.waiting:
                await asyncio.sleep(0.01)
        await queue.close()

    asyncio.run(whole())
    return Watched.seen


def test_runs_are_cut_one_after_the_other(store: RunStore) -> None:
    """One that is refused says why and does not stop the next one; progress is told."""
    seen = cut(store, RunOptions(rpm=601.0), RunOptions(rpm=602.0))
    good, bad = store.runs()
    assert (good.status, good.verdict, good.has_report) == (DONE, "within tolerance", True)
    assert bad.status == FAILED
    assert bad.told.endswith("give mm per turn")
    assert "making the table of part.toml 7.0" in seen


def test_a_run_is_stopped(store: RunStore) -> None:
    """That which goes on, and that which waits; both are marked."""
    cut(store, RunOptions(rpm=600.0), RunOptions(rpm=600.0), stop=True)
    assert [run.status for run in store.runs()] == [STOPPED, STOPPED]


def test_a_queue_has_an_end(store: RunStore) -> None:
    """More than a few runs do not wait."""

    async def whole() -> None:
        queue = RunQueue(store, command=[sys.executable, "-c", "import time; time.sleep(60)"])
        for _ in range(MOST_WAITING):
            queue.add(store.new("skirt", "x", RunOptions(), at_s=0.0), RunOptions())
        with pytest.raises(CamtoolsError, match="are waiting already"):
            queue.add(Path("more"), RunOptions())
        await queue.close()

    asyncio.run(whole())


def test_options_are_those_of_tools_run() -> None:
    """Its own parser takes every option that the page gives."""
    options = RunOptions(machine=names()[0], rpm=900.0, feed_mm=0.2, learns=False, seed=7)
    job = job_of(*options.words("part.toml"))
    assert (job.rpm, job.feed, job.machine is not None) == (900.0, 0.2, True)
    assert job.extra[:2] == ("--seed", "7")
    assert "--no-learning" in job.extra
    assert RunOptions.of(asdict(options)) == options
    for wrong in (RunOptions(rpm=-1.0), RunOptions(rpm=float("nan")), RunOptions(seed=-1)):
        with pytest.raises(CamtoolsError):
            wrong.check()


def test_figures_are_those_of_the_summaries(store: RunStore) -> None:
    """Each number with its difference, and none where a run has none."""
    changed = {"form_error_um": {"max": 0.75, "rms": None, "tolerance": 1.0}, "seed": 2}
    keys = [kept(store, "skirt", 1.0), kept(store, "skirt", 2.0, **changed)]
    runs = [store.run(key) for key in keys]
    figures = {one.name: one for one in figures_of(runs)}
    form = figures["form error, largest"]
    assert (form.values, form.difference(1)) == ((0.5, 0.75), "+0.25")
    assert figures["form error, rms"].difference(1) == ""
    assert dict(settings_rows(runs))["seed"] == ["1", "2"]


def test_differences_of_texts() -> None:
    """Lines that are added and removed, with their kind; nothing of texts that are alike."""
    lines = differing("a\nfeed = 1\nb\n", "a\nfeed = 2\nb\n")
    assert [line for line in lines if line.kind in "+-"] == [("-", "feed = 1"), ("+", "feed = 2")]
    assert differing("a\n", "a\n") == []


def test_errors_over_height_and_angle_are_those_of_the_surface(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every cell has the error of largest magnitude of the points in it, found by a plain loop."""
    rng = np.random.default_rng(17)
    n = 3000
    columns = rng.random(n), 60 * rng.random(n), np.full(n, 46.0), rng.normal(0, 200, n)
    rows, path = np.column_stack(columns), tmp_path / "surface.csv"
    head = "turn,z_mm,radius_mm,error_nm"
    np.savetxt(path, rows, "%.6f", delimiter=",", header=head, comments="")
    found = error_curves(tmp_path, (0.0, 60.0))
    monkeypatch.setattr(compare, "read_surface", None)  # it is not read again
    assert len(heights_of(tmp_path)) == 2 and section_error(tmp_path, 30.0, 1.0) is not None
    assert found is not None
    wanted = np.full((N_HEIGHTS, N_ANGLES), np.nan)
    for turn, z_mm, _, error_nm in rows:
        cell = int(z_mm / 60 * N_HEIGHTS), int(turn * N_ANGLES)
        if np.isnan(wanted[cell]) or abs(error_nm * 1e-3) > abs(wanted[cell]):
            wanted[cell] = error_nm * 1e-3
    assert np.allclose(found.map_um, wanted, atol=1e-8, equal_nan=True)
    assert found.worst_um[10] == pytest.approx(np.nanmax(np.abs(wanted[10])), abs=1e-8)
    assert scale_of([found.map_um]) == pytest.approx(np.nanmax(np.abs(wanted)), rel=5e-3)
    chart = error_map("one", found, 1.0)
    assert len(chart["series"][0]["data"]) == np.isfinite(wanted).sum()
    assert (chart["visualMap"]["min"], chart["visualMap"]["max"]) == (-1.0, 1.0)
    lines = over_height([("one", found)])
    assert [one["name"] for one in lines["series"]] == ["one"]
