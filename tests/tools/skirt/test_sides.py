# SPDX-License-Identifier: Apache-2.0
"""Ovals that differ from side to side, over height, and that are turned, against formulas.

The formulas stand here, with the numbers of the part files typed in again; no code of the
generator or of the simulator's design takes part in them.
"""

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

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats
from camtools.cli.mktables import main as mktables
from camtools.skirt.geometry.sections import SMOOTH_DEG, PowerOval
from camtools.skirt.geometry.skirt_geometry import Geometry, make_geometry
from tests.tools.cases.camsim_cases import ROOT, camsim, columns_of, only_error
from tests.tools.cases.part_cases import load_part, parse_part

Law = Callable[[Floats, Floats, Floats], Floats]
THRUST = ROOT / "tools" / "parts" / "thrust90.toml"
TWIST = ROOT / "tools" / "parts" / "twist80.toml"


def step(s: Floats) -> Floats:
    """Return the smooth step of degree seven."""
    s = np.clip(s, 0, 1)
    return np.asarray(35 * s**4 - 84 * s**5 + 70 * s**6 - 20 * s**7)


def double_ellipse(deg: Floats, g_mm: Floats, beta: Floats) -> Floats:
    """Return MATHS.md (4), as printed there."""
    phi = np.radians(deg)
    found = g_mm / 4 * ((1 - np.cos(2 * phi)) + beta / 25 * (1 - np.cos(4 * phi)))
    return np.asarray(found)


def thrust_mm(deg: Floats, z_mm: Floats) -> Floats:
    """Return the radius of thrust90.toml."""
    heights, ends = [0, 10, 22, 34, 46, 56], [0, 28, 56]
    radius = CubicSpline(heights, np.array([89.932, 89.966, 89.98, 89.968, 89.928, 89.872]) / 2)
    g_mm, drop_mm = np.interp(z_mm, ends, [0.24, 0.30, 0.40]), np.interp(z_mm, ends, [20, 12, 30])
    thrust = double_ellipse(deg, g_mm, np.interp(z_mm, ends, [0.6, 1.0, 1.4]))
    drop_mm = drop_mm / 1000
    other = drop_mm + double_ellipse(deg, g_mm - 2 * drop_mm, np.full_like(g_mm, 0.4))
    off_pin_deg = 90 - np.abs(np.mod(deg, 360) - 180)  # above 0: anti-thrust
    share = step(off_pin_deg / 30 + 0.5)
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


def twist_mm(deg: Floats, z_mm: Floats, law: Law = power) -> Floats:
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
    share = step((90 - np.abs(np.mod(deg - 90, 360) - 180)) / 30 + 0.5)
    return np.asarray(radius(z_mm) - (1 - share) * here - share * other)


FORMULAS = {"thrust90": (THRUST, thrust_mm, 56.0), "twist80": (TWIST, twist_mm, 50.0)}
DRAWN: dict[str, Callable[[Floats, Floats], Floats]] = {
    "thrust90": thrust_mm,
    "twist80": partial(twist_mm, law=power_of_sine),
}


@pytest.mark.parametrize("name", list(FORMULAS))
def test_geometry_is_the_formula(name: str) -> None:
    """Radius everywhere within rounding; three derivatives are those of finite differences."""
    path, formula, last_mm = FORMULAS[name]
    geometry = make_geometry(load_part(path))
    rng = np.random.default_rng(90)
    deg, z_mm = rng.uniform(-400, 400, 20_000), rng.uniform(0, last_mm, 20_000)
    u = geometry.delta(np.radians(deg), z_mm)
    np.testing.assert_allclose(geometry.radius_mm(z_mm) - u.delta, formula(deg, z_mm), atol=1e-12)
    h = np.degrees(1e-5)
    low, high = (geometry.delta(np.radians(deg + k * h), z_mm) for k in (-1, 1))
    for n, most in enumerate((1e-8, 1e-7, 1e-2)):  # the third derivative has corners
        slope = (high[n] - low[n]) / 2e-5
        assert np.abs(slope - u[n + 1]).max() < most


@pytest.mark.parametrize("direction", ["1", "-1"])
@pytest.mark.parametrize("name", ["thrust90", "twist80"])
def test_cut_part_is_the_formula(tmp_path: Path, name: str, direction: str) -> None:
    """Table and cut agree with the formula, the gauge with the drawing, with M3 and with M4."""
    path, formula, last_mm = FORMULAS[name]
    text = re.sub(r"(?m)^direction = .*\n", "", path.read_text())
    text = text.replace("feed_mm = 0.1", f"feed_mm = 0.5\ndirection = {direction}")
    (tmp_path / "part.toml").write_text(text)
    assert mktables([str(tmp_path / "part.toml"), "-o", str(tmp_path)]) == 0
    table, surface = tmp_path / f"{name}.camtab", tmp_path / "s.csv"
    done = camsim("run", table, "--tolerance-um", "0.5", "--surface", surface)
    assert done.returncode == 0, done.stderr
    turn, z_mm, radius_mm, error_nm = columns_of(surface).values()
    exact_mm = DRAWN[name](360 * turn, z_mm)
    assert turn.size > 20_000
    assert np.abs(radius_mm - exact_mm).max() < 0.5e-3
    # heights of the file are rounded to 1 nm, angles to 6e-8 turn
    assert np.abs(radius_mm - error_nm * 1e-6 - exact_mm).max() < 6e-8
    rng = np.random.default_rng(80)
    turn, z_mm = rng.uniform(-3, 3, 2000), np.round(rng.uniform(0, last_mm, 2000), 6)
    points = "".join(f"{a!r},{b!r}\n" for a, b in zip(turn.tolist(), z_mm.tolist(), strict=True))
    got = camsim("eval", table, stdin="turn,z_mm\n" + points).stdout.splitlines()
    values = np.loadtxt(got, delimiter=",", skiprows=1).T
    assert np.abs(values[5] - values[2] - 1e6 * formula(360 * turn, z_mm)).max() < 2.0


@given(st.floats(2, 8))
def test_power_is_smooth_and_near_the_power_of_the_sine(exponent: float) -> None:
    """Exact from 15 degrees on; below within 1.8e-4 of the ovality; even powers exactly."""
    deg = np.linspace(-90, 90, 3601)
    exact = 0.5 * np.abs(np.sin(np.radians(deg))) ** exponent
    got = PowerOval(exponent).evaluate(np.radians(deg), 46.0, 1.0)
    off = np.abs(got.delta - exact)
    assert off[np.abs(deg) >= SMOOTH_DEG].max() < 1e-15
    assert off.max() < 1.8e-4
    edge = np.radians(SMOOTH_DEG + np.array([-1e-7, 1e-7]))
    around = PowerOval(exponent).evaluate(edge, 46.0, 1.0)
    for n in range(4):
        assert abs(np.diff(around[n])[0]) < 1e-5 * max(1.0, float(np.abs(got[n]).max()))
    assert (np.diff(got.delta[deg >= 0]) >= -1e-7).all()  # of an oval of 1 mm


@pytest.mark.parametrize("exponent", [2.0, 4.0, 6.0, 8.0])
def test_even_powers_need_no_smoothing(exponent: float) -> None:
    """A power of the square is a polynomial already."""
    phi = np.linspace(-1, 1, 999)
    got = PowerOval(exponent).evaluate(phi, 46.0, 0.3).delta
    np.testing.assert_allclose(got, 0.15 * np.sin(phi) ** exponent, atol=1e-16)


def geometry_of(text: str) -> Geometry:
    """Return the geometry of a part file's text."""
    return make_geometry(parse_part(text.encode(), "p.toml"))


def test_sides_hold_exactly_outside_the_zones() -> None:
    """At 0 .. 75 degrees only the thrust side counts, at 105 .. 255 only the other."""
    text = THRUST.read_text()
    both = geometry_of(text)
    one = geometry_of(re.sub(r"(?s)\[piston.antithrust\].*?\n\n", "", text))
    phi = np.radians(np.linspace(-75, 75, 301))
    np.testing.assert_array_equal(both.delta(phi, 28.0).delta, one.delta(phi, 28.0).delta)
    far = np.radians(np.linspace(105, 255, 301))
    other = 0.012 + double_ellipse(np.degrees(far), np.array(0.276), np.array(0.4))
    np.testing.assert_allclose(both.delta(far, 28.0).delta, other, atol=1e-15)
    pin = both.delta(np.radians([90.0, 270.0]), 28.0)
    np.testing.assert_allclose(pin.delta, 0.15, atol=1e-15)  # the short axis is common
    np.testing.assert_allclose(pin.d1, 0, atol=1e-14)


def test_sides_with_a_step_are_bridged(tmp_path: Path) -> None:
    """An ovality and an angle of its own: the middle of a zone has the mean of both laws."""
    text = THRUST.read_text().replace("beta = 0.4", "beta = 0.4\nphase_deg = 6")
    text = text.replace("drop_mm = ", "ovality_mm = [0.2, 0.2, 0.2]\ndrop_mm = ")
    geometry = geometry_of(text)
    deg = np.array([90.0, 270.0])
    thrust = double_ellipse(deg, np.array(0.30), np.array(1.0))
    other = 0.012 + double_ellipse(deg - 6, np.array(0.2), np.array(0.4))
    got = geometry.delta(np.radians(deg), 28.0).delta
    np.testing.assert_allclose(got, (thrust + other) / 2, atol=1e-15)
    dense = np.radians(np.linspace(60, 120, 60_001))
    u = geometry.delta(dense, 28.0)
    slope = np.gradient(u.d1, dense[1] - dense[0])
    assert np.abs(slope - u.d2)[1:-1].max() < 1e-4  # no jump of the slope anywhere in the zone
    (tmp_path / "part.toml").write_text(text)
    assert mktables([str(tmp_path / "part.toml"), "-o", str(tmp_path)]) == 0
    told = json.loads((tmp_path / "thrust90.json").read_text())["sides"]
    heights = np.linspace(0, 56, 100)
    g_mm, drop_mm = np.interp(heights, [0, 28, 56], [0.24, 0.3, 0.4]), [20, 12, 30]
    sides = np.interp(heights, [0, 28, 56], drop_mm) / 1000 + double_ellipse(
        np.array(84.0), np.array(0.2), np.array(0.4)
    )
    assert told["meet"] == "short-axis"
    assert told["step_um"] == pytest.approx(1e3 * np.abs(g_mm / 2 - sides).max(), rel=1e-3)
    assert camsim("run", tmp_path / "thrust90.camtab", "--feed", "1").returncode == 0


def test_a_scan_is_turned_by_its_phase(tmp_path: Path) -> None:
    """phase_deg moves every point of a measured section, whatever its shape."""
    source = ROOT / "tools" / "parts" / "scan90.toml"
    (tmp_path / "scan90.csv").write_bytes(source.with_name("scan90.csv").read_bytes())
    text = source.read_text().replace("harmonics = 15", "phase_deg = 25\nharmonics = 15")
    (tmp_path / "scan90.toml").write_text(text)
    turned = make_geometry(load_part(tmp_path / "scan90.toml"))
    plain = make_geometry(load_part(source))
    phi = np.linspace(0, 7, 500)
    z_mm = np.array([[3.0], [40.0]])
    got, want = turned.delta(phi + np.radians(25), z_mm), plain.delta(phi, z_mm)
    np.testing.assert_allclose(got.delta, want.delta, atol=1e-15)
    assert mktables([str(tmp_path / "scan90.toml"), "-o", str(tmp_path)]) == 0
    done = camsim("run", tmp_path / "scan90.camtab", "--feed", "1", "--tolerance-um", "0.5")
    assert done.returncode == 0, done.stderr


BROKEN = {
    "law": (
        '"law": "double-ellipse"',
        '"law": "oval"',
        'design.sides.0.law = "oval": must be ellipse',
    ),
    "sides": (
        '"sides": [',
        '"sides": 1, "others": [',
        "design.sides: must be a list of one or two sides",
    ),
    "blend": (
        '"blend_rad": 0.5',
        '"blend_rad": -0.5',
        "design.middle_rad, blend_rad: must be numbers",
    ),
    "drop": ('"drop_mm"', '"fall_mm"', "design.sides.0.drop_mm"),
}


@pytest.mark.parametrize("name", list(BROKEN))
def test_broken_design_is_refused_by_the_gauge(tmp_path: Path, name: str) -> None:
    """One line that names file and field, and nothing is cut."""
    old, new, problem = BROKEN[name]
    assert mktables([str(THRUST), "-o", str(tmp_path)]) == 0
    report = tmp_path / "thrust90.json"
    text = json.dumps(json.loads(report.read_text()))
    assert old in text
    report.write_text(text.replace(old, new))
    line = only_error(camsim("run", tmp_path / "thrust90.camtab"))
    assert f"{report}: {problem}" in line
    assert line.endswith("make the table again with tools/mktables, or give --design")


LAW = 'shape = "double-ellipse"\nbeta = [0.6, 1.0, 1.4]'
ARC = 'shape = "ellipse-arc"\ntrim_mm = 0.1\njoint_deg = 50'
DROP = "drop_mm = [0.020, 0.012, 0.030]"
OTHER = "piston.antithrust"
BAD = {
    "shape": (LAW, ARC, "has no sides: the table [piston.antithrust] is for ovals"),
    "cover": ("56]\ndrop_mm", "50]\ndrop_mm", f"{OTHER}.height_mm = "),
    "length": (DROP, "drop_mm = [0.02, 0.01]", "has 2 entries, height_mm has 3"),
    "lists": ("beta = [0.6, 1.0, 1.4]", "beta = [0.6, 1.0]", "piston.section.beta = "),
    "least": ("[0.020,", "[0.200,", "leaves an ovality of -0.16 mm at height 0 mm; drop less"),
    "needed": ("blend_deg = 30", 'meet = "long-axis"', f"{OTHER}.ovality_mm"),
    "foreign": ("beta = 0.4", "exponent = 3", f"{OTHER}.exponent = 3.0: has no meaning"),
    "blend": ("blend_deg = 30", "blend_deg = 1", f"{OTHER}.blend_deg = 1"),
    "power": (LAW, 'shape = "power"', "piston.section.exponent"),
    "exponent": (LAW, 'shape = "power"\nexponent = 1.5', "piston.section.exponent = 1.5"),
}


@pytest.mark.parametrize("name", list(BAD))
def test_bad_sides_are_refused(name: str) -> None:
    """One line that names field and value, and what to do."""
    old, new, problem = BAD[name]
    text = THRUST.read_text()
    assert old in text
    with pytest.raises(CamtoolsError) as info:
        geometry_of(text.replace(old, new))
    assert any(problem in line for line in info.value.lines), info.value.lines
    assert all(";" in line for line in info.value.lines)


def test_a_list_of_a_side_that_overshoots_may_be_allowed() -> None:
    """What the refusal of a spline names as a remedy is a key that helps."""
    text = THRUST.read_text().replace(DROP, 'drop_mm = [0, 0.05, 0]\ninterpolation = "spline"')
    text = text.replace("height_mm = [0, 28, 56]\ndrop_mm", "height_mm = [0, 10, 56]\ndrop_mm")
    with pytest.raises(CamtoolsError) as info:
        geometry_of(text)
    remedy = re.search(r"overshoot_um = \d+", info.value.lines[0])
    assert remedy, info.value.lines
    geometry_of(text.replace("blend_deg", f"{remedy[0]}\nblend_deg"))
