"""Lists whose acceleration steps, against the arcs and laws that they are made of."""

from collections.abc import Callable

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Floats
from camtools.lobe import list_curve
from camtools.lobe.generate import generate_lobes
from camtools.lobe.lift import Listed, curve_of
from camtools.lobe.list_curve import spline_through, steps_of
from camtools.lobe.motion import make_lobes
from tests.tools.cases.cut_cases import PARTS
from tests.tools.cases.lobe_cases import cam
from tests.tools.cases.part_cases import refused

BASE_MM, NOSE_MM, LIFT_MM, FLANK_DEG = 15.0, 5.0, 6.0, 65.0
HALF_RAD = np.radians(65.0)
DENSE = np.radians(np.arange(-180, 180, 0.01))
Law = Callable[[Floats], Floats]


def arcs(alpha_rad: Floats) -> tuple[Floats, Floats]:
    """Return lift under a flat face, and radius of curvature, of three arcs by their drawing.

    The flank is tangent to the base circle at 65 degrees, and to the circle of the nose.
    """
    nose_at, flank = BASE_MM + LIFT_MM - NOSE_MM, np.radians(FLANK_DEG)
    more = BASE_MM - NOSE_MM
    off = (nose_at**2 - more**2) / (2 * more - 2 * nose_at * np.cos(flank))  # of the flank's centre
    joint = np.arctan2(off * np.sin(flank), nose_at + off * np.cos(flank))
    alpha = np.abs(alpha_rad)
    zones = [alpha <= joint, alpha <= flank]
    lifts = [nose_at * np.cos(alpha) - more, off * (1 - np.cos(alpha - flank))]
    lift: Floats = np.select(zones, lifts, 0.0).astype(np.float64)
    return lift, np.select(zones, [NOSE_MM, BASE_MM + off], BASE_MM).astype(np.float64)


def turned(x: Floats) -> Floats:
    """Return angles within half a turn of the nose."""
    return np.mod(x + np.pi, 2 * np.pi) - np.pi


def three_arcs(step_deg: float, first_deg: float = 0.0) -> tuple[Floats, Floats]:
    """Return a list of three arcs to a nanometre."""
    deg: Floats = first_deg + step_deg * np.arange(round(360 / step_deg), dtype=np.float64)
    return deg, np.round(arcs(turned(np.radians(deg)))[0], 6)


def test_a_curve_that_is_not_determined_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """The solver of scipy answers a singular matrix with NaN."""

    def singular(_: object, values: Floats) -> Floats:
        return np.full(values.size, np.nan)

    monkeypatch.setattr(list_curve, "spsolve", singular)
    found = refused(lambda: spline_through(*three_arcs(1.0)))
    assert found.startswith("cam.lobe: curve of the list: no solution was found; ")


@pytest.mark.parametrize(("step_deg", "within_mm"), [(0.5, 0.8), (1.0, 0.15), (2.0, 0.15)])
@pytest.mark.parametrize("first_deg", [0.0, -179.7])
def test_arcs_of_a_list_keep_their_radii(
    step_deg: float, within_mm: float, first_deg: float
) -> None:
    """Lift to some nanometres; radii of 5, 39.09 and 15 mm up to their joints, but for rounding."""
    law = Listed(spline_through(*three_arcs(step_deg, first_deg))).evaluate(DENSE)
    lift, radius = arcs(DENSE)
    assert f"{radius.max():.2f}" == "39.09"
    assert np.abs(law.lift - lift).max() < 10e-6
    is_apart = np.abs(np.diff(radius, append=radius[0])) < 1
    is_apart &= np.abs(np.diff(radius, prepend=radius[-1])) < 1
    assert np.abs((BASE_MM + law.lift + law.d2 - radius)[is_apart]).max() < within_mm


def arcs_text(template: str, more: str = "") -> str:
    """Return a part of the repository with a lobe of three arcs under a flat face."""
    deg, lift = three_arcs(1.0)
    listed = f'law = "list"\nangle_deg = {deg.tolist()}\nlift_mm = {lift.tolist()}\n{more}'
    text = (PARTS / f"{template}.toml").read_text()
    text = text.replace('law = "poly345"\nlift_mm = 8\nhalf_angle_deg = 70\n', listed)
    return text.replace("base_radius_mm = 20", 'base_radius_mm = 15\nfollower = "flat"')


def test_sharpest_radius_of_three_arcs_is_that_of_the_nose() -> None:
    """In the part, ground under a flat face; the pieces of its drawing rise in angle."""
    [lobe] = make_lobes(cam(arcs_text("cam-345-ground")))
    assert lobe.shape.least_radius_mm == pytest.approx(NOSE_MM, abs=0.01)
    assert isinstance(lobe.law, Listed)
    curve = curve_of(lobe.law)
    assert np.all(np.diff(curve.x) > 0) and curve.c.shape == (6, curve.x.size - 1)
    theta = np.mod(DENSE - curve.x[0], 2 * np.pi) + curve.x[0]
    assert curve(theta) == pytest.approx(lobe.law.evaluate(DENSE).lift, abs=1e-9)


def test_turned_arcs_need_a_smoothed_list() -> None:
    """The swing would have to change its speed at once; the refusal names the key that helps."""
    with pytest.raises(CamtoolsError, match="less jerk, of a list by smooth_um"):
        generate_lobes(cam(arcs_text("cam-345")))
    text = arcs_text("cam-345", "smooth_um = 0.5\n")
    text = text.replace("spindle_rpm = 60\n", "spindle_rpm = 30\n")
    assert generate_lobes(cam(text)).angle.error <= 1e-4


def rise(theta: Floats) -> Floats:
    """Return the share of a flank of 65 degrees, 1 at the nose."""
    return np.asarray(np.clip(1 - np.abs(theta) / HALF_RAD, 0, 1))


def harmonic(theta: Floats) -> Floats:
    """Return a rise whose acceleration steps at the base circle."""
    return np.asarray(4 * (1 - np.cos(np.pi * rise(theta))))


def parabolic(theta: Floats) -> Floats:
    """Return a rise of constant acceleration, which steps in the middle of the flank, too."""
    x = rise(theta)
    return np.asarray(8 * np.where(x < 0.5, 2 * x**2, 1 - 2 * (1 - x) ** 2))


def poly345(theta: Floats) -> Floats:
    """Return a rise whose jerk alone steps."""
    x = rise(theta)
    return np.asarray(8 * x**3 * (10 - 15 * x + 6 * x**2))


def poly4567(theta: Floats) -> Floats:
    """Return a rise whose jerk is continuous."""
    x = rise(theta)
    return np.asarray(8 * x**4 * (35 - 84 * x + 70 * x**2 - 20 * x**3))


def cycloidal(theta: Floats) -> Floats:
    """Return the same with a cycloid."""
    x = rise(theta)
    return np.asarray(8 * (x - np.sin(2 * np.pi * x) / (2 * np.pi)))


@pytest.mark.parametrize(
    ("law", "at_deg"),
    [
        (harmonic, [65.0, 295.0]),
        (parabolic, [32.5, 65.0, 295.0, 327.5]),
        (poly345, []),
        (poly4567, []),
        (cycloidal, []),
        (lambda theta: 5 * (1 + np.cos(theta)), []),
    ],
)
@pytest.mark.parametrize("n", [180, 360, 720])
def test_only_what_steps_is_a_step(law: Law, at_deg: list[float], n: int) -> None:
    """Listed to a nanometre; rounded to a micrometre noise hides every step, and makes none."""
    x = 2 * np.pi * np.arange(n) / n
    lift = law(turned(x))
    found = [np.degrees(step.place) for step in steps_of(x, np.round(lift, 6), 2 * np.pi)]
    assert found == pytest.approx(at_deg, abs=0.01)
    assert not steps_of(x, np.round(lift, 3), 2 * np.pi)


def test_rounding_of_many_points_makes_no_step() -> None:
    """A tenth of a degree apart, where a nanometre is as much as the change of the slope."""
    x = 2 * np.pi * np.arange(3600) / 3600
    found = steps_of(x, np.round(harmonic(turned(x)), 6), 2 * np.pi)
    assert [np.degrees(step.place) for step in found] == pytest.approx([65, 295], abs=0.01)


def test_lift_is_a_number_next_to_the_first_point() -> None:
    """One rounding before it and after it, a turn on and a turn back."""
    for first in np.random.default_rng(2).uniform(-np.pi, np.pi, 200):
        x = first + 2 * np.pi * np.arange(30) / 30
        law = Listed(spline_through(np.degrees(x), 1 + np.cos(x)))
        near = np.radians(np.degrees(first)) + 2 * np.pi * np.arange(-1, 2)
        near = np.concatenate([np.nextafter(near, -9), near, np.nextafter(near, 9)])
        assert law.evaluate(near).lift == pytest.approx(1 + np.cos(near), abs=1e-5)
