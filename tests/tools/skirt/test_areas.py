"""Windows without material and zones of tolerance: keys, gauge, correction, feed.

The bore is checked as a cylinder in space, not by the angles of the gauge.
"""

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from camtools.cli.mktables import main as mktables
from camtools.cli.run import main as run
from camtools.report.text import verdict_of
from camtools.sim.results import AnyCut
from camtools.skirt.tool.texture import feed_for_roughness_mm, roughness_um, scallop_um
from tests.tools.cases.camsim_cases import cut
from tests.tools.cases.command_cases import complaint
from tests.tools.cases.cut_cases import written_skirt
from tests.tools.cases.part_cases import oval_text, parse_part, points_text, refused
from tests.tools.cases.report_cases import made_up_summary

BORE = """\
[[piston.window]]
name = "pin bore"
angle_deg = 90
height_mm = 20
diameter_mm = 16
offset_mm = 1
margin_mm = 0.5
both_sides = true
"""
BOX = "[[piston.window]]\nangle_deg = 0\nwidth_deg = 30\nfrom_mm = 5\nto_mm = 9\n"
OWN = "form_error_um = 9"


def text_of(more: str, feed_mm: float = 0.5, nose_mm: float = 0.0) -> str:
    """Return a part with more tables."""
    process = f"feed_mm = {feed_mm}\nform_error_um = 5"
    tool = f"[tool]\nnose_radius_mm = {nose_mm}\n"
    return oval_text("piston", (40, 92), [0.2, 0.3], process, tool + more)


def made(folder: Path, more: str) -> Path:
    """Return the table of a part with more tables."""
    return written_skirt(text_of(more), folder)


def zone(name: str, from_mm: float, to_mm: float, more: str = "") -> str:
    """Return a zone of tolerance."""
    ends = f"from_mm = {from_mm}\nto_mm = {to_mm}\n"
    return f'[[tolerances.zone]]\nname = "{name}"\n{ends}{more}\n'


def test_bore_is_not_gauged(tmp_path: Path) -> None:
    """Surface points keep the margin from two cylinders of 16 mm, and come near to it."""
    found = cut(made(tmp_path, BORE), "--feed", 0.5).surface
    phi, z_mm, r_mm = 2 * np.pi * found["turn"], found["z_mm"], found["radius_mm"]
    across_mm, along_mm = r_mm * np.cos(phi), r_mm * np.sin(phi)
    for sign in (1, -1):  # angles rise from 90 degrees towards the negative side of 0 degrees
        off_mm = np.hypot(across_mm + 1.0, z_mm - 20)[sign * along_mm > 0]
        assert 8.5 < off_mm.min() < 8.5 + 0.5


@pytest.mark.parametrize(
    ("windows", "area_mm2", "depth_mm"),
    [
        (BORE, 2 * np.pi * 8**2, 0.1 + 0.12),  # at the short axis, on average a little less
        (BOX, np.radians(30) * 46 * 4, 0.1),  # at the long axis, a little more
    ],
)
def test_windows_hold_no_metal(
    tmp_path: Path, windows: str, area_mm2: float, depth_mm: float
) -> None:
    """What is missing is their area on the surface times the depth, for gauge and force alike."""
    tables = made(tmp_path, ""), made(tmp_path / "windows", windows)
    plain, other = (cut(table, "--feed", 0.1).summary for table in tables)
    missing_mm3 = pytest.approx(area_mm2 * depth_mm, rel=0.05)
    assert plain["cut"]["removed_mm3"] - other["cut"]["removed_mm3"] == missing_mm3
    assert plain["removal"]["volume_mm3"] - other["removal"]["volume_mm3"] == missing_mm3


@pytest.mark.parametrize(
    ("zones", "is_good"),
    [
        ((zone("all", 0, 40, "form_error_um = 0.01"),), False),
        ((zone("all", 0, 40, "form_error_um = 99"),), True),
        ((zone("low", 0, 20, "form_error_um = 99"), zone("high", 20, 40)), False),
        ((zone("low", 0, 20, "form_error_um = 99"), zone("high", 20, 40, OWN)), True),
        ((zone("all", 0, 40, "height_mm = [0, 40]\nlower_um = [-50, -50]\nupper_um = [50, 50]\n"
          "form_error_um = 99"),), True),
        ((zone("all", 0, 40, "height_mm = [0, 40]\nlower_um = [-50, -50]\nupper_um = [-40, 50]\n"
          "form_error_um = 99"),), False),
    ],
)  # fmt: skip
def test_zone_decides_the_verdict(tmp_path: Path, zones: tuple[str, ...], is_good: bool) -> None:
    """The cut errs by some nanometres everywhere; the part accepts 1, its zones what they say."""
    table = made(tmp_path, "".join(zones))
    words = ("--tolerance-um", "0.001", "--feed", "0.5")
    result = cut(table, *words, status=0 if is_good else 1)
    summary = result.summary
    assert summary["is_good"] is is_good
    assert (": zone " in result.message) is not is_good
    largest_um = max(found["max_um"] for found in summary["zones"])
    assert largest_um == pytest.approx(summary["form_error_um"]["max"], rel=1e-12)
    samples = sum(found["samples"] for found in summary["zones"])
    assert samples == pytest.approx(summary["cut"]["samples"], rel=1e-3)


@pytest.mark.parametrize(
    ("excess_um", "is_good", "words"),
    [
        (-0.5, True, "form error 3 µm is within what each zone accepts"),
        (0.5, False, "out of tolerance in zone belt"),
        (0.5, True, "out of tolerance beside the zones"),
    ],
)
def test_report_names_the_zone(excess_um: float, is_good: bool, words: str) -> None:
    """A part with 3 um is good where its zone accepts them, though the part accepts 1."""
    form = {"max": 3.0, "rms": 1.0, "tolerance": 1.0, "excess": excess_um}
    form["is_good_beside_zones"] = not is_good or excess_um < 0
    summary = made_up_summary(form_error_um=form)
    summary |= {"zones": [{"name": "belt", "is_good": is_good}], "is_good": excess_um < 0}
    found = SimpleNamespace(summary=summary, has_fault=False, is_good=excess_um < 0, drawn=None)
    verdict = verdict_of(cast(AnyCut, found))
    assert (words in verdict.sentence, verdict.kind) == (True, "good" if excess_um < 0 else "poor")


def test_zone_without_a_sample_is_not_good(tmp_path: Path) -> None:
    """A zone that a large feed steps over, or that lies in a window, was not judged."""
    table = made(tmp_path, BOX + zone("inside", 6, 8, "angle_deg = 0\nwidth_deg = 10"))
    result = cut(table, "--feed", "0.5", status=1)
    assert "no sample in zone inside" in result.message and not result.summary["is_good"]


def test_points_in_a_window_do_not_correct(tmp_path: Path) -> None:
    """A gauge that dives into the bore by 0.3 mm changes nothing of the correction."""
    turn, z_mm = (axis.ravel() for axis in np.meshgrid(np.arange(720) / 720, np.arange(1, 40, 1.5)))
    off_um = 2 * np.cos(6 * np.pi * turn)
    r_mm, phi = 46.0, 2 * np.pi * turn
    is_in = np.hypot(r_mm * np.cos(phi) + 1.0, z_mm - 20) < 7
    corrections: list[Any] = []
    part, gauged = tmp_path / "part.toml", tmp_path / "gauged.csv"
    part.write_text(text_of(BORE))
    previous = str(made(tmp_path, BORE).with_suffix(".json"))
    for dive_um in (0.0, -300.0):
        dived_um = off_um + np.where(is_in, dive_um, 0.0)
        gauged.write_text(points_text("turn,z_mm,deviation_um", turn, z_mm, dived_um))
        words = ("--measured", str(gauged), "--previous", previous)
        assert mktables([str(part), "-o", str(tmp_path / "out"), *words]) == 0
        report = json.loads((tmp_path / "out" / "piston.json").read_text())
        corrections.append(report["correction"]["waves"])
    assert corrections[0] == corrections[1] and corrections[0]


ZONE = zone("skirt", 0, 20)
BAND = "height_mm = [0, 9]\nlower_um = [1, 2]\nupper_um = [2, 2]\n"
HIGH = "height_mm = [0, 9]\nlower_um = [6, 7]\nupper_um = [9, 9]\n"


@pytest.mark.parametrize(
    ("more", "line"),
    [
        (BORE.replace("diameter_mm = 16\n", ""), "piston.window.0: has height_mm; give height"),
        (BOX + "diameter_mm = 3\n", "window.0: has width_deg, from_mm, to_mm, diameter_mm; "),
        (BOX.replace("= 9", "= 5"), "window.0.to_mm = 5.0: must be above from_mm = 5; exchange"),
        (BOX.replace("= 5", "= 41").replace("= 9", "= 50"), "window.0: lies beside the"),
        (BOX + "offset_mm = 1\n", "window.0.offset_mm = 1.0: has no meaning for a box; remove it"),
        (BORE.replace("offset_mm = 1", "offset_mm = 40"), "window.0: does not lie within"),
        (BORE.replace('"pin bore"', '"pin/bore"'), "use 1 to 30 letters, digits, spaces, _ and -"),
        (zone("skirt", 0, 41), "tolerances.zone.0: must lie within the part's heights, 0 .. 40 mm"),
        (ZONE + "angle_deg = 45\nwidth_deg = 40\nstraightness_um = 1\n", "at 0, 90, 180 or 270"),
        (ZONE + HIGH, "has a band of 6 .. 9 um beyond its form error, 5 um"),
        (BOX.replace("[[", "[").replace("]]", "]"), "write [[piston.window]], in double brackets"),
        (BOX.replace("30", "361"), "piston.window.0.width_deg = 361"),
        (ZONE + zone("skirt", 20, 40), 'tolerances.zone: has "skirt" twice; give every zone'),
        (ZONE + zone("top", 19, 40), 'tolerances.zone: "skirt" and "top" overlap; change their'),
        (ZONE + "width_deg = 90\nroundness_um = 1\n", "roundness_um = 1.0: needs a zone all"),
        (ZONE + "height_mm = [0, 9]\nlower_um = [1, 2]\n", "has a band of height_mm with 2, lower"),
        (ZONE + BAND, "lower_um = 2.0: must"),
    ],
)  # fmt: skip
def test_wrong_areas_are_refused(more: str, line: str) -> None:
    """Each with its place and a remedy."""
    assert line in refused(lambda: parse_part(text_of(more)))


def test_areas_with_a_common_edge_do_not_overlap() -> None:
    """Two sides at the same height are two zones, whatever the rounding of their angles."""
    sides = ZONE + "angle_deg = 10.1\nwidth_deg = 20.2\n"
    sides += zone("other", 0, 20, "angle_deg = 30.3\nwidth_deg = 20.2")
    assert len(parse_part(text_of(sides)).tolerances.zones) == 2


@pytest.mark.parametrize(("feed_mm", "nose_mm"), [(0.05, 0.4), (0.2, 0.8), (0.5, 3.0)])
def test_roughness_is_that_of_the_arcs(feed_mm: float, nose_mm: float) -> None:
    """Arcs of the nose, sampled: height and mean distance from the mean line."""
    x_mm = (np.arange(200_000) + 0.5) / 200_000 * feed_mm - feed_mm / 2
    y_um = 1e3 * (nose_mm - np.sqrt(nose_mm**2 - x_mm**2))
    share = (feed_mm / nose_mm) ** 2 / 16
    ra_um = float(np.abs(y_um - y_um.mean()).mean())
    assert roughness_um(feed_mm, nose_mm) == pytest.approx(ra_um, rel=share + 1e-6)
    assert scallop_um(feed_mm, nose_mm) == pytest.approx(np.ptp(y_um), rel=1e-4)
    back_mm = feed_for_roughness_mm(roughness_um(feed_mm, nose_mm), nose_mm)
    assert back_mm == pytest.approx(feed_mm, rel=1e-12)


ROUGH = "[tolerances]\nroughness_um = 2\n" + zone("skirt", 0, 20, "scallop_um = 3")


def test_feed_that_leaves_too_much_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Per zone, with the largest feed; the law that is proposed makes a table, a larger one none.

    3 um of scallop with a nose of 0.8 mm: 2 sqrt(2 r h - h^2); Ra of 2 um: f^2 / (18 sqrt(3) r).
    """
    part = tmp_path / "part.toml"
    words = [str(part), "-o", str(tmp_path / "made")]
    scallop_mm = 2 * np.sqrt(2 * 0.8 * 0.003 - 0.003**2)
    ra_mm = np.sqrt(0.002 * 18 * np.sqrt(3) * 0.8)
    part.write_text(text_of(ROUGH, 0.2, 0.8))
    line = complaint(mktables, words, capsys)
    assert "process.feed_mm = 0.2: leaves scallops of 6.27 um and Ra 1.6 um in zone skirt" in line
    assert f"feed at most {np.floor(scallop_mm * 1e4) / 1e4:g} mm there" in line
    assert mktables([*words, "--propose-feed"]) == 0
    law = capsys.readouterr().out
    highest = [float(text) for text in law.splitlines()[2].split("[")[1][:-1].split(",")]
    assert min(highest) == pytest.approx(scallop_mm, abs=1e-4)
    assert max(highest) == pytest.approx(ra_mm, abs=1e-4)
    plain = text_of(ROUGH, 0.2, 0.8).replace("feed_mm = 0.2\n", "")
    for factor, status in ((1.0, 0), (1.01, 2)):
        feeds = ", ".join(f"{factor * feed:g}" for feed in highest)
        own = [*law.splitlines()[:2], f"feed_mm = [{feeds}]"]
        part.write_text(plain + "\n".join(own) + "\n")
        assert mktables(words) == status
    steep = "[process.feed_law]\nheight_mm = [0, 20, 40]\nfeed_mm = [0.05, 0.05, 1.9]\n"
    part.write_text(plain + steep)
    assert mktables(words) == 2
    told = "leaves metal between the tracks in the part, heights 20 .. 40"
    assert told in capsys.readouterr().err
    part.write_text(text_of("[tolerances]\nroughness_um = 2\n", 0.2, 0.8))
    line = complaint(run, [*words, "--feed", "0.3"], capsys)
    assert "--feed = 0.3: leaves scallops of 14.2 um" in line
    for zones in (zone("thin", 5, 5.02, "scallop_um = 0.05"), zone("all", 0, 40, "scallop_um = 3")):
        part.write_text(text_of("[tolerances]\nroughness_um = 2\n" + zones, 0.2, 0.8))
        assert mktables([*words, "--propose-feed"]) == 0
        table, feed = capsys.readouterr().out.splitlines()
        assert (table, float(feed.split()[-1]) < 0.14) == ("[process]", True)
    part.write_text(text_of(ROUGH, 0.2))
    line = complaint(mktables, words, capsys)
    assert "tool.nose_radius_mm: is missing: limits of scallop_um" in line
