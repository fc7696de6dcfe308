"""tools/run with a cam: results complete, figures in words, errors as for a skirt."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from camtools.cli.run import main as run
from camtools.lobe.generate import GeneratedLobes, generate_lobes
from camtools.lobe.motion import example_lobe
from camtools.lobe.plots import draw_rake, speed_of_contact
from camtools.lobe.report import REPORT
from camtools.lobe.summary import LobeOutcome
from camtools.report.kind_report import make_report, rows_of
from camtools.report.surface import over_turn
from camtools.report.text import page_text
from camtools.sim.results import STATES, CutTrace, GaugedSurface
from tests.tools.cases.part_cases import ROOT
from tests.tools.cases.report_cases import without_scripts

PARTS = ROOT / "tools" / "parts"
SHORT = ("--feed", "4", "--", "--set", "engage_turns=1", "--set", "disengage_turns=1")
PICTURES = ("cam", "compare", "learning", "motion", "sequence", "speed")


@pytest.mark.usefixtures("undrawn")
def test_disc_is_ground_and_reported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """All results appear, the profile is good, the page holds every picture and no link.

    --rpm is the speed on the base circle: the law of a constant surface speed is made for it.
    """
    words = [str(PARTS / "cam-disc.toml"), "--rpm", "90", "-o", str(tmp_path / "out"), *SHORT]
    assert run(words) == 0
    shown = capsys.readouterr().out
    names = sorted(path.name for path in (tmp_path / "out").iterdir())
    tables = [f"cam-disc{end}" for end in (".camtab", ".json", "_machine.toml", "_table.c")]
    results = ["report.html", "summary.json", "surface.csv", "trace.parquet", "cam-disc_table.h"]
    sheets = ["cut_sheet1.png", "sections.csv", "sheets.json"]
    assert names == sorted([*(f"cut_{key}.png" for key in PICTURES), *tables, *results, *sheets])
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["is_good"] and summary["form_error_um"]["tolerance"] == 1.0
    assert summary["form_error_um"]["max"] <= 0.05
    assert summary["table_error"]["u_nm"] <= 10
    assert summary["comparison"][0]["name"] == "complete controller"
    assert summary["comparison"][-1]["max_um"] > 10
    speed = summary["cam"]["surface_speed_mm_s"]["base_circle"]
    assert speed == pytest.approx(1.5 * 2 * np.pi * 20, rel=1e-5)
    page = without_scripts((tmp_path / "out" / "report.html").read_text())
    assert page.count("data:image/png;base64,") == len(PICTURES) + 1  # and the sheet
    assert "WITHIN TOLERANCE" in page and "The wheel is a whole cylinder" in page
    assert shown.startswith("cam-disc: within tolerance\n")
    assert "base circle 188.5 mm/s" in shown and "µ" not in shown


@pytest.mark.long
@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(("part", "picture"), [("cam-disc", "fault"), ("cam-345", "rake")])
def test_fault_is_told_and_drawn(
    part: str, picture: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """An emergency stop ends the cut with status 1 and a page that explains it.

    The swing of a turned cam is measured: its picture and its row are there.
    """
    words = [str(PARTS / f"{part}.toml"), "-o", str(tmp_path / "out"), *SHORT]
    assert run([*words, "--set", "rehearse_turns=0", "--inject", "estop@1.5"]) == 1
    page = (tmp_path / "out" / "report.html").read_text()
    assert "FAULT: ESTOP" in page and "What happened" in page
    assert (tmp_path / "out" / f"cut_{picture}.png").exists()
    assert ("effective rake" in capsys.readouterr().out) is (part == "cam-345")


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (["--rpm", "0.5"], "--rpm 0.5: out of range; give r/min, 1 .. 60000"),
        (["--rpm", "900"], "cam-disc.toml: "),
        (["--", "--removal", "r.csv"], "--removal r.csv: forces are for skirts only"),
    ],
)
def test_bad_request_leaves_nothing(
    words: list[str], named: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """One line says what is wrong; status 2, no folder."""
    assert run([str(PARTS / "cam-disc.toml"), "-o", str(tmp_path / "out"), *words]) == 2
    error = capfd.readouterr().err
    lines = [line for line in error.splitlines() if not line.startswith("run: making")]
    assert named in lines[-1], error
    assert not (tmp_path / "out").exists()


def made_up(generated: GeneratedLobes, cam: dict[str, Any]) -> LobeOutcome:
    """Return the outcome of a cut that nobody made."""
    one = {"needed": 1.0, "limit": 4.0}
    limits = ("spindle_rpm", "u_speed_mm_s", "u_acceleration_mm_s2", "u_stroke_mm")
    summary = {
        "is_good": True, "end": "done", "table_bytes": 5000, "seed": 1, "tick_hz": 20000,
        "machine": "m", "machine_time_s": 3.0, "wall_time_s": 1.0, "gauge": {"reference": "design"},
        "form_error_um": {"max": 0.5, "rms": 0.1, "tolerance": 1.0},
        "following_error_um": {"max": 0.2, "rms": 0.1},
        "cut": {"spindle_rpm": 60, "feed_mm": 0.1, "turns": 3.0, "planned_turns": 3.0},
        "feasibility": {"highest_rpm": 99.0} | dict.fromkeys(limits, one),
        "cam": cam, "injected": [],
    }  # fmt: skip
    turn = np.linspace(0, 1, 50, endpoint=False)
    surface = GaugedSurface(
        turn, np.full(50, 5.0), np.full(50, 25.0), 0.3 * np.sin(2 * np.pi * turn)
    )
    tick = np.arange(2000.0)
    columns = {name: np.zeros(2000) for name in CutTrace._fields}
    columns |= {"t_s": tick * 50e-6, "turn": tick * 1e-3, "z_mm": np.full(2000, 5.0)}
    columns["state"] = np.full(2000, float(STATES.index("cutting")))
    return LobeOutcome(generated, summary, surface, CutTrace(**columns))


@pytest.fixture(scope="module")
def turned() -> GeneratedLobes:
    """Make the table of the turned 3-4-5 cam."""
    return generate_lobes(example_lobe())


LOBE = {"z_first_mm": 0, "z_last_mm": 12, "samples": 9, "max_um": 0.5, "rms_um": 0.1}
TURNED = {
    "operation": "turning", "tip_mm": 0.4, "lobes": [LOBE],
    "rake_deg": {
        "min": -0.002, "max": 0.0013, "without_swing_min": -19.97, "without_swing_max": 19.96
    },
}  # fmt: skip


def test_rake_and_lobes_have_their_rows(turned: GeneratedLobes) -> None:
    """The larger of both sides is the bound; a lobe that was not reached is called so."""
    rows = dict(rows_of(REPORT, made_up(turned, TURNED)))
    assert rows["effective rake"] == "constant within 0.002°; without the swing -19.97 .. 19.96°"
    assert rows["cut"].startswith("cam turned, tip of radius 0.4 mm, at 60 r/min, feed 0.1 mm")
    assert "surface speed" not in rows
    outcome = made_up(turned, TURNED)
    text = page_text(outcome, rows_of(REPORT, outcome), "out", 2.0)
    assert "required U stroke" in text and "constant within 0.002 deg" in text
    missing = {"z_first_mm": 14, "z_last_mm": 20, "samples": 0}
    rows = dict(rows_of(REPORT, made_up(turned, TURNED | {"lobes": [LOBE, missing]})))
    assert rows["lobe 0"] == "0 .. 12 mm: max 500 nm, rms 100 nm"
    assert rows["lobe 1"] == "14 .. 20 mm: not cut"


@pytest.mark.long
@pytest.mark.usefixtures("undrawn")
def test_rake_is_drawn_of_a_tool_that_swings(turned: GeneratedLobes) -> None:
    """With the trace's swing the picture is there, and its numbers are those of the exact angle."""
    outcome = made_up(turned, TURNED)
    exact_deg = np.degrees(turned.lobes[0].at(2 * np.pi * outcome.trace.turn).angle)
    figure = draw_rake(replace(outcome, swing_deg=exact_deg - 0.25))
    above, below = figure.axes
    without, with_swing = (np.asarray(line.get_ydata()) for line in above.lines[:2])
    assert np.abs(without).max() == pytest.approx(19.967, abs=0.01)
    assert with_swing == pytest.approx(0.25)
    assert below.get_ylim()[0] < 0.25 < below.get_ylim()[1]
    files = make_report(REPORT, replace(outcome, swing_deg=exact_deg))
    names = {"cut_speed.png", "cut_cam.png", "cut_rake.png", "report.html"}
    assert names <= set(files)
    page = files["report.html"].decode()
    assert "Effective rake" in page and "The tip of the tool is a circle" in page


def test_data_of_pictures(turned: GeneratedLobes) -> None:
    """Bins hold their extremes; the contact's speed is r omega, on the nose ds/dtheta."""
    turn, values = np.array([0.5, 0.5001, 1.0]), np.array([-1.0, 2.0, 3.0])
    degrees, least, most, mean = over_turn(turn, values, 720)
    assert degrees.tolist() == [0.25, 180.25]
    assert least.tolist() == [3.0, -1.0]
    assert most.tolist() == [3.0, 2.0]
    assert mean.tolist() == [3.0, 0.5]
    lobe = turned.lobes[0]
    found = speed_of_contact(lobe, np.radians([180.0, 0.0]), np.array([2.0, 1.0]))
    assert found.tolist() == pytest.approx([40.0, 28.0])
