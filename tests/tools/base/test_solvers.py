"""Every solver ends with a message where it has not converged, never with its last guess."""

from collections.abc import Callable
from types import ModuleType

import numpy as np
import pytest
from scipy.optimize import least_squares

from camtools.base.quantities import Floats
from camtools.base.solvers import OF_RECORD, converged, inverted
from camtools.cut import speed_law
from camtools.cut.speed_law import Load, SpeedLimits, optimise
from camtools.part import smoothing
from camtools.polygon import generate
from camtools.polygon.generate import blend_of
from camtools.polygon.outline import Line, Outline
from camtools.roundness import section
from camtools.roundness.section import RoundProfile
from camtools.skirt.geometry import poly_surface
from camtools.skirt.geometry.sections import ellipse
from camtools.skirt.part import curves
from camtools.skirt.part.curves import DrawnSegment, curve_of, join
from camtools.skirt.tool import nose
from tests.tools.cases.part_cases import refused

TURN = 2 * np.pi * np.arange(360) / 360
HALF_TURN = (0.0, np.pi)
UNSOLVED = "no solution was found; report it with the input file"


def test_places_of_a_rising_function_are_found() -> None:
    """Against the arc cosine, at both ends and at a root in the middle of a flat stretch."""
    wanted = np.array([-1.0, -0.3, 0.0, 0.9, 1.0])
    found = inverted(lambda x: -np.cos(x), wanted, HALF_TURN, 1e-14, "angle")
    assert found == pytest.approx(np.arccos(-wanted), abs=1e-7)
    flat = inverted(lambda x: x**9, np.zeros(1), (-1.0, 2.0), 1e-60, "place")
    assert abs(flat[0]) < 1e-6


def _eccentric() -> object:
    return section.least_squares(RoundProfile(TURN, 10 + 0.5 * np.cos(TURN)))


def _square() -> object:
    normals = np.arange(4) * np.pi / 2
    sides = tuple(Line(10.0, float(normal)) for normal in normals)
    outline = Outline(tuple((normals - np.pi / 4).tolist()), sides, 4)
    return blend_of(next(outline.joints()), 1e-3)


class _Barrel:
    """A surface whose slope changes over the height."""

    def values(self, phi: Floats, z: Floats) -> Floats:
        return np.stack([10 - z**2 / 200, 0 * z, 0 * z, 0 * z])


def _nose() -> object:
    rays = nose.Rays(_Barrel(), np.array([0.0, 20.0]))
    return nose.find_contact(rays, np.zeros(1), np.array([10.0]), 2.0, 0.0, 20.0)


def _smoothed() -> object:
    values: Floats = np.asarray(1 + np.round(np.sin(TURN), 2), dtype=np.float64)
    return smoothing.smoothed(TURN, values, 0.01, period=2 * np.pi)


def _arc() -> object:
    drop_mm = 10 - float(np.sqrt(10**2 - 9.9**2))
    return curve_of(join(0.0, 50.0, (DrawnSegment(9.9, 50 - drop_mm, "arc", 10.0, False),)))


def _sections() -> object:
    return poly_surface.over_height(lambda z: np.full((1, 6), np.exp(-9 * z)), np.array([0.0, 9.0]))


def _speed() -> object:
    phi = np.pi * np.arange(speed_law.N_GRID) / speed_law.N_GRID
    u = ellipse(phi, 46.0, 0.2)
    load = Load((46.1**2 - (46 - u.delta) ** 2) / 2, u.d1, u.d2, np.pi)
    return optimise(load, SpeedLimits(500.0, 314.0, 400.0, 250_000.0), 60.0)


@pytest.mark.parametrize(
    ("module", "limit", "solve", "subject"),
    [
        (section, "_MOST_ROUNDS", _eccentric, "circle of a section"),
        (generate, "_STEPS", _square, "polygon.blend_um"),
        (nose, "_MAX_STEPS", _nose, "tool.nose_mm: contact"),
        (smoothing, "_MOST_STEPS", _smoothed, "smooth_um"),
        (curves, "_MAX_HALVINGS", _arc, "piston.profile: arc of radius_mm = 10"),
        (poly_surface, "_MAX_HALVINGS", _sections, "piston.section: sections at 0 mm of height"),
        (speed_law, "_MAX_CUTS", _speed, "process.speed: law of least ripple"),
    ],
)
def test_solver_at_its_limit_is_refused(
    module: ModuleType,
    limit: str,
    solve: Callable[[], object],
    subject: str,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Without any of its steps; with all of them it solves the same."""
    solve()
    monkeypatch.setattr(module, limit, 0)
    assert refused(solve) == f"{subject}: {UNSOLVED}"


def test_what_scipy_has_not_found_is_refused() -> None:
    """An optimiser that is stopped, and a function without a value."""
    stopped = least_squares(lambda x: x**3 - 2, np.array([9.0]), max_nfev=2)
    found = refused(lambda: converged(stopped, "record: mode", OF_RECORD))
    assert found == "record: mode: no solution was found; record for longer, or excite more"
    nan = np.full(2, np.nan)
    assert refused(lambda: inverted(np.cos, nan, HALF_TURN, 0.0, "x")) == f"x: {UNSOLVED}"
