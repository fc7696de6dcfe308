"""Outlines of sections in Cartesian coordinates: centre, orientation, order, units, refusals."""

from pathlib import Path

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats
from camtools.skirt.geometry.skirt_geometry import Geometry, make_geometry
from tests.tools.cases.part_cases import points_part, points_text, refused

A_MM, B_MM, OFF_MM = 40.0, 39.8, 0.05
PHI = np.radians(np.arange(0.0, 360.0, 0.7))
ALONE = "single_height = true\n"


def geometry_of(folder: Path, text: str, more: str = ALONE) -> Geometry:
    """Make the geometry of a part with this outline."""
    return make_geometry(points_part(folder, text, more))


def ellipse(n: int) -> Floats:
    """Return points of an ellipse, even in its parameter, not in the angle, (n, 2)."""
    t = 2 * np.pi * np.arange(n) / n
    return np.stack([A_MM * np.cos(t), B_MM * np.sin(t)], axis=1)


def ellipse_mm(phi: Floats) -> Floats:
    """Return its radius over the polar angle."""
    return np.asarray(A_MM * B_MM / np.hypot(B_MM * np.cos(phi), A_MM * np.sin(phi)))


def text_of(points: Floats, header: str = "x_mm,y_mm") -> str:
    """Return a file of points."""
    return points_text(header, *points.T)


FORMS = {
    "as it is": (ellipse(180), ALONE),
    "closed": (np.vstack([ellipse(180), ellipse(180)[:1]]), ALONE),
    "clockwise": (ellipse(180)[::-1], ALONE),
    "from elsewhere": (np.roll(ellipse(180), 77, axis=0), ALONE),
    "off centre": (np.add(ellipse(180), [12.5, -7.25]), f"{ALONE}centre_mm = [12.5, -7.25]\n"),
    "turned": (ellipse(180) @ [[0, 1], [-1, 0]], f"{ALONE}phase_deg = -90\n"),
}


@pytest.mark.parametrize("name", list(FORMS))
def test_an_ellipse_is_the_same_however_it_is_listed(name: str, tmp_path: Path) -> None:
    """Between the points, too, its reduction is that of the formula."""
    points, more = FORMS[name]
    found = geometry_of(tmp_path, text_of(points), more).delta(PHI, 12.0).delta
    np.testing.assert_allclose(found, A_MM - ellipse_mm(PHI), atol=1e-6)


def test_y_points_to_90_degrees(tmp_path: Path) -> None:
    """A circle whose centre is off in y is largest at 90 degrees; inches are read as well."""
    t = 2 * np.pi * np.arange(90) / 90
    points = np.stack([39.9 * np.cos(t), OFF_MM + 39.9 * np.sin(t)], axis=1)
    radius = OFF_MM * np.sin(PHI) + np.sqrt(39.9**2 - (OFF_MM * np.cos(PHI)) ** 2)
    for text in (text_of(points), text_of(points[:, ::-1] / 25.4, "y_inch,x_inch")):
        found = geometry_of(tmp_path, text).delta(PHI, 0.0).delta
        np.testing.assert_allclose(found, 40 - radius, atol=1e-6)


def test_each_height_has_an_outline_of_its_own(tmp_path: Path) -> None:
    """With a column of heights; between two of them the surface is straight."""
    low = np.hstack([ellipse(120), np.zeros((120, 1))])
    high = np.hstack([1.0005 * ellipse(150), np.full((150, 1), 24.0)])
    text = text_of(np.vstack([low, high]), "x_mm,y_mm,z_mm")
    found = geometry_of(tmp_path, text, "").delta(PHI, 12.0).delta
    np.testing.assert_allclose(found, 40 - 1.00025 * ellipse_mm(PHI), atol=2e-6)


POINTS = ellipse(36)
TWICE = np.vstack([POINTS[:5], POINTS[4:]])
SWAPPED = POINTS[[0, 1, 2, 4, 3, *range(5, 36)]]
HOOKED = np.vstack([POINTS, np.add(POINTS[:1], [-1.0, 1.0])])
WITH_Z = [text_of(np.hstack([POINTS, np.full((36, 1), z)])) for z in (0.0, 24.0, 0.0)]
REFUSED = [
    (text_of(POINTS[:30]), ALONE, "line 31: ", "is not closed: seen from the centre (0, 0) it e"),
    (text_of(HOOKED), ALONE, "line 38: ", "the outline is not closed"),
    (text_of(SWAPPED), ALONE, "line 6: ", "turns back at this point, so it is not star-shaped"),
    (text_of(SWAPPED[::-1]), ALONE, "line 34: ", "turns back at this point"),
    (
        text_of(np.vstack([POINTS, 1.001 * POINTS])),
        ALONE,
        "line 73: ",
        "the outline that ends here does not run round it once",
    ),
    (text_of(TWICE), ALONE, "line 7: ", "turns back at this point"),
    (
        text_of(POINTS),
        f"{ALONE}centre_mm = [45, 0]\n",
        "line 37: ",
        "seen from the centre (45, 0) the outline that ends here does not run round it",
    ),
    (
        "".join([WITH_Z[0], *(one.partition("\n")[2] for one in WITH_Z[1:])]).replace(
            "x_mm,y_mm", "x_mm,y_mm,z_mm"
        ),
        "",
        "line 74: ",
        "height 0 mm appears again",
    ),
    (text_of(POINTS, "x_mm,y"), ALONE, "line 1: ", "needs one column of the y: y_mm, y_inch"),
    (
        "angle_deg,z_mm,radius_mm\n",
        "centre_mm = [0, 0]\n",
        "line 1: ",
        "no centre_mm belongs to them; remove piston.section.centre_mm",
    ),
    (text_of(POINTS), "", "", "has one height only, 0 mm; measure more, or set single_height"),
    (text_of(POINTS / 2), ALONE, "", "a radius of 19.9 mm, the profile has 40 mm"),
    (
        text_of(POINTS * np.where(np.arange(36) == 9, 60, 1)[:, None]),
        ALONE,
        "line 11: ",
        "2000 mm",
    ),
    (text_of(POINTS * 4e306), ALONE, "line 2: ", "is beyond 1e+12; correct the number"),
    (text_of(POINTS[::4]), ALONE, "", "has 9 angles, needs at least 12"),
]


@pytest.mark.parametrize(("text", "more", "line", "problem"), REFUSED)
def test_wrong_outlines_are_refused(
    text: str, more: str, line: str, problem: str, tmp_path: Path
) -> None:
    """The line of the file, what is wrong, and what to do."""
    found = refused(lambda: geometry_of(tmp_path, text, more), CamtoolsError)
    assert line in found and problem in found and "; " in found
