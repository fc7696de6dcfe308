"""Sections, profiles, sides and motion of skirts against the worked numbers of MATHS.md."""

import json
import re
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline, PchipInterpolator

from camtools.base.errors import CamtoolsError, GeometryError
from camtools.base.quantities import Floats
from camtools.skirt.geometry.profile import ovality_spline, profile_spline
from camtools.skirt.geometry.sections import (
    SMOOTH_DEG,
    Law,
    double_ellipse,
    ellipse,
    law_of,
    power_oval,
)
from camtools.skirt.geometry.skirt_geometry import Geometry, OvalSurface, make_geometry
from camtools.skirt.part.keys import Ovality, Profile
from camtools.skirt.part.part_file import SkirtPart
from camtools.skirt.tool.turning import turning_at
from tests.tools.cases.camsim_cases import cut, plain, refusal
from tests.tools.cases.cut_cases import (
    PARTS,
    evaluated,
    geometry_of_part,
    made_of,
    made_skirt,
    tip_mm,
    written,
    written_skirt,
)
from tests.tools.cases.part_cases import changed, parse_part, refused, sure

A_MM = 46.0
DEGREES = [0, 10, 15, 30, 45, 60, 75, 90]
TABLE_VALUES = {
    "exact": "0.000000000 0.003024932 0.006719165 0.025061263 0.050081610 0.075061152 "
    "0.093321641 0.100000000",
    "cosine": "0.000000000 0.003015369 0.006698730 0.025000000 0.050000000 0.075000000 "
    "0.093301270 0.100000000",
    "plus": "0.000000000 0.003483280 0.007698730 0.028000000 0.054000000 0.078000000 "
    "0.094301270 0.100000000",
    "minus": "0.000000000 0.002547458 0.005698730 0.022000000 0.046000000 0.072000000 "
    "0.092301270 0.100000000",
}
SHAPES = {
    "exact": ellipse,
    "cosine": law_of("cosine", 0.0),
    "plus": law_of("double-ellipse", 1.0),
    "minus": law_of("double-ellipse", -1.0),
}
PAIR = ("exact", "cosine")
radii = st.floats(10, 200)
ovalities = st.floats(0.001, 2)
betas = st.floats(-6.25, 6.25)
angles = st.floats(-10, 10)


@pytest.mark.parametrize("name", list(TABLE_VALUES))
def test_delta_has_the_printed_values(name: str) -> None:
    """Radius reductions at a = 46, G = 0.2 are those of the table of values."""
    delta = SHAPES[name](np.radians(DEGREES), A_MM, 0.2).delta
    assert [f"{mm:.9f}" for mm in delta] == TABLE_VALUES[name].split()


def test_exact_lies_inside_cosine() -> None:
    """MATHS.md (5): the ellipse is at most 81.610 nm inside the cosine form, at 44.974 degrees."""
    degrees = np.linspace(44.9, 45.0, 100_001)
    exact, cosine = (SHAPES[name](np.radians(degrees), A_MM, 0.2).delta for name in PAIR)
    gap_nm = 1e6 * (exact - cosine)
    assert f"{gap_nm.max():.3f}" == "81.610"
    assert degrees[np.argmax(gap_nm)] == pytest.approx(44.974, abs=1.1e-4)


@given(radii, ovalities, betas)
def test_sections_rise_from_long_to_short_axis(a: float, g: float, beta: float) -> None:
    """Between the axes the reduction never falls, and it is 0 and G/2 at the axes."""
    phi = np.linspace(0, np.pi / 2, 201)
    for law in (ellipse, law_of("double-ellipse", beta)):
        delta = law(phi, a, g).delta
        assert np.diff(delta).min() >= -1e-15
        assert delta[0] == 0
        assert delta[-1] == pytest.approx(g / 2, rel=1e-12)


@given(st.floats(0, 3.2), radii, ovalities, betas)
def test_derivatives_are_those_of_the_value(phi: float, a: float, g: float, beta: float) -> None:
    """Each derivative is the five-point difference of the one before."""
    step = 1e-3
    places = phi + step * np.array([-2.0, -1.0, 1.0, 2.0])
    weights = np.array([1.0, -8.0, 8.0, -1.0]) / (12 * step)
    for law in (ellipse, law_of("double-ellipse", beta)):
        around = law(places, a, g)
        here = law(np.array([phi]), a, g)
        for order in range(3):
            slope = float(weights @ around[order])
            assert slope == pytest.approx(float(here[order + 1][0]), abs=1e-7 * g * (1 + abs(beta)))


GIVEN_MM = [5.0, 15.0, 25.0, 35.0, 45.0, 56.0]
SPLINE = [  # derivative, heights, a(z) or its derivative there
    (0, GIVEN_MM, "45.983096898 45.998129455 45.998135281 45.983079419 45.953359542 45.903454932"),
    (1, GIVEN_MM, "0.002253450 0.000748721 -0.000748332 -0.002255392 -0.003692600 -0.005382370"),
    (
        2,
        [0.0, 10, 20, 30, 40, 50, 62],
        "-1.436120e-04 -1.518917e-04 -1.488211e-04 -1.528239e-04 -1.398831e-04 -1.576435e-04 "
        "-1.429044e-04",
    ),
]
# n, G, f Hz, v, acc, jerk of the cosine form; v, acc at 0, acc at 90 of the ellipse (a = 46)
PEAKS = """
650 0.2 21.6667 6.80678 926.646 126150 6.80680 929.677 -923.627
800 0.3 26.6667 12.56637 2105.516 352783 12.56644 2115.859 -2095.228
1500 0.38 50.0000 29.84513 9376.124 2.9456e+06 29.84539 9434.537 -9318.113
2500 0.38 83.3333 49.74188 26044.789 1.3637e+07 49.74231 26207.047 -25883.647
""".strip().splitlines()


@pytest.mark.parametrize(("nu", "z_mm", "printed"), SPLINE)
def test_spline_is_golden(nu: int, z_mm: list[float], printed: str, perkins: SkirtPart) -> None:
    """a(z), a'(z) between the nodes and a''(z) at them have the printed values.

    The printed moments are those of end slopes that are not rounded.
    """
    curve = (91.737 - 92.0) / 2 / (62 - 20) ** 2  # of the parabola about height 20
    slopes = {"end_slopes": [-40 * curve, 84 * curve]} if nu == 2 else {}
    profile = Profile.model_validate(perkins.piston.profile.model_dump() | slopes)
    form = ".6e" if nu == 2 else ".9f"
    assert [f"{value:{form}}" for value in profile_spline(profile)(z_mm, nu=nu)] == printed.split()


def test_ends_ovality_and_axes_are_golden(geometry: Geometry) -> None:
    """End slopes, G(5) and G(41) of the part; X and U at the height of each turn."""
    ends = geometry.radius_mm([0.0, 62.0], 1)
    np.testing.assert_allclose(ends, [0.0029818594, -0.0062619048], atol=1e-15)
    np.testing.assert_allclose(geometry.ovality_mm([5.0, 41.0]), [0.1625, 0.25], atol=1e-15)
    turns = np.array([0.0, 0.25, 200.0, 620.0])
    motion = turning_at(geometry, 2500.0, 0.1 * turns, turns)
    np.testing.assert_allclose(motion.x_mm[[0, 2, 3]], [45.97, 46.0, 45.8685])
    np.testing.assert_allclose(motion.u_mm[[0, 1]], [0, 0.15 / 2 + 0.025 * 0.0025 / 2], atol=1e-12)


@pytest.mark.parametrize("row", PEAKS)
def test_motion_peaks_are_golden(row: str) -> None:
    """Frequency, velocity, acceleration and jerk of U have the printed peaks."""
    n, g, f, v, acc, jerk, exact_v, acc_0, acc_90 = row.split()
    turns = np.linspace(0, 1, 36_001)
    flat = make_flat(float(g))
    cosine = turning_at(flat["cosine"], float(n), 0.0, turns)
    exact = turning_at(flat["ellipse"], float(n), 0.0, turns)
    assert f"{2 * float(n) / 60:.4f}" == f
    assert f"{cosine.velocity_mm_s.max():.5f}" == v
    assert f"{cosine.acceleration_mm_s2.max():.3f}" == acc
    assert f"{cosine.jerk_mm_s3.max():.6g}" == jerk
    assert f"{exact.velocity_mm_s.max():.5f}" == exact_v
    assert f"{exact.acceleration_mm_s2[0]:.3f}" == acc_0
    assert f"{exact.acceleration_mm_s2[9000]:.3f}" == acc_90


def make_flat(g_mm: float) -> dict[str, Geometry]:
    """Return cylinders of a = 46 mm with constant ovality, ellipse and cosine form."""
    radius = profile_spline(Profile(height_mm=[0, 10], diameter_mm=[92, 92]))
    ovality = ovality_spline(Ovality(height_mm=[0, 10], ovality_mm=[g_mm, g_mm]))
    laws: dict[str, Law] = {"ellipse": ellipse, "cosine": double_ellipse}
    return {
        name: Geometry(radius, ovality, OvalSurface(law, radius, ovality), 0.0, 10.0)
        for name, law in laws.items()
    }


def test_magnified_parts(perkins: SkirtPart) -> None:
    """30 times all, or the ovality alone, as in the papers; inside out is refused."""
    geometry = geometry_of_part("perkins240_x30")
    assert 2 * float(geometry.radius_mm(62.0)) == pytest.approx(84.11, abs=1e-12)
    assert float(geometry.ovality_mm(62.0)) == pytest.approx(9.0, abs=1e-12)
    assert 2 * float(geometry.radius_mm(20.0)) == pytest.approx(92.0, abs=1e-12)
    part = changed(perkins, {"magnify": {"factor": 30.0, "of": "ovality"}})
    geometry = make_geometry(part)
    assert 2 * float(geometry.radius_mm(62.0)) == pytest.approx(91.737, abs=1e-12)
    assert float(geometry.ovality_mm(62.0)) == pytest.approx(9.0, abs=1e-12)
    short_mm = float(geometry.radius_mm(62.0) - geometry.delta(np.pi / 2, 62.0).delta)
    assert short_mm == pytest.approx(91.737 / 2 - 4.5, abs=1e-12)
    assert sure(part.magnify).words == "ovality enlarged 30 times"
    part = changed(perkins, {"magnify": {"factor": 1000.0}})
    with pytest.raises(GeometryError, match=r"magnify\.factor.*half axis"):
        make_geometry(part)


def test_overshooting_ovality_spline_is_refused(perkins: SkirtPart) -> None:
    """A spline that would fall below zero between its points is refused, naming the field."""
    steep = {"height_mm": [0, 20, 30, 62], "ovality_mm": [0.3, 0.0, 0.0, 0.3]}
    part = changed(perkins, {"piston.ovality": steep | {"interpolation": "spline"}})
    with pytest.raises(GeometryError, match=r"piston\.ovality\.interpolation.*falls to -") as info:
        make_geometry(part)
    assert info.value.field == "piston.ovality.interpolation"


Formula = Callable[[Floats, Floats, Floats], Floats]
THRUST = PARTS / "thrust90.toml"


def smooth_step(s: Floats) -> Floats:
    """Return the smooth smooth_step of degree seven."""
    s = np.clip(s, 0, 1)
    return np.asarray(35 * s**4 - 84 * s**5 + 70 * s**6 - 20 * s**7)


def of_maths_4(deg: Floats, g_mm: Floats, beta: Floats) -> Floats:
    """Return MATHS.md (4), as printed there."""
    phi = np.radians(deg)
    found = g_mm / 4 * ((1 - np.cos(2 * phi)) + beta / 25 * (1 - np.cos(4 * phi)))
    return np.asarray(found)


def thrust_mm(deg: Floats, z_mm: Floats) -> Floats:
    """Return the radius of thrust90.toml."""
    heights, ends = [0, 10, 22, 34, 46, 56], [0, 28, 56]
    radius = CubicSpline(heights, np.array([89.932, 89.966, 89.98, 89.968, 89.928, 89.872]) / 2)
    g_mm, drop_mm = np.interp(z_mm, ends, [0.24, 0.30, 0.40]), np.interp(z_mm, ends, [20, 12, 30])
    thrust = of_maths_4(deg, g_mm, np.interp(z_mm, ends, [0.6, 1.0, 1.4]))
    drop_mm = drop_mm / 1000
    other = drop_mm + of_maths_4(deg, g_mm - 2 * drop_mm, np.full_like(g_mm, 0.4))
    off_pin_deg = 90 - np.abs(np.mod(deg, 360) - 180)  # above 0: anti-thrust
    share = smooth_step(off_pin_deg / 30 + 0.5)
    return np.asarray(radius(z_mm) - (1 - share) * thrust - share * other)


def power(deg: Floats, g_mm: Floats, exponent: Floats) -> Floats:
    """Return G/2 |sin|^p, below 15 degrees by the cubic through x, x^2, x^3, x^4 at p/2."""
    t, m = np.sin(np.radians(deg)) ** 2, exponent / 2
    x = t / np.sin(np.radians(15)) ** 2
    p = [x, x**2, x**3, x**4]  # Newton's form over m = 1, 2, 3, 4
    d1 = [p[1] - p[0], p[2] - p[1], p[3] - p[2]]
    d2 = [d1[1] - d1[0], d1[2] - d1[1]]
    near = p[0] + (m - 1) * (d1[0] + (m - 2) / 2 * (d2[0] + (m - 3) / 3 * (d2[1] - d2[0])))
    near = near * np.sin(np.radians(15)) ** (2 * m)
    return np.asarray(g_mm / 2 * np.where(x < 1, near, np.abs(t) ** m))


def power_of_sine(deg: Floats, g_mm: Floats, exponent: Floats) -> Floats:
    """Return G/2 |sin|^p, the drawing."""
    return np.asarray(g_mm / 2 * np.abs(np.sin(np.radians(deg))) ** exponent)


def twist_mm(deg: Floats, z_mm: Floats, law: Formula = power) -> Floats:
    """Return the radius of twist80.toml, as its table plays it or by the law of its drawing."""
    heights, ends = [0, 12, 25, 38, 50], [0, 25, 50]
    radius = CubicSpline(heights, np.array([79.94, 79.972, 79.98, 79.968, 79.93]) / 2)
    over = {
        "g": PchipInterpolator(ends, [0.16, 0.20, 0.28])(z_mm),
        "p": PchipInterpolator(ends, [2.4, 3.2, 4.0])(z_mm),
        "phase": PchipInterpolator(ends, [-4, 0, 4])(z_mm),
        "other": np.interp(z_mm, [0, 50], [0.20, 0.36]),
    }
    deg = deg - over["phase"]
    here, other = law(deg, over["g"], over["p"]), law(deg, over["other"], over["p"])
    share = smooth_step((90 - np.abs(np.mod(deg - 90, 360) - 180)) / 30 + 0.5)
    return np.asarray(radius(z_mm) - (1 - share) * here - share * other)


Radius = Callable[[Floats, Floats], Floats]
FORMULAS: dict[
    str, tuple[Radius, Radius, float]
] = {  # what the table plays, the drawing, the upper end
    "thrust90": (thrust_mm, thrust_mm, 56.0),
    "twist80": (twist_mm, partial(twist_mm, law=power_of_sine), 50.0),
}


@pytest.mark.parametrize("name", list(FORMULAS))
def test_geometry_is_the_formula(name: str) -> None:
    """Radius everywhere within rounding; three derivatives are those of finite differences."""
    formula, _, last_mm = FORMULAS[name]
    geometry = geometry_of_part(name)
    rng = np.random.default_rng(90)
    deg, z_mm = rng.uniform(-400, 400, 20_000), rng.uniform(0, last_mm, 20_000)
    u = geometry.delta(np.radians(deg), z_mm)
    np.testing.assert_allclose(geometry.radius_mm(z_mm) - u.delta, formula(deg, z_mm), atol=1e-12)
    h = np.degrees(1e-5)
    low, high = (geometry.delta(np.radians(deg + k * h), z_mm) for k in (-1, 1))
    for n, most in enumerate((1e-8, 1e-7, 1e-2)):  # the third derivative has corners
        slope = (high[n] - low[n]) / 2e-5
        assert np.abs(slope - u[n + 1]).max() < most


@pytest.mark.parametrize(("name", "direction"), [("thrust90", 1), ("twist80", -1)])
def test_cut_part_is_the_formula(tmp_path: Path, name: str, direction: int) -> None:
    """Table and cut agree with the formula, the gauge with the drawing, with M3 and with M4."""
    formula, drawn, last_mm = FORMULAS[name]
    text = re.sub(r"(?m)^direction = .*\n", "", (PARTS / f"{name}.toml").read_text())
    text = text.replace("feed_mm = 0.1", f"feed_mm = 1\ndirection = {direction}")
    made = made_skirt(parse_part(text))
    found = cut(written(made, tmp_path), "--tolerance-um", "0.5")
    turn, z_mm, radius_mm, error_nm = plain(found.surface)
    exact_mm = drawn(360 * turn, z_mm)
    assert turn.size > 20_000
    assert np.abs(radius_mm - exact_mm).max() < 0.5e-3
    # heights of the file are rounded to 1 nm, angles to 6e-8 turn
    assert np.abs(radius_mm - error_nm * 1e-6 - exact_mm).max() < 6e-8
    rng = np.random.default_rng(80)
    turn, z_mm = rng.uniform(-3, 3, 2000), np.round(rng.uniform(0, last_mm, 2000), 6)
    values = evaluated(tmp_path, made.table.table, turn, z_mm)
    assert np.abs(tip_mm(values) - formula(360 * turn, z_mm)).max() < 2e-6


@given(st.floats(2, 8))
def test_power_is_smooth_and_near_the_power_of_the_sine(exponent: float) -> None:
    """Exact from 15 degrees on; below within 1.8e-4 of the ovality; even powers exactly."""
    deg = np.linspace(-90, 90, 3601)
    exact = 0.5 * np.abs(np.sin(np.radians(deg))) ** exponent
    got = power_oval(np.radians(deg), 46.0, 1.0, exponent)
    off = np.abs(got.delta - exact)
    assert off[np.abs(deg) >= SMOOTH_DEG].max() < 1e-15
    assert off.max() < 1.8e-4
    edge = np.radians(SMOOTH_DEG + np.array([-1e-7, 1e-7]))
    around = power_oval(edge, 46.0, 1.0, exponent)
    for n in range(4):
        assert abs(np.diff(around[n])[0]) < 1e-5 * max(1.0, float(np.abs(got[n]).max()))
    assert (np.diff(got.delta[deg >= 0]) >= -1e-7).all()  # of an oval of 1 mm


@pytest.mark.parametrize("exponent", [2.0, 4.0, 6.0, 8.0])
def test_even_powers_need_no_smoothing(exponent: float) -> None:
    """A power of the square is a polynomial already."""
    phi = np.linspace(-1, 1, 999)
    got = power_oval(phi, 46.0, 0.3, exponent).delta
    np.testing.assert_allclose(got, 0.15 * np.sin(phi) ** exponent, atol=1e-16)


def geometry_of_text(text: str) -> Geometry:
    """Return the geometry of a part file's text."""
    return make_geometry(parse_part(text))


def test_sides_hold_exactly_outside_the_zones() -> None:
    """At 0 .. 75 degrees only the thrust side counts, at 105 .. 255 only the other."""
    text = THRUST.read_text()
    both = geometry_of_text(text)
    one = geometry_of_text(re.sub(r"(?s)\[piston.antithrust\].*?\n\n", "", text))
    phi = np.radians(np.linspace(-75, 75, 301))
    np.testing.assert_array_equal(both.delta(phi, 28.0).delta, one.delta(phi, 28.0).delta)
    far = np.radians(np.linspace(105, 255, 301))
    other = 0.012 + of_maths_4(np.degrees(far), np.array(0.276), np.array(0.4))
    np.testing.assert_allclose(both.delta(far, 28.0).delta, other, atol=1e-15)
    pin = both.delta(np.radians([90.0, 270.0]), 28.0)
    np.testing.assert_allclose(pin.delta, 0.15, atol=1e-15)  # the short axis is common
    np.testing.assert_allclose(pin.d1, 0, atol=1e-14)


def test_sides_with_a_step_are_bridged(tmp_path: Path) -> None:
    """An ovality and an angle of its own: the middle of a zone has the mean of both laws."""
    text = THRUST.read_text().replace("beta = 0.4", "beta = 0.4\nphase_deg = 6")
    text = text.replace("drop_mm = ", "ovality_mm = [0.2, 0.2, 0.2]\ndrop_mm = ")
    geometry = geometry_of_text(text)
    deg = np.array([90.0, 270.0])
    thrust = of_maths_4(deg, np.array(0.30), np.array(1.0))
    other = 0.012 + of_maths_4(deg - 6, np.array(0.2), np.array(0.4))
    got = geometry.delta(np.radians(deg), 28.0).delta
    np.testing.assert_allclose(got, (thrust + other) / 2, atol=1e-15)
    dense = np.radians(np.linspace(60, 120, 60_001))
    u = geometry.delta(dense, 28.0)
    slope = np.gradient(u.d1, dense[1] - dense[0])
    assert np.abs(slope - u.d2)[1:-1].max() < 1e-4  # no jump of the slope anywhere in the zone
    table = written_skirt(text, tmp_path)
    told = json.loads(table.with_suffix(".json").read_text())["sides"]
    heights = np.linspace(0, 56, 100)
    g_mm, drop_mm = np.interp(heights, [0, 28, 56], [0.24, 0.3, 0.4]), [20, 12, 30]
    sides = np.interp(heights, [0, 28, 56], drop_mm) / 1000 + of_maths_4(
        np.array(84.0), np.array(0.2), np.array(0.4)
    )
    assert told["meet"] == "short-axis"
    assert told["step_um"] == pytest.approx(1e3 * np.abs(g_mm / 2 - sides).max(), rel=1e-3)
    cut(table, "--feed", "2")


def test_a_scan_is_turned_by_its_phase(tmp_path: Path) -> None:
    """phase_deg moves every point of a measured section, whatever its shape."""
    source = PARTS / "scan90.toml"
    csv = f'csv = "{source.with_name("scan90.csv")}"'
    text = source.read_text().replace('csv = "scan90.csv"', csv)
    part = parse_part(text.replace("harmonics = 15", "phase_deg = 25\nharmonics = 15"))
    phi, z_mm = np.linspace(0, 7, 500), np.array([[3.0], [40.0]])
    got = make_geometry(part).delta(phi + np.radians(25), z_mm)
    want = geometry_of_part("scan90").delta(phi, z_mm)
    np.testing.assert_allclose(got.delta, want.delta, atol=1e-15)
    cut(written(made_skirt(part), tmp_path), "--feed", "1", "--tolerance-um", "0.5")


BROKEN = {
    "law": ('"law": "double-ellipse"', '"law": "oval"', 'design.sides.0.law = "oval": must be ell'),
    "sides": ('"sides": [', '"sides": 1, "others": [', "design.sides: must be a list of one"),
    "blend": ('"blend_rad": 0.5', '"blend_rad": -0.5', "design.middle_rad, blend_rad: must be num"),
    "drop": ('"drop_mm"', '"fall_mm"', "design.sides.0.drop_mm"),
}


@pytest.mark.parametrize("name", list(BROKEN))
def test_broken_design_is_refused_by_the_gauge(name: str, tmp_path: Path) -> None:
    """One line that names file and field, and nothing is cut."""
    old, new, problem = BROKEN[name]
    table = written(made_of("thrust90"), tmp_path)
    report = table.with_suffix(".json")
    text = json.dumps(json.loads(report.read_text()))
    assert old in text
    report.write_text(text.replace(old, new))
    line = refusal(table)
    assert f"{report}: {problem}" in line
    assert line.endswith("make the table again with tools/mktables, or give --design")


DROP = "drop_mm = [0.020, 0.012, 0.030]"


def test_a_list_of_a_side_that_overshoots_may_be_allowed() -> None:
    """What the refusal of a spline names as a remedy is a key that helps; too much is refused."""
    with pytest.raises(CamtoolsError, match=r"an ovality of -0\.16 mm at height 0 mm; drop less"):
        geometry_of_text(THRUST.read_text().replace("[0.020,", "[0.200,"))
    text = THRUST.read_text().replace(DROP, 'drop_mm = [0, 0.05, 0]\ninterpolation = "spline"')
    text = text.replace("height_mm = [0, 28, 56]\ndrop_mm", "height_mm = [0, 10, 56]\ndrop_mm")
    line = refused(lambda: geometry_of_text(text))
    remedy = re.search(r"overshoot_um = \d+", line)
    assert remedy, line
    geometry_of_text(text.replace("blend_deg", f"{remedy[0]}\nblend_deg"))
