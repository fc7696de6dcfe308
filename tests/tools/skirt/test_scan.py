"""Measured sections: reading, filtering, and the surface through the points."""

import os
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from camtools.base.errors import CamtoolsError, GeometryError
from camtools.cli.mktables import main as mktables
from camtools.skirt.geometry.scan import (
    Scan,
    filtered,
    joined,
    ovality_of,
    parse_scan,
    scan_surface,
)
from camtools.skirt.geometry.scan_text import HEADER, MAX_POINTS, read_scan_text
from camtools.skirt.geometry.skirt_geometry import Geometry, make_geometry
from tests.tools.cases.part_cases import ROOT, load_part

MEASURED = ROOT / "tools" / "parts" / "scan90.toml"
ANGLES = range(0, 360, 10)
SINGLE = "single_height = true"


def csv_of(heights: tuple[float, ...] = (0.0,), first: str = HEADER) -> str:
    """Return a good scan: an oval of 0.1 mm with three waves, deeper with height."""
    rows = [
        f"{a},{z},{50 * (1 - np.cos(np.radians(2 * a))) + 5 * np.sin(np.radians(3 * a)) + z:.4f}"
        for z in heights
        for a in ANGLES
    ]
    return "\n".join([first, *rows]) + "\n"


def geometry_of(folder: Path, scan: str, more: str = "") -> Geometry:
    """Make the geometry of a part with this scan beside it."""
    text = MEASURED.read_text().replace("harmonics = 15 ", f"{more} #")
    (folder / "scan90.csv").write_text(scan)
    (folder / "part.toml").write_text(text)
    return make_geometry(load_part(folder / "part.toml"))


def test_surface_runs_through_all_points() -> None:
    """Unfiltered points of every height lie on the surface."""
    scan = joined(read_scan_text(ROOT / "tools" / "parts" / "scan90.csv")).scan
    found = scan_surface(scan).delta(np.radians(scan.angle_deg), scan.z_mm[:, None]).delta
    np.testing.assert_allclose(found, scan.reduction_mm, atol=1e-13)


@settings(max_examples=20)
@given(st.integers(1, 4), st.floats(0, 6.28), st.sampled_from([1, 2, 3, 5]))
def test_smooth_sections_come_back_between_their_points(
    waves: int, phase: float, n_heights: int
) -> None:
    """Waves sampled every 3 degrees are met in between; derivatives agree with differences."""
    angle = np.arange(0.0, 360, 3)
    rows = [0.1 * np.cos(waves * np.radians(angle) + phase) for _ in range(n_heights)]
    scan = Scan(angle, 10.0 * np.arange(n_heights, dtype=np.float64), np.stack(rows))
    phi = np.linspace(-1, 9, 400)
    found = scan_surface(scan).delta(phi, 3.3)
    np.testing.assert_allclose(found.delta, 0.1 * np.cos(waves * phi + phase), atol=1e-7)
    np.testing.assert_allclose(found.d1, -0.1 * waves * np.sin(waves * phi + phase), atol=2e-6)


def test_heights_are_joined_linearly_or_smoothly(tmp_path: Path) -> None:
    """One height serves all, two are joined linearly, five by a spline that meets each."""
    one = geometry_of(tmp_path, csv_of((30.0,)), SINGLE)
    np.testing.assert_array_equal(one.delta(1.0, 0.0).delta, one.delta(1.0, 60.0).delta)
    two = geometry_of(tmp_path, csv_of((0.0, 60.0)))
    middle = two.delta(0.5, np.array([0.0, 30.0, 60.0])).delta
    assert middle[1] == pytest.approx((middle[0] + middle[2]) / 2, abs=1e-14)
    assert middle[2] - middle[0] == pytest.approx(0.06, abs=1e-12)


def test_one_height_must_be_asked_for(tmp_path: Path) -> None:
    """A file that was cut short has one height, too; what it lacks is not made up in silence."""
    with pytest.raises(GeometryError, match=r"has one height only, 30 mm; .*single_height = true"):
        geometry_of(tmp_path, csv_of((30.0,)))
    with pytest.raises(GeometryError, match="is true, but the file has 2 heights"):
        geometry_of(tmp_path, csv_of((0.0, 60.0)), SINGLE)


def test_file_that_stops_within_a_line_is_refused(tmp_path: Path) -> None:
    """1.2 may be the begin of 1.25: the line has no end."""
    scan = csv_of((0.0, 60.0))
    with pytest.raises(CamtoolsError, match=r"line 73 = '350,60.*may have been cut short"):
        geometry_of(tmp_path, scan[:-2])
    with pytest.raises(CamtoolsError, match="may have been cut short"):
        geometry_of(tmp_path, scan[:-1])


def test_what_the_scan_covers_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Heights, points, and the widest gap that the curve bridges."""
    scan = csv_of((0.0, 60.0))
    rows = [
        line for line in scan.splitlines() if line[:3] not in ("310", "320", "330", "340", "350")
    ]
    for text, told in (
        (scan, "the scan has 72 points at 2 heights, 0 .. 60 mm, without a gap in the angle"),
        (
            "\n".join(rows) + "\n",
            "the scan has 62 points at 2 heights, 0 .. 60 mm; bridged gaps in the angle: 2, at "
            "most 0 um beyond their ends, the widest from 300 to 0 degrees at 0 mm",
        ),
    ):
        geometry_of(tmp_path, text, "overshoot_um = 50")
        assert mktables([str(tmp_path / "part.toml"), "-o", str(tmp_path)]) == 0
        shown = capsys.readouterr().out
        assert told in re.sub(r"at most [\d.]+ um beyond", "at most 0 um beyond", shown)


def test_filter_keeps_waves_and_removes_noise(tmp_path: Path) -> None:
    """Waves below the limit stay exactly, those above go; the distance to the points is told."""
    scan = parse_scan(csv_of(), "s.csv")
    kept = scan_surface(filtered(scan, 4)).delta(np.radians(scan.angle_deg), 0.0).delta
    np.testing.assert_allclose(kept, scan.reduction_mm[0], atol=1e-6)
    gone = scan_surface(filtered(scan, 2)).delta(np.radians(scan.angle_deg), 0.0).delta
    oval_um = 50 * (1 - np.cos(np.radians(2 * scan.angle_deg)))
    np.testing.assert_allclose(gone * 1000, oval_um, atol=1e-2)
    geometry = geometry_of(tmp_path, csv_of(), f"harmonics = 2\n{SINGLE}")
    assert geometry.off_points_um == pytest.approx(5.0, abs=0.1)
    assert geometry_of(tmp_path, csv_of(), SINGLE).off_points_um == pytest.approx(0, abs=1e-9)


def test_ovality_is_a_difference_of_diameters() -> None:
    """Odd waves cancel in a diameter; the oval of 0.1 mm remains."""
    spline = ovality_of(parse_scan(csv_of((0.0, 60.0)), "s.csv"))
    assert float(spline(30.0)) == pytest.approx(0.2, abs=1e-9)


GOOD = csv_of((0.0, 60.0))
BAD = {
    "header": (csv_of(first="angle,z,r"), "line 1: wrong header"),
    "empty": ("", "line 1: wrong header"),
    "words": (GOOD + "a,b,c\n", "line 74: not three numbers"),
    "columns": (GOOD + "1,2\n", "line 74 = '1,2': not three numbers"),
    "nan": (GOOD + "1,2,nan\n", "line 74 = '1,2,nan'"),
    "angle": (GOOD + "361,0,1\n", "no angle of 0 .. 360"),
    "closed": (GOOD + "360,0,1\n", "height 0 mm: 360 degrees differ by 1 um from 0 degrees"),
    "millimetres": (GOOD + "5,0,99999\n", "beyond -15 .. 15 mm"),
    "radius": (
        GOOD.replace("reduction_um", "radius_mm"),
        "a radius of 105 mm, the profile has 44.96",
    ),
    "decimal comma": (GOOD + "5,0,1,5\n", "not three numbers"),
    "twice": (GOOD + "10,0,1\n", "this point appears twice"),
    "few": (HEADER + "\n" + "".join(f"{a},0,1\n" for a in range(0, 330, 30)), "has 11 angles"),
    "cover": (csv_of((0.0, 50.0)), "heights 0 .. 50 mm do not cover the profile's"),
}


@pytest.mark.parametrize("name", list(BAD))
def test_bad_scans_are_refused(name: str, tmp_path: Path) -> None:
    """One line that names the line or height, and what to do."""
    text, problem = BAD[name]
    with pytest.raises(CamtoolsError) as info:
        geometry_of(tmp_path, text)
    (line,) = info.value.lines
    assert problem in line
    assert "; " in line


def test_too_many_waves_are_refused(tmp_path: Path) -> None:
    """36 points tell 17 waves apart, not 18."""
    geometry_of(tmp_path, GOOD, "harmonics = 17")
    with pytest.raises(CamtoolsError, match=r"harmonics: 36 points .* 18 waves; .* at most 17"):
        geometry_of(tmp_path, GOOD, "harmonics = 18")


def test_scans_come_from_files_only(tmp_path: Path) -> None:
    """A device, a pipe and a file without end are not read; a spreadsheet's mark is no matter."""
    pipe, table = tmp_path / "pipe.csv", tmp_path / "scan.csv"
    os.mkfifo(pipe)
    table.write_bytes(b"0" * (100 * MAX_POINTS + 1))
    for path, problem in (
        (tmp_path, "Is a directory"),
        (Path("/dev/null"), "not a file"),
        (table, "larger than 20000000 bytes"),
        (pipe, "not a file"),
    ):
        with pytest.raises(CamtoolsError) as info:
            read_scan_text(path)
        told = f"piston.section.csv: {path.name}: cannot be read: {problem}; give a text file, "
        assert info.value.lines == [f"{told}with its path relative to the part file"]
    table.write_text(GOOD, encoding="utf-8-sig")
    assert joined(read_scan_text(table)).scan.z_mm.tolist() == [0, 60]
