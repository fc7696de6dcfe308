# SPDX-License-Identifier: Apache-2.0
"""Scans as instruments write them: units, separators, 360 degrees, angles of each height's own."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats
from camtools.cli.mktables import main as mktables
from camtools.skirt.geometry.skirt_geometry import Geometry, make_geometry
from tests.tools.cases.camsim_cases import camsim, columns_of
from tests.tools.cases.part_cases import load_part

RADIUS_MM = 40.0
HEIGHTS_MM = (0.0, 8.0, 16.0, 24.0)
PART = """\
[part]
name = "points"
kind = "piston"
source = "Invented."

[piston.profile]
height_mm = [0, 24]
diameter_mm = [80, 80]

[piston.section]
shape = "table"
csv = "points.csv"
{more}

[process]
spindle_rpm = 600
feed_mm = 0.5
direction = {direction}
"""


def reduction_mm(deg: Floats, z_mm: Floats) -> Floats:
    """Return a section without any symmetry; its waves change linearly with height."""
    phi, share = np.radians(deg), z_mm / 24
    oval = 0.06 * (1 - np.cos(2 * phi)) * (1 + share)
    return np.asarray(oval + 0.01 * np.sin(3 * phi + 0.4) * (1 - share) + 0.004 * np.cos(phi - 1))


def rows_of(own_angles: Callable[[int], Floats]) -> list[tuple[float, float, float]]:
    """Return angle, height and reduction [mm] of all points."""
    return [
        (deg, z_mm, float(reduction_mm(np.array(deg), np.array(z_mm))))
        for i, z_mm in enumerate(HEIGHTS_MM)
        for deg in own_angles(i).tolist()
    ]


def every_5_deg(_: int) -> Floats:
    """Return the same angles for every height."""
    return np.arange(0.0, 360, 5)


def own(i: int) -> Floats:
    """Return angles that differ in number and place from height to height, uneven ones too."""
    n = (72, 80, 97, 120)[i]
    even = 360 * np.arange(n) / n
    return np.asarray(np.mod(even + 1.3 * i + np.sin(np.radians(2 * even)), 360))


def geometry_of(folder: Path, text: str, more: str = "", direction: int = 1) -> Geometry:
    """Return the geometry of a part with this scan beside it."""
    (folder / "points.csv").write_text(text)
    (folder / "points.toml").write_text(PART.format(more=more, direction=direction))
    return make_geometry(load_part(folder / "points.toml"))


def text_of(header: str, line: str, factor: float, comma: str = ".") -> str:
    """Return the points in a format: `line` has places for angle, height and value."""
    rows = [line.format(a, z, factor * mm) for a, z, mm in rows_of(every_5_deg)]
    return "\n".join([header, *(row.replace(".", comma) for row in rows)]) + "\n"


FORMATS = {
    "um": text_of("angle_deg,z_mm,reduction_um", "{:.1f},{:.1f},{:.9f}", 1000),
    "mm": text_of("angle_deg, z_mm, reduction_mm", "{:.1f}, {:.1f}, {:.12f}", 1),
    "semicolon": text_of("angle_deg;z_mm;reduction_um", "{:.1f};{:.1f};{:.9f}", 1000),
    "decimal comma": text_of("angle_deg;z_mm;reduction_um", "{:.1f};{:.1f};{:.9f}", 1000, ","),
    "tabs": text_of("angle_deg\tz_mm\treduction_mm", "{:.1f}\t{:.1f}\t{:.12f}", 1),
    "blanks": text_of("angle_deg  z_mm  reduction_um", "  {:6.1f}   {:.1f} {:14.9f} ", 1000),
    "windows": text_of("angle_deg,z_mm,reduction_um", "{:.1f},{:.1f},{:.9f}\r", 1000),
}


@pytest.mark.parametrize("name", list(FORMATS))
def test_every_format_gives_the_same_section(tmp_path: Path, name: str) -> None:
    """Unit and separator stand in the header; the surface is the formula at every point."""
    geometry = geometry_of(tmp_path, FORMATS[name])
    deg, z_mm = np.arange(0.0, 360, 5), np.array(HEIGHTS_MM)[:, None]
    got = geometry.delta(np.radians(deg), z_mm).delta
    np.testing.assert_allclose(got, reduction_mm(deg, z_mm), atol=1e-11)
    assert geometry.joined_um == 0


def test_radii_are_taken_off_the_profile(tmp_path: Path) -> None:
    """radius_mm is what a measuring machine gives: the reduction is the profile's radius less."""
    rows = [f"{a} {z} {RADIUS_MM - mm:.12f}" for a, z, mm in rows_of(every_5_deg)]
    geometry = geometry_of(tmp_path, "\n".join(["angle_deg z_mm radius_mm", *rows, ""]))
    deg = np.arange(0.0, 360, 5)
    got = geometry.radius_mm(8.0) - geometry.delta(np.radians(deg), 8.0).delta
    np.testing.assert_allclose(got, RADIUS_MM - reduction_mm(deg, np.array(8.0)), atol=1e-11)


def test_a_closed_turn_is_the_same_section(tmp_path: Path) -> None:
    """360 degrees may stand beside 0 or instead of it; the table has the same bytes."""
    text = FORMATS["um"]
    first = [line for line in text.splitlines() if line.startswith("0.0,")]
    ends = [line.replace("0.0,", "360.0,", 1) for line in first]
    tables = []
    for one in (text, text + "\n".join(ends) + "\n", text.replace("\n0.0,", "\n360.0,")):
        geometry_of(tmp_path, one)
        assert mktables([str(tmp_path / "points.toml"), "-o", str(tmp_path)]) == 0
        tables.append((tmp_path / "points.camtab").read_bytes())
    assert tables[0] == tables[1] == tables[2]
    with pytest.raises(CamtoolsError, match="360 degrees differ by 5 um from 0 degrees"):
        changed = f"360,0,{float(first[0].split(',')[2]) + 5}\n"
        geometry_of(tmp_path, text + changed)


def own_text() -> str:
    """Return points at each height's own angles."""
    rows = [f"{a!r},{z!r},{1000 * mm!r}" for a, z, mm in rows_of(own)]
    return "\n".join(["angle_deg,z_mm,reduction_um", *rows]) + "\n"


@pytest.mark.parametrize("more", ["", "harmonics = 3"])
def test_heights_may_have_angles_of_their_own(tmp_path: Path, more: str) -> None:
    """The surface is the formula between the points too, within the stated error; filtered too."""
    geometry = geometry_of(tmp_path, own_text(), more)
    assert 0 < geometry.joined_um < 1e-3
    assert geometry.off_points_um is not None
    assert geometry.off_points_um < 2e-3
    deg, z_mm = np.linspace(0, 360, 1441), np.array(HEIGHTS_MM)[:, None]
    got = geometry.delta(np.radians(deg), z_mm).delta
    assert 1e3 * np.abs(got - reduction_mm(deg, z_mm)).max() < 5e-3


@pytest.mark.parametrize("direction", [1, -1])
def test_cut_from_uneven_points_is_the_formula(tmp_path: Path, direction: int) -> None:
    """What the simulator leaves of the work is the measured section, with M3 and with M4."""
    geometry_of(tmp_path, own_text(), direction=direction)
    assert mktables([str(tmp_path / "points.toml"), "-o", str(tmp_path)]) == 0
    surface = tmp_path / "s.csv"
    done = camsim("run", tmp_path / "points.camtab", "--surface", surface)
    assert done.returncode == 0, done.stderr
    turn, z_mm, radius_mm, *_ = columns_of(surface).values()
    off_um = 1e3 * np.abs(radius_mm - RADIUS_MM + reduction_mm(360 * turn, z_mm))
    assert off_um.max() < 0.3


def test_noise_at_angles_of_its_own_is_refused(tmp_path: Path) -> None:
    """No common angles follow points that lie closer than the samples are."""
    noise = np.random.default_rng(1).normal(0, 2, (2, 20))
    angles = [np.append(0.01 * np.arange(6), 25.0 * np.arange(1, 15)), 18.0 * np.arange(20)]
    rows = [
        f"{a!r},{z},{um!r}"
        for z, deg, ums in zip((0, 24), angles, noise.tolist(), strict=True)
        for a, um in zip(deg.tolist(), ums, strict=True)
    ]
    with pytest.raises(CamtoolsError, match="heights have different angles") as info:
        text = "\n".join(["angle_deg,z_mm,reduction_um", *rows, ""])
        geometry_of(tmp_path, text)
    assert "; measure all heights at the same angles" in info.value.lines[0]


def test_half_a_turn_of_points_is_refused(tmp_path: Path) -> None:
    """Where nothing was measured the curve may not swing: place, size, and a remedy that helps."""
    half = rows_of(lambda _: np.arange(0.0, 181, 5))
    text = "angle_deg,z_mm,reduction_mm\n" + "".join(f"{a},{z},{r}\n" for a, z, r in half)
    with pytest.raises(CamtoolsError, match="no points from 180 to 0 degrees") as info:
        geometry_of(tmp_path, text)
    remedy = re.search(r"overshoot_um = [0-9.e+]+", info.value.lines[0])
    assert remedy, info.value.lines
    geometry_of(tmp_path, text, remedy[0])


def test_a_gap_without_a_swing_is_taken(tmp_path: Path) -> None:
    """Half of the points between 30 and 60 degrees are missing: the curve is as before there."""
    rows = rows_of(lambda _: np.concatenate([[0.0, 10, 20, 30], np.arange(60.0, 360, 5)]))
    text = "angle_deg,z_mm,reduction_mm\n" + "".join(f"{a},{z},{r}\n" for a, z, r in rows)
    found = geometry_of(tmp_path, text).surface.delta(np.radians(np.array([45.0])), 8.0).delta
    assert abs(float(found[0]) - float(reduction_mm(np.array(45.0), np.array(8.0)))) < 3e-4
