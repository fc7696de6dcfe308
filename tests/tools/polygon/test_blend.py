"""Blends: they cost what they may, make U's motion smooth, and leave the rest alone."""

import numpy as np
import pytest

from camtools.polygon.blend import bend_of, blended
from camtools.polygon.outline import Outline
from camtools.polygon.shapes import cornered, p3g, p4c, regular

PHI = np.linspace(0, 2 * np.pi, 200_001)
SHARP = {
    "p4c": p4c(35.0, 30.0, 5.0, 0.1),
    "sharp hexagon": regular(6, 20.0, 0.0, 0.0),
    "rounded hexagon": regular(6, 20.0, 1.0, 0.2),
    "triangle": cornered([[10, -8], [10, 8], [-12, 0]], [1.0, 1.0, 2.0], 0.0),
}


@pytest.mark.parametrize("drawing", SHARP.values(), ids=SHARP.keys())
@pytest.mark.parametrize("blend_um", [0.3, 5.0])
def test_deviation_is_what_is_allowed(drawing: Outline, blend_um: float) -> None:
    """Dense samples are off by at most the blend, and by as much where there is room."""
    one = blended(drawing, blend_um)
    off_um = 1000 * float(np.abs(one.outline.polar(PHI).r - drawing.polar(PHI).r).max())
    assert off_um <= blend_um * (1 + 1e-4)
    assert off_um == pytest.approx(one.deviation_um, rel=0.05)
    assert one.is_squeezed or one.deviation_um == pytest.approx(blend_um, rel=1e-6)


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
    product = one.deviation_um / 1000 * bend_of(one)
    assert product == pytest.approx((315**2 / 2560 / 256) * joint.slope_mm**2, rel=0.01)


def test_rounding_is_inside_of_a_corner() -> None:
    """A blend of a corner takes metal away and leaves none."""
    drawing = SHARP["p4c"]
    off = blended(drawing, 5.0).outline.polar(PHI).r - drawing.polar(PHI).r
    assert off.max() < 1e-12 and off.min() == pytest.approx(-0.005, rel=5e-3)


def test_smooth_outlines_need_none() -> None:
    """P3G has no joints."""
    assert blended(p3g(25.0, 0.8, 0.0), 2.0).blends == ()
