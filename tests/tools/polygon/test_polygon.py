"""Polygons: outlines by other constructions, blends, tables, cuts, what is refused."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError
from camtools.cli.run import main as run
from camtools.pipeline.load import Made, load, make, parse
from camtools.polygon.generate import GeneratedPolygon, bend_of, blended, generate_polygon
from camtools.polygon.outline import Outline, cornered, measures_of, p3g, p4c, regular
from camtools.polygon.part import P3G, P4C, PolygonPart
from camtools.polygon.report import draw_motion
from tests.tools.cases import polygon_cases as cases
from tests.tools.cases.camsim_cases import columns_of, plain
from tests.tools.cases.cut_cases import PARTS, cut_made, evaluated, made_of, tip_mm
from tests.tools.cases.part_cases import ROOT, refused, refused_lines

_SAME_MM = 1e-11
PHI = np.linspace(-1.0, 7.5, 701)


def derivatives_hold(outline: Outline, at: cases.Floats, h: float = 1e-4) -> None:
    """Compare the derivatives with differences of the radius of one curve."""
    for phi in at:
        curve = outline.curve_at(float(phi))
        low, here, high = (curve.polar(np.array([phi + k * h])) for k in (-1, 0, 1))
        for n, step in (("d1", "r"), ("d2", "d1"), ("d3", "d2")):
            slope = (getattr(high, step) - getattr(low, step)) / (2 * h)
            size = 1 + abs(float(getattr(here, n)[0]))
            assert float(slope[0]) == pytest.approx(float(getattr(here, n)[0]), abs=2e-4 * size)


@pytest.mark.parametrize("size", P3G.values(), ids=str)
def test_p3g_is_the_envelope_of_its_tangents(size: tuple[float, float]) -> None:
    """Every nominal size of DIN 32711; a calliper finds one width, the circles are d2 and d3."""
    phi = PHI[::35]
    r = p3g(*size, 0.0).polar(phi).r
    assert np.abs(r - cases.p3g_mm(phi, *size)).max() < _SAME_MM
    measures, (mean, e) = measures_of(p3g(*size, 0.1)), size
    assert measures.least_width_mm == pytest.approx(mean, abs=1e-5)
    assert measures.largest_width_mm == pytest.approx(mean, abs=1e-5)
    assert measures.outer_circle_mm == pytest.approx(mean + 2 * e, abs=1e-9)
    assert measures.inner_circle_mm == pytest.approx(mean - 2 * e, abs=1e-6)


@pytest.mark.parametrize("size", P4C.values(), ids=str)
def test_p4c_is_cut_by_its_circle(size: tuple[float, float, float]) -> None:
    """Every nominal size of DIN 32712 against chords of the contour; their sagitta is 1e-9 mm."""
    phi = PHI[::5]
    outline = p4c(*size, 0.0)
    assert np.abs(outline.polar(phi).r - cases.p4c_mm(phi, *size)).max() < 2e-8
    measures = measures_of(outline)
    assert measures.outer_circle_mm == pytest.approx(size[0], abs=1e-12)
    assert measures.inner_circle_mm == pytest.approx(size[1], abs=1e-6)


@pytest.mark.parametrize("n", [3, 4, 5, 6, 8, 12])
@pytest.mark.parametrize("radius", [0.0, 0.6, 4.0])
def test_regular_polygon_is_a_core_with_a_border(n: int, radius: float) -> None:
    """The outline is what lies within the corner radius of the inset polygon."""
    r = regular(n, 20.0, radius, 0.0).polar(PHI).r
    there = cases.rounded_mm(PHI, cases.regular_corners(n, 20.0), radius)
    assert np.abs(r - there).max() < _SAME_MM


@pytest.mark.long
def test_random_convex_polygons() -> None:
    """Corners anywhere on an ellipse round the axis, one radius for all."""
    rng = np.random.default_rng(32711)
    for _ in range(25):
        n = int(rng.integers(4, 9))
        angle = 2 * np.pi * (np.arange(n) + rng.uniform(-0.3, 0.3, n)) / n
        corners = np.stack([18 * np.cos(angle), 14 * np.sin(angle)], axis=-1)
        outline = cornered(corners.tolist(), [0.7] * n, 0.0)
        assert np.abs(outline.polar(PHI).r - cases.rounded_mm(PHI, corners, 0.7)).max() < _SAME_MM
        derivatives_hold(outline, rng.uniform(0, 2 * np.pi, 5), 1e-5)


@pytest.mark.parametrize(
    "outline",
    [p3g(25, 0.8, 0.3), p4c(14, 11, 1.6, -0.2), p4c(35, 30, 5, 1.0), regular(6, 20, 1, 0.1)],
)
def test_derivatives(outline: Outline) -> None:
    """Three derivatives of every curve."""
    derivatives_hold(outline, np.linspace(0.02, 6.2, 23))


def test_phase_and_repeats() -> None:
    """A phase turns counter-clockwise; a rectangle repeats twice, a square 4 times, a kite not."""
    outline = regular(4, 10.0, 0.5, float(np.radians(30)))
    corner = outline.polar(np.radians([30.0, 120.0, 75.0])).r
    assert corner[0] == pytest.approx(corner[1], abs=1e-12)
    assert corner[2] == pytest.approx(5.0, abs=1e-12)
    assert cornered([[9, 5], [-9, 5], [-9, -5], [9, -5]], [1.0] * 4, 0.0).repeat == 2
    assert cornered([[5, 5], [-5, 5], [-5, -5], [5, -5]], [1.0] * 4, 0.0).repeat == 4
    assert cornered([[9, 0], [0, 5], [-6, 0], [0, -5]], [1.0] * 4, 0.0).repeat == 1
    assert cornered([[5, 5], [-5, 5], [-5, -5], [5, -5]], [1.0, 2.0] * 2, 0.0).repeat == 2


IMPOSSIBLE: list[tuple[Callable[..., Outline], tuple[object, ...], str]] = [
    (p3g, (25.0, 1.6, 0.0), r"polygon\.eccentricity_mm: 1.6 makes loops"),
    (p4c, (45.0, 30.0, 5.0, 0.0), r"polygon\.outer_diameter_mm: 45: the sides meet"),
    (p4c, (35.0, 35.0, 5.0, 0.0), r"polygon\.inner_diameter_mm: 35 is not below"),
    (regular, (6, 20.0, 10.0, 0.0), r"polygon\.corner_radius_mm: 10 leaves nothing"),
    (cornered, ([[9, 0], [0, -5], [-6, 0], [0, 5]], [1.0] * 4, 0.0), "does not turn left"),
    (cornered, ([[9, 1], [9, 5], [-6, 5], [-6, 1]], [1.0] * 4, 0.0), "is outside of the side"),
    (cornered, ([[9, -0.5], [0, 5], [-6, 0], [0, -0.6]], [0.1] * 4, 0.0), r"rises 8\d\.\d degrees"),
    (cornered, ([[9, 0], [0, 5], [-6, 0], [0, -5]], [5.0] * 4, 0.0), "use up the whole following"),
]


def test_impossible_outlines() -> None:
    """Each is refused with the key to change."""
    for shape, arguments, message in IMPOSSIBLE:
        with pytest.raises(CamtoolsError, match=message):
            shape(*arguments)


def test_sizes_of_the_manual_are_those_that_are_made() -> None:
    """P3G with both circles, d1 + 2 e1 and d1 - 2 e1, and P4C, line by line."""
    text = (ROOT / "tools" / "docs" / "POLYGONS.md").read_text().split("## Nominal sizes")[1]
    lines = [line.strip("| ").split(" | ") for line in text.splitlines() if line[:1] == "|"]
    rows = [[float(cell) for cell in line] for line in lines if line[0].isdecimal()]
    assert [(row[0], row[3]) for row in rows] == list(P3G.values())
    for d1, d2, d3, e1, *_ in rows:
        assert (d2, d3) == pytest.approx((d1 + 2 * e1, d1 - 2 * e1), abs=1e-9)
    assert [(row[0], *row[4:]) for row in rows] == list(P4C.values())


TURN = np.linspace(0, 2 * np.pi, 200_001)
SHARP = {
    "p4c": p4c(35.0, 30.0, 5.0, 0.1),
    "sharp hexagon": regular(6, 20.0, 0.0, 0.0),
    "rounded hexagon": regular(6, 20.0, 1.0, 0.2),
    "triangle": cornered([[10, -8], [10, 8], [-12, 0]], [1.0, 1.0, 2.0], 0.0),
}


@pytest.mark.long
@pytest.mark.parametrize("drawing", SHARP.values(), ids=SHARP.keys())
@pytest.mark.parametrize("blend_um", [0.3, 5.0])
def test_deviation_is_what_is_allowed(drawing: Outline, blend_um: float) -> None:
    """Dense samples are off by at most the blend, and by as much where there is room."""
    one = blended(drawing, blend_um)
    off_um = 1000 * float(np.abs(one.outline.polar(TURN).r - drawing.polar(TURN).r).max())
    assert off_um <= blend_um * (1 + 1e-4)
    assert off_um == pytest.approx(one.deviation_um, rel=0.05)
    assert one.is_squeezed or one.deviation_um == pytest.approx(blend_um, rel=1e-6)
    if (
        drawing is SHARP["p4c"] and blend_um > 1
    ):  # a blend of a corner takes metal away and leaves none
        assert (one.outline.polar(TURN).r - drawing.polar(TURN).r).max() < 1e-12


@pytest.mark.parametrize("drawing", SHARP.values(), ids=SHARP.keys())
def test_blended_outline_is_smooth(drawing: Outline) -> None:
    """Nothing jumps at the ends of the windows, up to the third derivative."""
    one = blended(drawing, 2.0)
    for joint in one.outline.joints():
        here = np.array([joint.angle_rad])
        low, high = joint.before.polar(here), joint.behind.polar(here)
        half = min(blend.half_rad for blend in one.blends)
        assert float(low.r[0]) == pytest.approx(float(high.r[0]), abs=1e-12)
        for n, name in enumerate(("d1", "d2", "d3"), start=1):
            jump = float((getattr(high, name) - getattr(low, name))[0])
            assert abs(jump) * half**n < 1e-9


@pytest.mark.parametrize("drawing", SHARP.values(), ids=SHARP.keys())
def test_derivatives_of_blends(drawing: Outline) -> None:
    """Differences of the radius give slope and bend, across the joint too."""
    for blend in blended(drawing, 2.0).blends[:2]:
        h = 1e-4 * blend.half_rad
        phi = blend.joint_rad + blend.half_rad * np.linspace(-0.99, 0.99, 41)
        low, here, high = (blend.polar(phi + k * h) for k in (-1, 0, 1))
        for name, of in (("d1", "r"), ("d2", "d1"), ("d3", "d2")):
            slope = (getattr(high, of) - getattr(low, of)) / (2 * h)
            off = np.abs(slope - getattr(here, name)).max()
            assert off < 1e-5 * np.abs(getattr(here, name)).max()


def test_closed_form_of_a_slope_jump() -> None:
    """Deviation times acceleration of a jump J of the slope is 315^2 / 2560 / 256 J^2: by hand.

    The bump is 315/256 (1 - x^2)^4, its ramp is 315/2560 at the joint.
    """
    drawing = p4c(14.0, 11.0, 1.6, 0.0)
    [joint, *_] = drawing.joints()
    one = blended(drawing, 0.5)
    assert blended(p3g(25.0, 0.8, 0.0), 2.0).blends == ()  # P3G has no joints
    product = one.deviation_um / 1000 * bend_of(one)
    assert product == pytest.approx((315**2 / 2560 / 256) * joint.slope_mm**2, rel=0.01)


NAMES = ("p3g-25", "p4c-35", "hexagon")
HEAD = '[part]\nname = "a"\nkind = "polygon"\nsource = "s"\n[polygon]\n'
TAIL = """\
[process]
spindle_rpm = 100
feed_mm = 0.2
[tool]
clearance_deg = 45
[machine.limits]
u_stroke_mm = 12
"""


def radius_of(name: str, phi: cases.Floats) -> cases.Floats:
    """Return the radius of an example's drawing by another method."""
    if name == "p3g-25":
        return cases.p3g_mm(phi, 25.0, 0.8)
    if name == "p4c-35":
        return cases.p4c_mm(phi, 35.0, 30.0, 5.0)
    return cases.rounded_mm(phi, cases.regular_corners(6, 20.0), 1.0)


def part_of(polygon: str, tail: str = TAIL) -> PolygonPart:
    """Return the part of the lines of [polygon]."""
    part = parse((HEAD + polygon + tail).encode(), "a.toml").part
    assert isinstance(part, PolygonPart)
    return part


@pytest.fixture(scope="module", params=NAMES)
def made(request: pytest.FixtureRequest) -> GeneratedPolygon:
    """Return the table of an example."""
    found: GeneratedPolygon = made_of(request.param).table
    return found


def loaded(path: Path) -> Made:
    """Return the table of a part file."""
    return make(load(path), path)


def test_firmware_plays_the_drawing(made: GeneratedPolygon, tmp_path: Path) -> None:
    """Tip = x - u of the firmware is the drawing's radius, off by the table and by the blends."""
    name = made.part.part.name
    rng = np.random.default_rng(3271)
    low, high = made.part.polygon.z_mm
    turn, z = rng.uniform(-3, 3, 400), rng.uniform(low, high, 400)
    tip = tip_mm(evaluated(tmp_path, made.table, turn, z))
    off_um = 1e3 * (tip - radius_of(name, 2 * np.pi * (turn % 1)))
    near = np.zeros(turn.size, dtype=bool)
    for blend in made.blended.blends:
        away = np.mod(2 * np.pi * turn - blend.joint_rad + np.pi, 2 * np.pi) - np.pi
        near |= np.abs(away) <= blend.half_rad
    assert np.abs(off_um[~near]).max() < 1.2e-3
    assert np.abs(off_um).max() <= made.blended.deviation_um + 1.2e-3


@pytest.mark.long
@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(
    ("name", "feed_mm"), [("p3g-25", "2"), pytest.param("p4c-35", "0.2", marks=pytest.mark.long)]
)
def test_cut_surface_is_the_drawing(name: str, feed_mm: str, tmp_path: Path) -> None:
    """The radius that the simulator cut is the drawing's, off by what the verdict says.

    The cut with the fine feed is longer than its trace.
    """
    assert run([str(PARTS / f"{name}.toml"), "--feed", feed_mm, "-o", str(tmp_path)]) == 0
    table = columns_of(tmp_path / "surface.csv")
    turn, radius, error_nm = (table[key] for key in ("turn", "radius_mm", "error_nm"))
    some = np.random.default_rng(1).choice(turn.size, 300, replace=False)
    own_um = 1e3 * (radius[some] - radius_of(name, 2 * np.pi * turn[some]))
    summary: dict[str, Any] = json.loads((tmp_path / "summary.json").read_text())
    assert np.abs(own_um - error_nm[some] / 1e3).max() < 4e-3  # turn has 7 digits
    assert np.abs(own_um).max() <= summary["form_error_um"]["max"] + 4e-3
    page = (tmp_path / "report.html").read_text()
    assert "inner circle" in page and "WITHIN TOLERANCE" in page


def test_verdict_is_against_the_drawing(tmp_path: Path) -> None:
    """A blend beyond the tolerance makes a bad part, however well the controller plays it."""
    text = (PARTS / "p4c-35.toml").read_text()
    path = tmp_path / "p.toml"
    path.write_text(text.replace("form_error_um = 15.0", "form_error_um = 5.0"))
    found = cut_made(loaded(path), tmp_path, "--feed", "2", status=1)
    assert found.form_error_um == pytest.approx(12.0, abs=0.2)
    assert not found.summary["is_good"]


def test_header_and_manual_have_the_numbers(made: GeneratedPolygon) -> None:
    """The joints' acceleration in the header; the manual's list of examples."""
    bounds = made.table.bounds
    assert bounds.u2_peak_nm_per_rad2 >= 1e6 * bend_of(made.blended) * (1 - 1e-6)
    assert bounds.u2_peak_nm_per_rad2 <= 1e6 * bend_of(made.blended) * 1.01
    assert made.accuracy_u.value_nm <= 1.0
    assert max(made.accuracy_u.first_share, made.accuracy_u.second_share) <= 1e-3
    lines = (ROOT / "tools" / "docs" / "POLYGONS.md").read_text().splitlines()
    name = made.part.part.name
    if name == "hexagon":  # the pattern repeats exactly: all blends have the first side's width
        assert len({blend.half_rad for blend in made.blended.blends}) == 1
        assert blended(made.drawing, 2.0).outline.repeat == 6
    [line] = [one for one in lines if one.startswith(f"| `{name}.toml` |")]
    off_um, rpm = line.split(" | ")[2:]
    assert float(off_um) == pytest.approx(made.deviation_um, abs=0.005)
    assert float(rpm.strip(" |")) == pytest.approx(made.highest_speed.rpm, abs=0.5)
    assert made.highest_speed.decides == "u_acceleration_mm_s2"


def test_taper_makes_all_sections_alike() -> None:
    """The outer circle grows by taper x length, the inner one in proportion."""
    lines = "sides = 5\nacross_flats_mm = 20\ncorner_radius_mm = 2\nz_mm = [0, 20]\ntaper = 0.05\n"
    made = generate_polygon(part_of('form = "regular"\n' + lines))
    phi = np.linspace(0, 6, 50)
    first, last = (
        made.geometry.radius_mm(z) - made.geometry.delta(phi, z).delta for z in (0.0, 20.0)
    )
    grown = 2 * float(made.geometry.radius_mm(20.0) - made.geometry.radius_mm(0.0))
    assert grown == pytest.approx(1.0, abs=1e-12)
    assert np.ptp(last / first) < 1e-12
    assert made.deviation_um <= 2.0 * (1 + 1e-6) < 1.05 * made.blended.deviation_um * last[0]


@pytest.mark.long
def test_too_sharp_names_the_blend_that_would_do(tmp_path: Path) -> None:
    """With the advised blend the part is accepted; with a little less it is not."""
    lines = 'form = "p4c"\nsize_mm = 35\nz_mm = [0, 20]\nblend_um = {}\n'
    tail = TAIL.replace("100\n", "200\n") + "u_acceleration_mm_s2 = 400000\nu_speed_mm_s = 800\n"
    *_, line = refused_lines(lambda: generate_polygon(part_of(lines.format(8.0), tail)))
    assert line.startswith("polygon.blend_um = 8: at this speed ")
    least = float(line.split("speed ")[1].split(" would")[0])
    generate_polygon(part_of(lines.format(least), tail))
    with pytest.raises(CamtoolsError, match="u_acceleration_mm_s2"):
        generate_polygon(part_of(lines.format(0.95 * least), tail))


def test_corner_that_no_blend_helps() -> None:
    """The arc of the corner itself needs more than there is."""
    lines = (
        'form = "regular"\nsides = 6\nacross_flats_mm = 20\ncorner_radius_mm = 0.2\nz_mm = [0, 9]\n'
    )
    with pytest.raises(CamtoolsError, match="no blend helps"):
        generate_polygon(part_of(lines, TAIL + "u_acceleration_mm_s2 = 1000\n"))


P3G_LINES = 'form = "p3g"\nz_mm = [0, 9]\n'
WRONG = [
    (
        P3G_LINES + "size_mm = 26\n",
        "polygon.size_mm = 26: no nominal size of p3g; use one of 14, 16",
    ),
    (P3G_LINES + "mean_diameter_mm = 25\n", "polygon.eccentricity_mm: is missing for form"),
    (P3G_LINES + "size_mm = 25\neccentricity_mm = 1\n", "polygon.eccentricity_mm = 1: contradicts"),
    (P3G_LINES + "size_mm = 25\nsides = 3\n", "polygon.sides = 3: sides has no meaning"),
    ('form = "hexagon"\nz_mm = [0, 9]\n', "polygon.form = 'hexagon'"),
    (P3G_LINES.replace("[0, 9]", "[9, 0]") + "size_mm = 25\n", "polygon.z_mm"),
    (P3G_LINES + "size_mm = 25\nblend_um = 0\n", "polygon.blend_um = 0: "),
    (
        'form = "corners"\nz_mm = [0, 9]\ncorners_mm = [[9, 0], [0, 9], [-9, -9]]\n'
        "corner_radius_mm = [1, 1, 1, 1]\n",
        "polygon.corner_radius_mm = [1.0, 1.0, 1.0, 1.0]: has 4 entries, corners_mm has 3",
    ),
    (P3G_LINES + "size_mm = 25\ntaper = -3\n", "polygon.taper = -3: "),
]


@pytest.mark.parametrize(("lines", "message"), WRONG, ids=[message for _, message in WRONG])
def test_wrong_part_files(lines: str, message: str) -> None:
    """One line with file, field, value and remedy."""
    line = refused(lambda: part_of(lines))
    assert line.startswith(f"a.toml: {message}") and "; " in line


@pytest.mark.long
@pytest.mark.parametrize("direction", [1, -1])
def test_both_senses_cut_the_drawing(direction: int, tmp_path: Path) -> None:
    """Four sides without symmetry, turned with M3 and with M4, are those of the drawing."""
    corners = [[9.0, -9.0], [9.0, 8.0], [-9.0, 7.0], [-7.0, -8.0]]
    lines = f'form = "corners"\nz_mm = [0, 4]\ncorner_radius_mm = 4\ncorners_mm = {corners}\n'
    tail = TAIL.replace("100\n", f"100\ndirection = {direction}\n").replace("12\n", "20\n")
    path = tmp_path / "a.toml"
    path.write_text(HEAD + lines + tail)
    turn, _, radius, *_ = plain(cut_made(loaded(path), tmp_path).surface)
    some = np.random.default_rng(1).choice(turn.size, 500, replace=False)
    drawn = cases.rounded_mm(2 * np.pi * turn[some], np.array(corners), 4.0)
    assert np.abs(radius[some] - drawn).max() < 2.5e-3


def test_area_and_inch_sizes() -> None:
    """A = pi dm^2 / 4 - 4 pi e^2; Stoffel prints 1.330 and 1.170 for 1.250 and 0.040 inches."""
    e, dm = 0.04 * 25.4, 1.25 * 25.4
    measures = measures_of(p3g(dm, e, 0.0))
    assert measures.area_mm2 == pytest.approx(np.pi * dm**2 / 4 - 4 * np.pi * e**2, rel=1e-9)
    assert measures.outer_circle_mm == pytest.approx(1.330 * 25.4, abs=1e-9)
    assert measures.inner_circle_mm == pytest.approx(1.170 * 25.4, abs=1e-9)


def test_about_the_mean_with_run_in(tmp_path: Path) -> None:
    """U needs half of the travel, the tool enters and leaves through the air, the part is good."""
    text = (PARTS / "p3g-25.toml").read_text()
    text = text.replace("u_stroke_mm = 8", "u_stroke_mm = 2").replace("[0, 30]", "[0, 4]")
    path = tmp_path / "a.toml"
    path.write_text(text)
    with pytest.raises(CamtoolsError, match=r'process\.u_zero = "mean", which needs 1\.6'):
        loaded(path)
    more = 'u_zero = "mean"\nrun_in_mm = 1.5\nrun_out_mm = 1.0\n[machine.limits]'
    path.write_text(text.replace("[machine.limits]", more))
    turn, _, radius, *_ = plain(cut_made(loaded(path), tmp_path).surface)
    some = np.random.default_rng(2).choice(turn.size, 200, replace=False)
    drawn = radius_of("p3g-25", 2 * np.pi * turn[some])
    assert np.abs(radius[some] - drawn).max() < 2e-4


STRONG = TAIL + "u_acceleration_mm_s2 = 1e8\nu_speed_mm_s = 10000\n"
NEVER = [
    pytest.param(
        'form = "p4c"\nsize_mm = 35\nz_mm = [0, 20]\n',
        r"blend_um = 2: U would need 6\d{3}\.\d+ mm/rad2, a table holds 2147\.48; allow 6\.",
        marks=pytest.mark.long,
    ),
    (
        'form = "regular"\nsides = 6\nacross_flats_mm = 20\nz_mm = [0, 20]\nblend_um = 9\n',
        r"polygon\.blend_um = 9: U would need .* allow 1\d\.\d+ um",
    ),
    (
        'form = "regular"\nsides = 14\nacross_flats_mm = 5.29\ncorner_radius_mm = 2.55\n'
        "z_mm = [0, 20]\n",
        "is allowed; give larger corner radii",
    ),
    (
        'form = "p3g"\nmean_diameter_mm = 900\neccentricity_mm = 18\nz_mm = [0, 20]\n',
        "u: its travel to one side comes to 36.0001 mm, a table holds 16.7772; give",
    ),
]


@pytest.mark.parametrize(("lines", "message"), NEVER)
def test_what_no_table_holds(lines: str, message: str, tmp_path: Path) -> None:
    """Refused with numbers and remedy, where the image would not take it or the firmware refuse.

    What the refusal of P4C 35 advises is taken, and the firmware takes the table.
    """
    with pytest.raises(CamtoolsError, match=message) as info:
        generate_polygon(part_of(lines, STRONG))
    if 'form = "p4c"' in lines:
        least = info.value.lines[0].split("allow ")[1].split(" um")[0]
        made = generate_polygon(part_of(f"{lines}blend_um = {least}\n", STRONG))
        evaluated(tmp_path, made.table, np.array([0.1]), np.array([5.0]))


def test_passes(tmp_path: Path) -> None:
    """Roughing and finishing of a hexagon in one run; the last pass is the drawing."""
    text = (PARTS / "hexagon.toml").read_text().replace("[0, 15]", "[0, 3]")
    more = (
        "[[process.pass]]\nallowance_um = 40\nfeed_mm = 0.2\n"
        "[[process.pass]]\nallowance_um = 0\n[machine.limits]"
    )
    path = tmp_path / "a.toml"
    path.write_text(text.replace("[machine.limits]", more))
    summary = cut_made(loaded(path), tmp_path).summary
    assert [one["allowance_um"] for one in summary["passes"]] == [40, 0]
    assert summary["form_error_um"]["max"] < 2.0
    weak = more.replace("= 0.2", "= 2") + "\nz_speed_mm_s = 5"
    path.write_text(text.replace("[machine.limits]", weak))
    with pytest.raises(CamtoolsError, match=r"process\.pass number 1: machine\.limits\.z_speed"):
        loaded(path)


@pytest.mark.long
def test_motion_about_the_mean_is_drawn_from_there(tmp_path: Path) -> None:
    """U of the picture is the reduction less its middle, as the trace has it."""
    text = (PARTS / "p3g-25.toml").read_text().replace("[0, 30]", "[0, 2]")
    path = tmp_path / "a.toml"
    path.write_text(text.replace("[machine.limits]", 'u_zero = "mean"\n[machine.limits]'))
    made = loaded(path).table
    assert made.middle_nm == 800_000
    [line] = draw_motion(made).axes[0].lines
    degrees, u_mm = (np.asarray(one) for one in line.get_data())
    drawn = 12.5 + 0.8 - cases.p3g_mm(np.radians(degrees), 25.0, 0.8)
    np.testing.assert_allclose(u_mm, drawn - 0.8, atol=1e-6)
