"""The corner of a large-bore skirt over its height, MATHS.md (13): where it is, how it is refitted.

A spline replaces the corner of an ellipse-arc section, MATHS.md (14) .. (17). One quadrant is
sampled once per degree, counted from the joint to both sides; points at the joint are left out, and
a cubic or quintic spline runs through the rest.

as-paper  the joint counts as the first of the s1 points on the ellipse's side, so (0, 0) keeps it;
          the quintic has averaged knots and free ends, the cubic is not-a-knot
mirror    the joint is always left out; knots at the points, odd derivatives 0 at both axes, so the
          closed curve has one continuous derivative more than its order less one: the fourth

>>> _from_joint(np.radians([0.0, 24.0, 48.0, 69.0, 90.0]), np.radians(48.0)).round(9).tolist()
[0.0, 0.5, 1.0, 1.5, 2.0]
"""

from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline, PPoly, make_interp_spline

from camtools.base.errors import GeometryError
from camtools.base.quantities import UM_PER_MM, Floats, FloatsLike, SectionValues
from camtools.skirt.geometry.poly_surface import TURN_RAD, PolySurface, angle_pieces, over_height
from camtools.skirt.geometry.profile import (
    Allowance,
    check_points,
    in_um,
    magnified,
    over_ovality,
)
from camtools.skirt.geometry.sections import QUARTER_RAD, Joint, Law, SkirtSurface, law_of
from camtools.skirt.part.curves import PeakOvality
from camtools.skirt.part.keys import Ovality, Refit
from camtools.skirt.part.part_file import SkirtPart

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
    curve = refit(joint, recipe, ellipse_steps(joint_rad))
    some = np.diff(curve.x) > 0  # repeated knots leave empty pieces
    curve = PPoly(curve.c[:, some], np.append(curve.x[:-1][some], curve.x[-1]))
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
    within = [
        candidate for candidate in candidates if candidate.tail_jerk_mm_s3 <= jerk_limit_mm_s3
    ]
    if not within:
        least = min(candidate.tail_jerk_mm_s3 for candidate in candidates)
        problem = f"no deletion keeps {jerk_limit_mm_s3:g} mm/s3; the least jerk is {least:.4g}"
        field = "piston.section.refit.jerk_limit_mm_s3"
        raise GeometryError(field, problem, "allow more, or turn more slowly")
    near = [candidate for candidate in within if candidate.deviation_um <= deviation_limit_um]
    if not near:
        return min(within, key=lambda candidate: candidate.deviation_um)
    return min(near, key=lambda candidate: candidate.acceleration_mm_s2)


MAX_STEP_MM = 0.001
REFIT_SHARE = 0.75  # of the accepted form error, unless the part says how far a refit may be off
_MAX_JUDGED, _MAX_CHECKED = 16, 100  # heights, for all candidates and for the one chosen
_JOINT = Allowance("joint_deg over height", 1.0, "degrees", 0.1, None)


class RefitDeviation(NamedTuple):
    """Where a refit is farthest off the drawing."""

    um: float
    z_mm: float
    deg: float  # from the long axis


@dataclass(frozen=True, eq=False)
class Corner(SkirtSurface):
    """A composite section over height, before and after its refit.

    Curves are over height [mm]. Candidates are all deletions the paper tries, at the part's speed,
    none without a refit: accelerations and jerks at `worst_mm`, largest deviations of all heights.
    """

    radius: PPoly  # mm
    ovality: PPoly  # mm
    trim: PPoly  # mm
    joint_deg: PPoly
    law: Law  # the oval's
    recipe: Recipe | None = None  # None: the corner is left as drawn
    worst_mm: float = 0.0  # height of the sharpest corner, for which the candidates are judged
    candidates: tuple[RefitCandidate, ...] = ()
    off: RefitDeviation | None = None  # how far the refit is off the drawing
    off_limit_um: float = np.inf  # how far it may be

    def joint(self, z_mm: FloatsLike) -> Joint:
        """Return what decides the section at heights; numbers for a number."""
        a, g, h = self.radius(z_mm), self.ovality(z_mm), self.trim(z_mm)
        return Joint(a, g, h, np.radians(self.joint_deg(z_mm)), self.law)

    def delta(self, phi_rad: FloatsLike, z_mm: FloatsLike) -> SectionValues:
        """Return the reduction as drawn, corner included; shapes as broadcast."""
        return self.joint(np.asarray(z_mm, dtype=np.float64)).reduction(phi_rad)

    @property
    def n_ellipse(self) -> int:
        """Return the degree steps from the long axis to the joint."""
        return ellipse_steps(float(np.radians(self.joint_deg(self.worst_mm))))

    def surface(self, breaks_mm: Floats) -> PolySurface:
        """Return the refitted skirt; breaks_mm are the heights where a spline may kink."""
        assert self.recipe is not None
        breaks_rad = self._breaks_rad(self.worst_mm)
        joint_rad = float(np.radians(self.joint_deg(self.worst_mm)))

        def pieces(z_mm: float) -> Floats:
            assert self.recipe is not None
            curve = refit(self.joint(z_mm), self.recipe, self.n_ellipse)
            return angle_pieces(curve, self._breaks_rad(z_mm))

        heights, coefficients = over_height(pieces, breaks_mm)
        turns = PPoly(np.radians(self.joint_deg.c) / TURN_RAD, self.joint_deg.x)
        return PolySurface(_from_joint(breaks_rad, joint_rad), heights, coefficients, turns)

    def _breaks_rad(self, z_mm: float) -> Floats:
        """Return all breaks of the refit at a height, the joint among them."""
        assert self.recipe is not None
        joint_rad = float(np.radians(self.joint_deg(z_mm)))
        if self.recipe.ends == "mirror":
            sites = sites_rad(joint_rad, self.n_ellipse)[kept_sites(self.recipe, self.n_ellipse)]
        else:
            sites = refit(self.joint(z_mm), self.recipe, self.n_ellipse).x
        apart = np.unique(np.concatenate([sites, [0.0, QUARTER_RAD]]))
        off = np.abs(apart - joint_rad) > 1e-9
        return np.asarray(np.unique(np.append(apart[off], joint_rad)), dtype=np.float64)


def _from_joint(phi_rad: Floats, joint_rad: float) -> Floats:
    """Return angles counted 0 .. 1 to the joint and 1 .. 2 to the short axis."""
    beyond = 1 + (phi_rad - joint_rad) / (QUARTER_RAD - joint_rad)
    return np.where(phi_rad < joint_rad, phi_rad / joint_rad, beyond)


def make_corner(part: SkirtPart, radius: PPoly, ovality: PPoly, heights_mm: Floats) -> Corner:
    """Return the corner of a part of shape "ellipse-arc".

    The shape is checked at dense heights, both ends among them. Raises GeometryError: no circle
    reaches from the joint to the short axis, or a given eccentricity does not fit.
    """
    section, drawn = part.piston.section, part.piston.ovality
    assert drawn is not None
    assert section.trim_mm is not None
    assert section.joint_deg is not None
    factor = part.magnify.factor if part.magnify else 1.0
    trim = over_ovality(section.trim_mm, drawn)
    corner = Corner(
        radius,
        ovality,
        magnified(trim, factor, 0.0),
        over_ovality(section.joint_deg, drawn),
        law_of(section.base or "cosine", np.asarray(section.beta, dtype=np.float64)),
    )
    if isinstance(drawn, Ovality):  # the lists are interpolated as it is
        allowed = in_um(drawn.overshoot_um, "trim_mm over height")
        check_points("piston.ovality.interpolation", trim, allowed, drawn)
        check_points("piston.ovality.interpolation", corner.joint_deg, _JOINT, drawn)
    _check_room(corner, heights_mm)
    if section.eccentricity_mm is not None and factor == 1:
        _check_eccentricity(corner, section.eccentricity_mm, drawn)
    return _with_recipe(corner, part, heights_mm)


def largest_deviation(corner: Corner, recipe: Recipe, heights_mm: Floats) -> RefitDeviation:
    """Return where a refit is farthest off the drawing, of all angles and the heights given."""
    worst = RefitDeviation(0.0, 0.0, 0.0)
    for z_mm in heights_mm:
        joint = corner.joint(float(z_mm))
        phi, off_mm = deviation_mm(joint, refit(joint, recipe, corner.n_ellipse))
        i = int(np.argmax(np.abs(off_mm)))
        off_um = float(np.abs(off_mm[i])) * UM_PER_MM
        if off_um > worst.um:
            worst = RefitDeviation(off_um, float(z_mm), float(np.degrees(phi[i])))
    return worst


def _judged(corner: Corner, wish: Refit, spindle_rpm: float) -> list[RefitCandidate]:
    """Return all candidates: motion at the sharpest height, deviation the largest of all."""
    breaks = np.union1d(corner.radius.x, corner.ovality.x)
    breaks = breaks[(breaks >= corner.radius.x[0]) & (breaks <= corner.radius.x[-1])]
    step = max(1, breaks.size // _MAX_JUDGED)  # arcs of the profile are many short pieces
    breaks = np.append(breaks[:-1:step], breaks[-1])
    heights_mm = np.unique(np.concatenate([breaks, (breaks[1:] + breaks[:-1]) / 2]))
    found, joint = [], corner.joint(corner.worst_mm)
    for candidate in judge_all(joint, wish.spline, wish.ends, spindle_rpm):
        recipe = Recipe(wish.spline, candidate.s1, candidate.s2, wish.ends)
        off = largest_deviation(corner, recipe, heights_mm)
        if off.um > candidate.deviation_um:
            candidate = candidate._replace(deviation_um=off.um, deviation_deg=off.deg)
        found.append(candidate)
    return found


def _with_recipe(corner: Corner, part: SkirtPart, heights_mm: Floats) -> Corner:
    wish, rpm = part.piston.section.refit, part.process.spindle_rpm
    sharpest = int(np.argmax(corner.joint(heights_mm).corner_mm_rad()))
    corner = replace(corner, worst_mm=float(heights_mm[sharpest]))
    if wish is None:
        return corner
    if wish.ends == "as-paper" and np.ptp(corner.joint_deg(corner.joint_deg.x)) > 0:
        problem = 'ends = "as-paper" is defined for one joint angle only'
        raise GeometryError("piston.section.refit.ends", problem, 'use "mirror"')
    limit_um = wish.deviation_um or REFIT_SHARE * part.tightest_um
    found = _judged(corner, wish, rpm)
    if wish.delete == "optimise":
        best = best_of(found, jerk_limit_of(wish.ends, wish.jerk_limit_mm_s3), limit_um)
        s1, s2 = best.s1, best.s2
    else:
        s1, s2 = wish.delete
    recipe = Recipe(wish.spline, s1, s2, wish.ends)
    off = largest_deviation(corner, recipe, heights_mm[:: max(1, heights_mm.size // _MAX_CHECKED)])
    judged_um = max(
        (candidate.deviation_um for candidate in found if (candidate.s1, candidate.s2) == (s1, s2)),
        default=0.0,
    )
    off = off._replace(um=max(off.um, judged_um))
    return replace(corner, recipe=recipe, candidates=tuple(found), off=off, off_limit_um=limit_um)


def refuse_deviation(corner: Corner, refit_of_part: Refit) -> None:
    """Refuse a refit farther off the drawing than allowed, with the nearest one and its cost."""
    off, recipe = corner.off, corner.recipe
    if off is None or recipe is None or off.um <= corner.off_limit_um:
        return
    given = "deviation_um" if refit_of_part.deviation_um else "three quarters of form_error_um"
    least = min(corner.candidates, key=lambda candidate: candidate.deviation_um)
    of_least = f"[{least.s1}, {least.s2}], {least.deviation_um:.2f} um at "
    of_least += f"{least.acceleration_mm_s2:.6g} mm/s2"
    allowed = f"{given} allows {corner.off_limit_um:g} um"
    if refit_of_part.delete == "optimise":
        stays = "no deletion stays that near to the drawing"
        problem = f"{stays}: {allowed}, the nearest is {of_least}"
    else:
        problem = (
            f"deleting [{recipe.s1}, {recipe.s2}] is {off.um:.2f} um off the drawing at height "
            f"{off.z_mm:.4g} mm, {off.deg:.1f} degrees; {allowed}, the nearest deletion is "
            f"{of_least}"
        )
    remedy = "allow more (deviation_um, and process.form_error_um above it), or trim less"
    raise GeometryError("piston.section.refit.deviation_um", problem, remedy)


def _check_room(corner: Corner, heights_mm: Floats) -> None:
    joint = corner.joint(heights_mm)
    room, arc = joint.room_mm(), joint.arc()
    worst = int(np.argmin(room))
    if room[worst] <= 0:
        problem = f"no circle reaches from the joint to the short axis at {heights_mm[worst]:.6g}"
        remedy = "trim less, or put the joint nearer to the short axis"
        raise GeometryError("piston.section.trim_mm", problem + " mm of height", remedy)
    least = int(np.argmin(arc.eccentricity_mm))
    if arc.eccentricity_mm[least] <= 0:
        problem = f"the circle would bulge beyond the piston at height {heights_mm[least]:.6g} mm"
        raise GeometryError("piston.section.trim_mm", problem, "trim more")


def _check_eccentricity(
    corner: Corner, given: list[float] | float, drawn: Ovality | PeakOvality
) -> None:
    """Demand that a given eccentricity is that of the circle, to 1 um of contour at the joint."""
    heights = np.array(drawn.height_mm)
    inside = (heights >= corner.radius.x[0]) & (heights <= corner.radius.x[-1])
    joint = corner.joint(heights)
    right, step = joint.arc().eccentricity_mm, joint.step_mm(np.asarray(given))
    off = np.where(inside, np.abs(step), 0.0)
    worst = int(np.argmax(off))
    if off[worst] > MAX_STEP_MM:
        here = np.broadcast_to(np.asarray(given), heights.shape)[worst]
        problem = (
            f"{here:g} mm leaves a step of {step[worst] * UM_PER_MM:.3f} um at the joint at "
            f"height {heights[worst]:g} mm"
        )
        remedy = f"the consistent value there is {right[worst]:.6f} mm; give it, or remove the key"
        raise GeometryError("piston.section.eccentricity_mm", problem, remedy)
