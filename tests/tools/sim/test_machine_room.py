"""U about its mean, run-in and run-out: cuts on the simulated lathe, judged by the drawing."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from camtools.part.common import FeedLaw
from camtools.sim.results import CUTTING
from tests.tools.cases.camsim_cases import cut as played
from tests.tools.cases.camsim_cases import refusal, while_in
from tests.tools.cases.cut_cases import written_skirt

MACHINES = Path(__file__).parents[3] / "host_sim" / "machines"
PART = """
[part]
name = "oval"
kind = "piston"
source = "invented"
[piston.profile]
height_mm = [0, 10, 20, 30]
diameter_mm = [60.0, 60.05, 60.04, 59.98]
overshoot_um = 5
[piston.section]
shape = "cosine"
[piston.ovality]
height_mm = [0, 30]
ovality_mm = [0.8, 0.9]
[process]
spindle_rpm = 600
feed_mm = 0.5
{process}
[machine.limits]
u_stroke_mm = 0.8
"""
GOUGE_UM = 0.5  # the form error of the machine, on both sides of the drawing


def table_of(folder: Path, process: str, old: str = "", new: str = "") -> Path:
    """Make the table of an oval of 0.45 mm of travel, in whose part file something is replaced."""
    text = PART.format(process=process)
    assert old in text
    return written_skirt(text.replace(old, new, 1), folder)


@pytest.fixture(scope="module")
def machine(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the default machine with a stroke of 0.8 mm."""
    path = tmp_path_factory.mktemp("machine") / "short.toml"
    text = (MACHINES / "default.toml").read_text()
    assert "stroke_mm = 1.2 " in text
    path.write_text(text.replace("stroke_mm = 1.2 ", "stroke_mm = 0.8 "))
    return path


@pytest.fixture(scope="module")
def mean(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Make the table whose U swings about its mean."""
    return table_of(tmp_path_factory.mktemp("mean"), 'u_zero = "mean"')


def cut(table: Path, *words: str | Path) -> dict[str, Any]:
    """Return the summary of a cut."""
    return played(table, "--no-learning", *words, status=None).summary


def test_part_of_045_mm_is_cut_on_a_stroke_of_08_mm(mean: Path, machine: Path) -> None:
    """The travel fits; the default retract of 0.5 mm does not and blocks nothing."""
    summary = cut(mean, "--machine", machine, "--seed", "3")
    assert (summary["end"], summary["is_good"]) == ("done", True)
    assert summary["form_error_um"]["max"] < GOUGE_UM
    assert summary["cut"]["gouge_um"] < GOUGE_UM
    assert summary["feasibility"]["u_stroke_mm"]["needed"] == pytest.approx(0.45, abs=1e-4)


@pytest.mark.parametrize("n_stops", [14, pytest.param(35, marks=pytest.mark.long)])
def test_tool_is_never_in_the_part(mean: Path, machine: Path, n_stops: int) -> None:
    """Emergency stops all over the approach, engaging, the cut, disengaging.

    With and without clearance of X, and at a stroke that leaves U 0.03 mm to retract, half of
    which is the room that its feed-forward needs.
    """
    rng = np.random.default_rng(11)
    for clearance_nm, stroke_nm in ((0, 800_000), (1_000_000, 800_000), (10**6, 510_000)):
        sets = (f"u_stroke_nm={stroke_nm}", f"x_clearance_nm={clearance_nm}")
        words = ("--machine", machine, "--rpm", "1800", "--set", sets[0], "--set", sets[1])
        whole_s = cut(mean, *words)["machine_time_s"]
        found = set()
        for at_s in np.sort(rng.uniform(0.2, whole_s, n_stops)):
            summary = cut(mean, *words, "--inject", f"estop@t{at_s:.6f}")
            assert summary["cut"]["gouge_um"] < GOUGE_UM, at_s
            found.add(summary.get("fault", {}).get("state"))
        assert {"engaging", "cutting", "disengaging"} <= found


def test_tool_runs_in_and_out_through_the_air(tmp_path: Path, machine: Path) -> None:
    """The part is gauged from end to end and only there, the first turns included."""
    run = 'u_zero = "mean"\nrun_in_mm = 3\nrun_out_mm = 2'
    table = table_of(tmp_path, run)
    found = played(table, "--no-learning", "--machine", machine)
    summary, heights = found.summary, found.surface["z_mm"]
    assert summary["is_good"]
    assert summary["form_error_um"]["max"] < GOUGE_UM
    assert summary["cut"]["gouge_um"] < GOUGE_UM
    assert 0 <= heights.min() < 0.06
    assert 29.94 < heights.max() <= 30
    design = json.loads(table.with_suffix(".json").read_text())["design"]
    assert design["gauge_mm"] == [0, 30]
    # 35 mm at 0.5 mm and the two halves of the feed ramps
    assert summary["cut"]["planned_turns"] == pytest.approx(72)
    words = ("--no-learning", "--machine", machine, "--rpm", 1200, "--feed", 2)
    trace = played(table, *words, status=None, tables=["trace"]).trace
    state, z = trace["state"], trace["z_mm"]
    assert set(state[(z >= 0) & (z < 2)]) == {CUTTING}, "full amplitude over the whole part"


def test_ring_helix_has_rings_in_the_air(tmp_path: Path, machine: Path) -> None:
    """Rings stand every feed from the start of the run-in on, so the first on the part is whole."""
    run = 'u_zero = "mean"\nrun_in_mm = 1\nrun_out_mm = 1\npath = "ring-helix"'
    table = table_of(tmp_path, run)
    summary = cut(table, "--machine", machine)
    assert summary["is_good"]
    assert summary["cut"]["planned_turns"] == 2 * 64 + 1
    assert summary["cut"]["gouge_um"] < GOUGE_UM


def test_all_passes_are_cut_and_gauged_in_one_run(tmp_path: Path, machine: Path) -> None:
    """Each against the drawing and its stock; the last one is the verdict."""
    words = (
        'u_zero = "mean"\nrun_in_mm = 1\nrun_out_mm = 1\ndepth_mm = 0.8\n'
        "[[process.pass]]\nallowance_um = 250\nfeed_mm = 1.0\nspindle_rpm = 500\n"
        "[[process.pass]]\nallowance_um = 30\n[[process.pass]]\nallowance_um = 0"
    )
    table = table_of(tmp_path, words)
    summary = cut(table, "--machine", machine)
    assert (summary["end"], summary["is_good"]) == ("done", True)
    passes = summary["passes"]
    assert [one["pass"] for one in passes] == [1, 2, 3]
    assert [one["allowance_um"] for one in passes] == [250, 30, 0]
    assert [one["spindle_rpm"] for one in passes] == [500, 600, 600]
    assert [one["feed_mm"] for one in passes] == [1.0, 0.5, 0.5]
    for one in passes:
        assert one["form_error_um"]["max"] < GOUGE_UM
        assert one["below_drawing_um"] < GOUGE_UM
    assert summary["form_error_um"]["max"] == passes[-1]["form_error_um"]["max"]
    # of the drawing: the first out of the cylinder, the others parallel to it
    assert passes[0]["depth_min_mm"] == pytest.approx(0.8 - 0.25, abs=2e-3)
    assert passes[1]["depth_max_mm"] == pytest.approx(0.22, abs=1e-3)
    assert passes[2]["depth_min_mm"] == pytest.approx(0.03, abs=1e-3)
    middle_mm = 60.0 / 2 - 0.85 / 4
    thin = 2 * np.pi * (middle_mm + 0.015) * 0.03 * 30
    assert passes[2]["volume_mm3"] == pytest.approx(thin, rel=0.02)
    chosen = cut(table, "--machine", machine, "--set", "pass=2")
    assert [one["pass"] for one in chosen["passes"]] == [2]
    assert chosen["form_error_um"]["max"] < GOUGE_UM
    overruled = cut(table, "--machine", machine, "--rpm", "700", "--feed", "0.8")
    assert [one["feed_mm"] for one in overruled["passes"]] == [0.8] * 3
    assert [one["spindle_rpm"] for one in overruled["passes"]] == [700] * 3
    assert "pass 1: --rpm 3500: infeasible" in refusal(table, "--machine", machine, "--rpm", 3500)
    stopped = cut(table, "--machine", machine, "--inject", "stop@1")
    assert (stopped["end"], len(stopped["passes"])) == ("stopped", 1)


def test_next_pass_of_a_cone_begins_without_touching_it(tmp_path: Path, machine: Path) -> None:
    """The second pass returns from the thin end to the thick one: X leaves the cone before Z."""
    words = "[[process.pass]]\nallowance_um = 30\n[[process.pass]]\nallowance_um = 0"
    cone = ("[60.0, 60.05, 60.04, 59.98]", "[66, 64, 62, 60]")
    table = table_of(tmp_path, f'u_zero = "mean"\n{words}', *cone)
    summary = cut(table, "--machine", machine)
    assert summary["end"] == "done"
    assert summary["cut"]["gouge_um"] < 2 * GOUGE_UM
    assert len(summary["passes"]) == 2


@pytest.mark.long
def test_feed_follows_its_law_over_the_height(tmp_path: Path, machine: Path) -> None:
    """Z per turn in the trace is the feed at that height, within what the law changes in a turn."""
    law = "[process.feed_law]\nheight_mm = [0, 10, 30]\nfeed_mm = [0.2, 0.6, 0.3]"
    table = table_of(tmp_path, f'u_zero = "mean"\n{law}', "feed_mm = 0.5\n")
    words = ("--no-learning", "--machine", machine, "--rpm", 2400)
    found = played(table, *words, tables=["trace"])
    assert found.summary["is_good"]
    turn, z = (while_in(found.trace, "cutting")[name] for name in ("turn", "z_mm"))
    whole = np.unwrap(turn, period=1.0)
    at = np.arange(whole[0] + 4, whole[-1] - 4, 0.5)
    feed = np.interp(at + 0.5, whole, z) - np.interp(at - 0.5, whole, z)
    here = np.interp(at, whole, z)
    wanted = FeedLaw(height_mm=[0.0, 10.0, 30.0], feed_mm=[0.2, 0.6, 0.3]).at_mm(here)
    assert np.abs(feed / wanted - 1).max() < 0.01
