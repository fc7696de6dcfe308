"""The spline that replaces the corner of an ellipse-arc section, MATHS.md (14) .. (17).

One quadrant is sampled once per degree, counted from the joint to both sides; points at the joint
are left out, and a cubic or quintic spline runs through the rest.

as-paper  the joint counts as the first of the s1 points on the ellipse's side, so (0, 0) keeps it;
          the quintic has averaged knots and free ends, the cubic is not-a-knot
mirror    the joint is always left out; knots at the points, odd derivatives 0 at both axes, so the
          closed curve has one continuous derivative more than its order less one: the fourth

>>> joint = Joint(45.4645484572, 0.38, 0.4, np.radians(48.0))
>>> paper = [judge(joint, Recipe("quintic", s, s, "as-paper"), 800.0) for s in (0, 3)]
>>> [f"{one.acceleration_mm_s2:.0f}" for one in paper]
['627349', '112686']
"""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline, PPoly, make_interp_spline

from camtools.base.errors import GeometryError
from camtools.base.quantities import UM_PER_MM, Floats
from camtools.skirt.geometry.sections import QUARTER_RAD, Joint

N_SITES = 91
CANDIDATES = tuple(product(range(4), range(4)))  # (s1, s2) as the paper tries them
PAPER_JERK_LIMIT_MM_S3 = 1e7
_TAIL_RAD = np.radians(2.0)  # the paper's jerk is that beyond the refitted corner
_DENSE_PER_PIECE = 32


class Recipe(NamedTuple):
    """How a corner is refitted."""

    spline: str  # cubic | quintic
    s1: int  # points left out on the ellipse's side
    s2: int  # ... on the circle's side
    ends: str  # mirror | as-paper


class RefitCandidate(NamedTuple):
    """What a refit does to the motion of U at a spindle speed, and to the contour."""

    s1: int
    s2: int
    acceleration_mm_s2: float  # largest
    peak_deg: float  # where
    undershoot_mm_s2: float  # least
    tail_jerk_mm_s3: float  # largest signed jerk from 2 degrees beyond the joint on
    jerk_mm_s3: float  # largest magnitude
    deviation_um: float  # largest distance from the drawing's contour
    deviation_deg: float


def ellipse_steps(joint_rad: float) -> int:
    """Return how many degree steps lie between the long axis and the joint."""
    return round(float(np.degrees(joint_rad)))


def sites_rad(joint_rad: float, n_ellipse: int) -> Floats:
    """Return the sampled angles of a quadrant, shape (91,): whole degrees for a whole joint."""
    before = joint_rad * np.arange(n_ellipse) / n_ellipse
    n_arc = N_SITES - 1 - n_ellipse
    after = joint_rad + (QUARTER_RAD - joint_rad) * np.arange(n_arc + 1) / n_arc
    return np.asarray(np.concatenate([before, after]), dtype=np.float64)


def kept_sites(recipe: Recipe, n_ellipse: int) -> npt.NDArray[np.int64]:
    """Return the indices of the sites that the spline runs through."""
    sites = np.arange(N_SITES)
    shift = 1 if recipe.ends == "as-paper" else 0
    is_left_out = (sites >= n_ellipse - recipe.s1 + shift) & (sites <= n_ellipse + recipe.s2)
    if recipe.ends == "mirror":
        is_left_out |= sites == n_ellipse
    return np.flatnonzero(~is_left_out)


def fit(x_rad: Floats, y_mm: Floats, recipe: Recipe) -> PPoly:
    """Return the spline of degree 3 or 5 through angles 0 .. pi/2 and radius reductions."""
    is_mirror = recipe.ends == "mirror"
    if recipe.spline == "cubic":
        return CubicSpline(x_rad, y_mm, bc_type="clamped" if is_mirror else "not-a-knot")
    if is_mirror:
        flat = [(1, np.zeros(y_mm.shape[1:])), (3, np.zeros(y_mm.shape[1:]))]
        return PPoly.from_spline(make_interp_spline(x_rad, y_mm, k=5, bc_type=(flat, flat)))
    # Knots of order 6 whose inner ones are means of five sites.
    inner = [float(x_rad[i : i + 5].mean()) for i in range(1, x_rad.size - 5)]
    knots = np.concatenate([np.full(6, x_rad[0]), inner, np.full(6, x_rad[-1])])
    return PPoly.from_spline(make_interp_spline(x_rad, y_mm, k=5, t=knots))


def refit(joint: Joint, recipe: Recipe, n_ellipse: int) -> PPoly:
    """Return the refitted quadrant of one section."""
    x_rad = sites_rad(float(joint.joint_rad), n_ellipse)[kept_sites(recipe, n_ellipse)]
    return fit(x_rad, joint.reduction(x_rad).delta, recipe)


def _pieces(curve: PPoly) -> PPoly:
    """Return a curve without the empty pieces that repeated knots leave."""
    some = np.diff(curve.x) > 0
    return PPoly(curve.c[:, some], np.append(curve.x[:-1][some], curve.x[-1]))


def extremes(curve: PPoly, low: float, high: float) -> Floats:
    """Return all places between low and high where a curve may be largest or least."""
    turning = curve.derivative().roots(discontinuity=True, extrapolate=False)
    places = np.concatenate([[low, high], curve.x, turning[np.isfinite(turning)]])
    return np.asarray(np.unique(places[(places >= low) & (places <= high)]), dtype=np.float64)


def deviation_mm(joint: Joint, curve: PPoly) -> tuple[Floats, Floats]:
    """Return angles over the quadrant [rad] and how much deeper the refit is there [mm]."""
    breaks = np.union1d(curve.x, [float(joint.joint_rad)])
    share = np.arange(_DENSE_PER_PIECE) / _DENSE_PER_PIECE
    phi = np.append((breaks[:-1, None] + np.diff(breaks)[:, None] * share).ravel(), breaks[-1])
    return phi, np.asarray(curve(phi) - joint.reduction(phi).delta, dtype=np.float64)


def judge(joint: Joint, recipe: Recipe, spindle_rpm: float) -> RefitCandidate:
    """Return what a refit does to one section at a speed [r/min]."""
    joint_rad, omega = float(joint.joint_rad), 2 * np.pi * spindle_rpm / 60
    curve = _pieces(refit(joint, recipe, ellipse_steps(joint_rad)))
    bend, twist = curve.derivative(2), curve.derivative(3)
    places = extremes(bend, 0.0, QUARTER_RAD)
    bends = bend(places) * omega**2
    tail = twist(extremes(twist, joint_rad + _TAIL_RAD, QUARTER_RAD)) * omega**3
    jerk = twist(extremes(twist, 0.0, QUARTER_RAD)) * omega**3
    phi, off_mm = deviation_mm(joint, curve)
    worst = int(np.argmax(np.abs(off_mm)))
    return RefitCandidate(
        recipe.s1,
        recipe.s2,
        float(bends.max()),
        float(np.degrees(places[int(np.argmax(bends))])),
        float(bends.min()),
        float(tail.max()),
        float(np.abs(jerk).max()),
        float(np.abs(off_mm[worst])) * UM_PER_MM,
        float(np.degrees(phi[worst])),
    )


def judge_all(joint: Joint, spline: str, ends: str, spindle_rpm: float) -> list[RefitCandidate]:
    """Return all 16 candidates of the paper, s1 rising fastest."""
    return [judge(joint, Recipe(spline, s1, s2, ends), spindle_rpm) for s2, s1 in CANDIDATES]


def jerk_limit_of(ends: str, given_mm_s3: float | None) -> float:
    """Return the limit of the tail's jerk: the paper's with its ends, else none unless given."""
    if given_mm_s3 is not None:
        return given_mm_s3
    return PAPER_JERK_LIMIT_MM_S3 if ends == "as-paper" else float("inf")


def best_of(
    candidates: list[RefitCandidate], jerk_limit_mm_s3: float, deviation_limit_um: float = np.inf
) -> RefitCandidate:
    """Return the candidate of least peak acceleration within both limits, MATHS.md (16), (74).

    Where none is near enough to the drawing it is the nearest one, which the generator refuses.
    Raises GeometryError: no candidate keeps the limit of the jerk.
    """
    within = [one for one in candidates if one.tail_jerk_mm_s3 <= jerk_limit_mm_s3]
    if not within:
        least = min(one.tail_jerk_mm_s3 for one in candidates)
        problem = f"no deletion keeps {jerk_limit_mm_s3:g} mm/s3; the least jerk is {least:.4g}"
        field = "piston.section.refit.jerk_limit_mm_s3"
        raise GeometryError(field, problem, "allow more, or turn more slowly")
    near = [one for one in within if one.deviation_um <= deviation_limit_um]
    if not near:
        return min(within, key=lambda one: one.deviation_um)
    return min(near, key=lambda one: one.acceleration_mm_s2)
