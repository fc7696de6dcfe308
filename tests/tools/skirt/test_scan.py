"""Measured sections: files of instruments, filtering, the surface through the points, tables."""

import os
import re
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from camtools.base.errors import CamtoolsError, GeometryError
from camtools.base.quantities import Floats
from camtools.skirt.geometry.outliers import outliers
from camtools.skirt.geometry.scan import (
    Scan,
    filtered,
    joined,
    ovality_of,
    parse_scan,
    scan_surface,
)
from camtools.skirt.geometry.section_file import HEADER, MAX_POINTS, Sections, read_scan_text
from camtools.skirt.geometry.skirt_geometry import Geometry, make_geometry
from camtools.skirt.part.part_file import SkirtPart
from camtools.skirt.table.generate import generate
from camtools.table.points import parse_points
from tests.tools.cases.camsim_cases import cut, form_um, plain
from tests.tools.cases.cut_cases import PARTS, made_skirt, written
from tests.tools.cases.part_cases import changed, load_part, points_part, points_text, refused, sure

MEASURED = PARTS / "scan90.toml"
SINGLE = "single_height = true"


def csv_of(heights: tuple[float, ...] = (0.0,), first: str = HEADER) -> str:
    """Return a good scan: an oval of 0.1 mm with three waves, deeper with height."""
    deg, z_mm = np.arange(0, 360, 10), np.array(heights)[:, None]
    um = 50 * (1 - np.cos(np.radians(2 * deg))) + 5 * np.sin(np.radians(3 * deg)) + z_mm
    return points_text(first, deg, z_mm, um)


def points_of(
    folder: Path, text: str, more: str = "", height_mm: str = "[0, 24]", direction: int = 1
) -> Geometry:
    """Return the geometry of a part with this scan beside it."""
    return make_geometry(points_part(folder, text, more, height_mm, direction))


geometry_of = partial(points_of, height_mm="[0, 60]")


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


def test_what_the_scan_covers_is_told(tmp_path: Path) -> None:
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
        shown = made_skirt(load_part(tmp_path / "points.toml")).text()
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
    geometry_of(tmp_path, csv_of(), f"harmonics = 17\n{SINGLE}")  # as many as 36 points tell apart


def test_scans_come_from_files_only(tmp_path: Path) -> None:
    """A device, a pipe and a file without end are not read.

    Ovality is a difference of diameters, in which odd waves cancel.
    """
    pipe, table = tmp_path / "pipe.csv", tmp_path / "scan.csv"
    os.mkfifo(pipe)
    table.write_bytes(b"0" * (100 * MAX_POINTS + 1))
    for path, problem in (
        (tmp_path, "Is a directory"),
        (Path("/dev/null"), "not a file"),
        (table, "larger than 20000000 bytes"),
        (pipe, "not a file"),
    ):
        told = f"piston.section.csv: {path.name}: cannot be read: {problem}; give a text file, "
        line = refused(lambda: read_scan_text(path))  # noqa: B023
        assert line == f"{told}with its path relative to the part file"
    table.write_text(csv_of((0.0, 60.0)))
    scan = joined(read_scan_text(table))[0]
    assert scan.z_mm.tolist() == [0, 60]
    assert float(ovality_of(scan)(30.0)) == pytest.approx(0.2, abs=1e-9)


GOOD = csv_of((0.0, 60.0))
WAVES = "36 points per turn are too few for 18 waves; give at most 17"
BAD = {
    "header": (csv_of(first="angle_deg,z_mm,r"), "line 1: needs one column of the value: red"),
    "no rows": (HEADER + "\n", "has 0 angles"),
    "angle": (GOOD + "361,0,1\n", "line 74: no angle of 0 .. 360"),
    "closed": (GOOD + "360,0,1\n", "height 0 mm: 360 degrees differ by 1 um from 0 degrees"),
    "millimetres": (GOOD + "5,0,99999\n", "beyond -15 .. 15 mm"),
    "radius": (
        GOOD.replace("reduction_um", "radius_mm"),
        "a radius of 105 mm, the profile has 40",
    ),
    "twice": (GOOD + "10,0,1\n", "this point appears twice"),
    "few": (points_text(HEADER, np.arange(0, 330, 30), 0, 1), "has 11 angles"),
    "cover": (csv_of((0.0, 50.0)), "heights 0 .. 50 mm do not cover the profile's"),
    "one height": (csv_of((30.0,)), f"has one height only, 30 mm; measure more, or set {SINGLE}"),
    "two heights": (GOOD, "single_height: is true, but the file has 2 heights", SINGLE),
    "cut short": (GOOD[:-1], "may have been cut short"),  # 1.2 may be the begin of 1.25
    "waves": (GOOD, f"harmonics: {WAVES}", "harmonics = 18"),
}


@pytest.mark.parametrize("name", list(BAD))
def test_bad_scans_are_refused(name: str, tmp_path: Path) -> None:
    """One line that names the line or height, and what to do."""
    text, problem, *more = BAD[name]
    line = refused(lambda: geometry_of(tmp_path, text, *more))
    assert problem in line
    assert "; " in line


RADIUS_MM = 40.0
HEIGHTS_MM = (0.0, 8.0, 16.0, 24.0)


def reduction_mm(deg: Floats, z_mm: Floats) -> Floats:
    """Return a section without any symmetry; its waves change linearly with height."""
    phi, share = np.radians(deg), z_mm / 24
    oval = 0.06 * (1 - np.cos(2 * phi)) * (1 + share)
    return np.asarray(oval + 0.01 * np.sin(3 * phi + 0.4) * (1 - share) + 0.004 * np.cos(phi - 1))


def own(i: int) -> Floats:
    """Return angles that differ in number and place from height to height, uneven ones too."""
    n = (72, 80, 97, 120)[i]
    even = 360 * np.arange(n) / n
    return np.asarray(np.mod(even + 1.3 * i + np.sin(np.radians(2 * even)), 360))


EVERY_5_DEG, RISING_MM = np.arange(0.0, 360, 5), np.array(HEIGHTS_MM)[:, None]
EVEN_MM = reduction_mm(EVERY_5_DEG, RISING_MM)
FORMATS = {
    "um": points_text(HEADER, EVERY_5_DEG, RISING_MM, 1000 * EVEN_MM),
    "mm": points_text("angle_deg,z_mm,reduction_mm", EVERY_5_DEG, RISING_MM, EVEN_MM),
    "radius": points_text("angle_deg,z_mm,radius_mm", EVERY_5_DEG, RISING_MM, RADIUS_MM - EVEN_MM),
}
FORMATS["mm"] = FORMATS["mm"].replace(",", ", ")


@pytest.mark.parametrize("name", list(FORMATS))
def test_every_format_gives_the_same_section(tmp_path: Path, name: str) -> None:
    """The header names the unit; the surface is the formula at every point.

    Radii, as a measuring machine gives them, are taken off the profile.
    """
    geometry = points_of(tmp_path, FORMATS[name])
    got = geometry.delta(np.radians(EVERY_5_DEG), RISING_MM).delta
    np.testing.assert_allclose(got, EVEN_MM, atol=1e-11)
    assert geometry.joined_um == 0


def test_a_closed_turn_is_the_same_section(tmp_path: Path) -> None:
    """360 degrees may stand beside 0 or instead of it; the section is the same to the bit."""
    text = FORMATS["um"]
    first = [line for line in text.splitlines() if line.startswith("0.0,")]
    ends = [line.replace("0.0,", "360.0,", 1) for line in first]
    tables = []
    for one in (text, text + "\n".join(ends) + "\n", text.replace("\n0.0,", "\n360.0,")):
        points = points_of(tmp_path, one).delta(np.linspace(0, 7, 99), 8.3).delta
        tables.append(points.tobytes())
    assert tables[0] == tables[1] == tables[2]
    with pytest.raises(CamtoolsError, match="360 degrees differ by 5 um from 0 degrees"):
        changed = f"360,0,{float(first[0].split(',')[2]) + 5}\n"
        points_of(tmp_path, text + changed)


def mm_text(own_angles: Callable[[int], Floats]) -> str:
    """Return points at some angles of each height, with all their digits."""
    angles = [own_angles(i) for i in range(len(HEIGHTS_MM))]
    deg, z_mm = np.concatenate(angles), np.repeat(HEIGHTS_MM, [one.size for one in angles])
    return points_text("angle_deg,z_mm,reduction_mm", deg, z_mm, reduction_mm(deg, z_mm))


@pytest.mark.parametrize("more", ["", "harmonics = 3"])
def test_heights_may_have_angles_of_their_own(tmp_path: Path, more: str) -> None:
    """The surface is the formula between the points too, within the stated error; filtered too."""
    geometry = points_of(tmp_path, mm_text(own), more)
    assert 0 < geometry.joined_um < 1e-3
    assert sure(geometry.off_points_um) < 2e-3
    deg = np.linspace(0, 360, 1441)
    got = geometry.delta(np.radians(deg), RISING_MM).delta
    assert 1e3 * np.abs(got - reduction_mm(deg, RISING_MM)).max() < 5e-3


def test_cut_from_uneven_points_is_the_formula(tmp_path: Path) -> None:
    """What the simulator leaves of the work is the measured section."""
    points_of(tmp_path, mm_text(own), direction=-1)
    made = made_skirt(load_part(tmp_path / "points.toml"))
    turn, z_mm, radius_mm, *_ = plain(cut(written(made, tmp_path)).surface)
    off_um = 1e3 * np.abs(radius_mm - RADIUS_MM + reduction_mm(360 * turn, z_mm))
    assert off_um.max() < 0.3


def test_noise_at_angles_of_its_own_is_refused(tmp_path: Path) -> None:
    """No common angles follow points that lie closer than the samples are."""
    noise = np.random.default_rng(1).normal(0, 2, (2, 20))
    angles = [np.append(0.01 * np.arange(6), 25.0 * np.arange(1, 15)), 18.0 * np.arange(20)]
    text = points_text(HEADER, np.stack(angles), [[0], [24]], noise)
    line = refused(lambda: points_of(tmp_path, text))
    assert "heights have different angles" in line
    assert "; measure all heights at the same angles" in line


def test_gaps_without_points(tmp_path: Path) -> None:
    """Half a turn may not swing, and the remedy helps; a gap of 30 degrees is bridged well."""
    text = mm_text(lambda _: np.arange(0.0, 181, 5))
    line = refused(lambda: points_of(tmp_path, text))
    remedy = re.search(r"no points from 180 to 0 degrees.*(overshoot_um = [0-9.e+]+)", line)
    assert remedy, line
    points_of(tmp_path, text, remedy[1])
    text = mm_text(lambda _: np.concatenate([[0.0, 10, 20, 30], np.arange(60.0, 360, 5)]))
    found = points_of(tmp_path, text).surface.delta(np.radians(np.array([45.0])), 8.0).delta
    assert abs(float(found[0]) - float(reduction_mm(np.array(45.0), np.array(8.0)))) < 3e-4


def oval_um(deg: Floats, z_mm: Floats | float) -> Floats:
    """Return an oval of 100 um at height 0 and 150 um at 30."""
    return np.asarray((50 + z_mm / 1.2) * (1 - np.cos(np.radians(2 * deg))))


EVERY_3_DEG = np.arange(0.0, 360, 3)
TENS_MM = (0.0, 10.0, 20.0, 30.0)


def oval_part(
    folder: Path, values_um: dict[float, Floats], more: str = "", height_mm: str = "[0, 30]"
) -> SkirtPart:
    """Return a part of 80 mm with a point every 3 degrees at these heights."""
    z_mm, um = np.array(list(values_um))[:, None], np.stack(list(values_um.values()))
    return points_part(folder, points_text(HEADER, EVERY_3_DEG, z_mm, um), more, height_mm)


@pytest.mark.parametrize(
    ("off_um", "names"), [((0, 1, 2), "0, 0.001, 0.002"), ((0, 3, 9, 5), "0, 0.003, .., 0.009")]
)
def test_heights_of_a_machine_that_does_not_hold_them_are_named(
    off_um: tuple[int, ...], names: str, tmp_path: Path
) -> None:
    """Points of a section with micrometres between them would be sections of their own."""
    z_mm = np.array(TENS_MM)[:, None]
    um, z_mm = oval_um(EVERY_3_DEG, z_mm), z_mm + np.resize(off_um, EVERY_3_DEG.size) / 1000
    x_mm, y_mm = (40 * of(np.radians(EVERY_3_DEG)) for of in (np.cos, np.sin))
    polar = points_text(HEADER, EVERY_3_DEG, z_mm, um)
    for text in (polar, points_text("x_mm,y_mm,z_mm", x_mm, y_mm, z_mm)):
        line = refused(lambda: points_of(tmp_path, text))  # noqa: B023
        assert f"z_mm: the heights {names} mm are less than 0.01 mm apart; give all points" in line
    with pytest.raises(CamtoolsError, match=f"the heights {names} mm are less"):
        parse_points(polar.replace(HEADER, "X_deg,z_mm,y_um"), "a.csv")


def off_at_45(off_um: float = 525.0) -> dict[float, Floats]:
    """Return the oval with one point at height 10 mm that is off."""
    values = {z_mm: oval_um(EVERY_3_DEG, z_mm) for z_mm in TENS_MM}
    values[10.0][15] += off_um
    return values


OFF = "the point at 45 degrees, height 10 mm, is 525 um off its neighbours"


def test_a_point_off_its_neighbours_is_named(tmp_path: Path) -> None:
    """Where the heights are joined too far, where something else is refused, and in a table."""
    line = refused(lambda: make_geometry(oval_part(tmp_path, off_at_45())))
    assert line.startswith(f"piston.section.csv: {OFF}, and between the heights 20 and 30 mm")
    assert "; measure this point again, or remove its line, or allow it: overshoot_um = " in line
    made = made_skirt(oval_part(tmp_path, off_at_45(), 'harmonics = 4\ninterpolation = "linear"'))
    assert f"  caution: {OFF}\n" in made.text()
    with pytest.raises(CamtoolsError) as info:
        generate(oval_part(tmp_path, off_at_45(-525), 'interpolation = "pchip"'))
    first, second = info.value.lines
    assert first == f"piston.section.csv: {OFF}; measure this point again, or remove its line"
    assert second.startswith("tool.clearance_deg: the heel of 7 degrees rubs")
    assert str(info.value) == f"{first}\n{second}"
    wrong = f"\n45.0,10.0,{off_at_45(-525)[10.0][15]}"
    without = (tmp_path / "points.csv").read_text().replace(wrong, "")
    (tmp_path / "points.csv").write_text(without)
    assert "caution" not in made_skirt(load_part(tmp_path / "points.toml")).text()


def sections_of(rows: list[Floats], deg: Floats = EVERY_3_DEG) -> Sections:
    """Return sections of reductions [um], a height of 1 mm apart."""
    n = len(rows)
    return Sections(np.arange(float(n)), (deg,) * n, tuple(row / 1000 for row in rows))


def test_noise_waves_and_corners_are_no_outliers() -> None:
    """Nor are two wrong points together; single ones are, from 1 um on, at uneven angles too."""
    rng, oval = np.random.default_rng(3), oval_um(EVERY_3_DEG, 0.0)
    corner = np.minimum(oval, 200 - oval) + 40 * np.abs(np.sin(np.radians(EVERY_3_DEG - 51)))
    steps = np.where(EVERY_3_DEG > 200, 30.0, 0.0)
    noisy = [row + noise for row in (oval, corner) for noise in rng.normal(0, 2, (50, 120))]
    twice = oval + 50.0 * np.isin(EVERY_3_DEG, (90, 93))
    assert outliers(sections_of([oval, corner, steps, twice, 0 * oval, *noisy])) == []
    uneven = EVERY_3_DEG + np.sin(EVERY_3_DEG)
    for off_um in (-500.0, 1.1):
        for i in (0, 1, 60, 118, 119):
            row = oval_um(uneven, 0.0)
            row[i] += off_um
            [found] = outliers(sections_of([oval_um(uneven, 0.0), row], uneven))
            assert (found.z_mm, found.angle_deg) == (1.0, uneven[i])
            assert found.off_um == pytest.approx(off_um, abs=0.02)
    assert outliers(sections_of([oval + 0.9 * (EVERY_3_DEG == 9)])) == []


EXCEEDS = "  {}the surface exceeds the profile's diameter by up to {} mm, at {} degrees"


@pytest.mark.parametrize(
    ("sign", "off_um", "told"),
    [
        (-1.0, 0.0, EXCEEDS.format("caution: ", 0.3, 90)),  # 2 x 150 um
        (1.0, 0.0, ""),
        (1.0, -2.0, EXCEEDS.format("", 0.004, 0)),
        (1.0, 20 * np.cos(np.radians(EVERY_3_DEG)), ""),  # beyond at one side, within at the other
    ],
)
def test_diameters_beyond_the_profile_are_named(
    sign: float, off_um: Floats | float, told: str, tmp_path: Path
) -> None:
    """With a caution where a scan has the wrong sign, without one for 4 um of 100."""
    values = {z_mm: sign * oval_um(EVERY_3_DEG, z_mm) + off_um for z_mm in TENS_MM}
    shown = made_skirt(oval_part(tmp_path, values)).text()
    assert told in shown and ("exceeds" in shown) == bool(told)
    if sign < 0:
        assert "height 30 mm; reductions are positive towards the axis\n" in shown


def true_um(phi: Floats, z_mm: Floats) -> Floats:
    """Return the section that is measured: an oval with waves of three and five."""
    oval = (50 + 0.4 * z_mm) * (1 - np.cos(2 * phi))
    return np.asarray(oval + 1.5 * np.cos(3 * phi) + 0.6 * np.cos(5 * phi + z_mm / 40))


def scan_part(
    folder: Path, n: int, z_mm: list[float], noise_um: float, **keys: object
) -> SkirtPart:
    """Return a part of n noisy points at each height."""
    deg, heights_mm = 360 * np.arange(n) / n, np.array(z_mm)[:, None]
    noise = noise_um * np.random.default_rng(7).standard_normal((len(z_mm), n))
    um = true_um(np.radians(deg), heights_mm) + noise
    (folder / "long.csv").write_text(points_text(HEADER, deg, heights_mm, um))
    section = {"shape": "table", "csv": str(folder / "long.csv")} | keys
    return changed(load_part(MEASURED), {"piston.section": section})


def test_remedy_of_a_long_scan_makes_the_table(tmp_path: Path) -> None:
    """The number of waves that the message names is taken, and the cut is the true section."""
    part = scan_part(tmp_path, 360, [0.0], 0.05, single_height=True)
    line = refused(lambda: generate(part), GeometryError)
    assert "no table through all points of the scan" in line
    told = sure(re.search(r"set harmonics = (\d+): .* within ([\d.]+) um", line))
    made = made_skirt(changed(part, {"piston.section.harmonics": int(told[1])}))
    geometry = made.table.geometry
    assert geometry.off_points_um == pytest.approx(float(told[2]), rel=0.01)
    found = cut(written(made, tmp_path), "--turns-limit", "20")
    turn, z_mm, radius_mm, *_ = plain(found.surface)
    off_um = 1e3 * (geometry.radius_mm(z_mm) - radius_mm) - true_um(2 * np.pi * turn, 0 * z_mm)
    assert np.abs(off_um).max() < 0.15  # filtered noise, control
    assert found.summary["control_error_um"]["max"] < 0.05 < form_um(found)


@pytest.mark.long
def test_long_scan_of_one_height_is_read_and_gauged(tmp_path: Path) -> None:
    """Of 3600 points the wanted waves are kept; the gauge holds all points, in less than a MB."""
    part = scan_part(tmp_path, 3600, [0.0], 0.05, harmonics=15, single_height=True)
    table = written(made_skirt(part), tmp_path)
    assert table.with_suffix(".json").stat().st_size < 1_000_000
    assert "control_error_um" in cut(table, "--turns-limit", "20").summary


def test_a_jump_between_heights_is_refused(tmp_path: Path) -> None:
    """A spline over the height would leave both heights' points by more than 1 um."""
    z_mm = np.array([[0], [15], [20], [40], [60]])
    text = points_text(HEADER, np.arange(0, 360, 15), z_mm, np.where(z_mm < 20, 0.0, 60.0))
    (tmp_path / "jump.csv").write_text(text)
    section = {"shape": "table", "csv": str(tmp_path / "jump.csv")}
    part = changed(load_part(MEASURED), {"piston.section": section})
    with pytest.raises(GeometryError, match=r"the section at 0 degrees goes .* um beyond both"):
        make_geometry(part)
    geometry = make_geometry(changed(part, {"piston.section.interpolation": "pchip"}))
    between = geometry.delta(np.radians([0.0, 17.0, 200.0]), np.linspace(0, 60, 601)[:, None]).delta
    assert between.min() >= -1e-9
    assert between.max() <= 0.06 + 1e-9
    rising = geometry.delta(np.array([0.3]), np.linspace(15, 20, 101)[:, None]).delta
    assert (np.diff(rising[:, 0]) >= 0).all()


def test_every_way_between_heights_meets_the_points(tmp_path: Path) -> None:
    """At the measured heights the surface is the points, whatever is between."""
    phi, z = np.radians(360 * np.arange(48) / 48), np.array([[0.0], [12], [30], [44], [60]])
    for interpolation in ("linear", "pchip", "akima", "spline"):
        part = scan_part(tmp_path, 48, z[:, 0].tolist(), 0.0, interpolation=interpolation)
        found = make_geometry(part).delta(phi, z).delta
        np.testing.assert_allclose(found, true_um(phi, z) * 1e-3, atol=1e-7)
