"""From a polygon to its table, checked against the outline and the machine's limits.

Blends replace the joints of an outline, so that U's acceleration does not jump. Where two curves
meet the slope of the radius jumps (two sides without a corner radius, flank and circle of DIN
32712) or its second derivative does (side and corner arc). Over a window around the joint one curve
goes over into the other with five continuous derivatives, MATHS.md (117); outside of the windows
the outline is the drawing's.

>>> from camtools.polygon.part import example_polygon
>>> made = generate_polygon(example_polygon())
>>> made.accuracy_u.value_nm < 1.0, made.blended.deviation_um
(True, 0.0)
"""

from collections.abc import Hashable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np
from numpy.polynomial import chebyshev
from numpy.polynomial.polynomial import Polynomial
from scipy.interpolate import PPoly

from camtools.base.cache import recall
from camtools.base.errors import CamtoolsError
from camtools.base.quantities import NM_PER_MM, UM_PER_MM, Floats, omega_rad_s
from camtools.base.solvers import unsolved
from camtools.cut.feasibility import HighestSpeed, Peaks, drift_of, peaks_of
from camtools.cut.passes import checked_passes, judge_passes, records_of
from camtools.polygon.outline import (
    Curve,
    Outline,
    OutlineJoint,
    Polar,
    Reach,
    all_around,
    cornered,
    extremes_of,
    is_smooth,
    p3g,
    p4c,
    prism_of,
    regular,
)
from camtools.polygon.part import PolygonPart, PolygonSection
from camtools.skirt.geometry.poly_surface import PolySurface
from camtools.skirt.geometry.skirt_geometry import Geometry
from camtools.skirt.table.accuracy import (
    DERIVATIVE_SHARE,
    Accuracy,
    measure_u,
    measure_x,
    slice_counts,
    u_channel,
    x_channel,
)
from camtools.skirt.tool.nose import tip_geometry
from camtools.skirt.tool.turning import Heel, check_heel, judged, middle_nm, moved
from camtools.table.channel import (
    KNOT_SIZE,
    MAX_CHANNEL_BYTES,
    MAX_LOG2_KNOTS,
    MIN_LOG2_KNOTS,
    Channel,
)
from camtools.table.header import MAX_PEAK_NM, TooLargeError, table_of, u_bounds, with_bounds
from camtools.table.image import Table

_BUMP = Polynomial([1.0, 0.0, -1.0]) ** 4 * (315 / 256)  # area 1 over -1 .. 1
_STEP = _BUMP.integ(lbnd=-1)
_RAMP = _STEP.integ(lbnd=-1)  # 0 below -1, x above 1
_RAMPS = (_RAMP, _STEP, _BUMP, _BUMP.deriv())
_NEAR = 0.2  # share of the window in which the quotient is a polynomial
_NODES = 16  # of it; even, so that none lies at the joint
_ROOM = 0.49  # of the shorter curve that a window takes
_SHARE_OF_REACH = 0.8  # that a window takes
_LOOKED_AT = np.linspace(-1, 1, 801)
_STEPS, _SAME, _ROUNDING = 60, 1e-8, 1e-9
_SLIGHT = 1e-3


@dataclass(frozen=True, eq=False)
class Blend:
    """A curve that goes over from one curve into another of the same radius at the joint."""

    before: Curve
    behind: Curve
    joint_rad: float  # middle of the window
    half_rad: float  # half its width

    @property
    def reach(self) -> Reach:
        """See `Curve.reach`."""
        return Reach(self.joint_rad - self.half_rad, self.joint_rad + self.half_rad)

    def _difference(self, y: Floats) -> Floats:
        """Return the curve behind minus the one before, with derivatives, shape (4, n)."""
        phi = self.joint_rad + y
        return np.stack(self.behind.polar(phi)) - np.stack(self.before.polar(phi))

    @cached_property
    def _middle(self) -> list[chebyshev.Chebyshev]:
        """Return the difference over y, and derivatives, as polynomials near the joint."""
        near = _NEAR * self.half_rad
        nodes = near * np.cos(np.pi * (np.arange(_NODES) + 0.5) / _NODES)
        values = self._difference(nodes)[0] / nodes
        fit = chebyshev.Chebyshev.fit(nodes, values, _NODES - 1, domain=[-near, near])
        return [fit, *(fit.deriv(n) for n in (1, 2, 3))]

    def _quotient(self, y: Floats) -> Floats:
        """Return the difference over y and three derivatives, shape (4, n)."""
        is_near = np.abs(y) < _NEAR * self.half_rad
        found = np.empty((4, y.size))
        found[:, is_near] = np.stack([polynomial(y[is_near]) for polynomial in self._middle])
        far = y[~is_near]
        d = self._difference(far)
        found[0, ~is_near] = g = d[0] / far
        for n in (1, 2, 3):
            g = (d[n] - n * g) / far
            found[n, ~is_near] = g
        return found

    def polar(self, phi_rad: Floats) -> Polar:
        """See `Curve.polar`."""
        y = np.asarray(np.mod(phi_rad - self.joint_rad + np.pi, 2 * np.pi) - np.pi)
        w = self.half_rad
        p = np.stack([ramp(np.clip(y / w, -1, 1)) for ramp in _RAMPS])
        p[0] += np.maximum(y / w - 1, 0)
        p *= w ** (1 - np.arange(4.0))[:, None]
        g, before = self._quotient(y), self.before.polar(phi_rad)
        return Polar(
            before.r + p[0] * g[0],
            before.d1 + p[1] * g[0] + p[0] * g[1],
            before.d2 + p[2] * g[0] + 2 * p[1] * g[1] + p[0] * g[2],
            before.d3 + p[3] * g[0] + 3 * p[2] * g[1] + 3 * p[1] * g[2] + p[0] * g[3],
        )

    def looked_at(self) -> Floats:
        """Return angles all over the window."""
        return self.joint_rad + self.half_rad * _LOOKED_AT

    def deviation_mm(self) -> float:
        """Return the largest distance from the two curves."""
        phi = self.looked_at()
        drawn = np.where(phi < self.joint_rad, self.before.polar(phi).r, self.behind.polar(phi).r)
        return float(np.abs(self.polar(phi).r - drawn).max())

    def acceleration_mm(self) -> float:
        """Return the largest second derivative [mm/rad^2]."""
        return float(np.abs(self.polar(self.looked_at()).d2).max())


class Blended(NamedTuple):
    """An outline whose joints are blended."""

    outline: Outline
    blends: tuple[Blend, ...]
    is_squeezed: bool  # a window has no room for all of the deviation

    @property
    def deviation_um(self) -> float:
        """Return the largest deviation from the drawing [um]."""
        return max((blend.deviation_mm() for blend in self.blends), default=0.0) * UM_PER_MM


def bend_of(cut: Blended) -> float:
    """Return the largest second derivative of the radius all around [mm/rad^2]."""
    around = float(np.abs(cut.outline.polar(all_around(cut.outline)).d2).max())
    return max(around, *(blend.acceleration_mm() for blend in cut.blends), 0.0)


def widest_rad(joint: OutlineJoint) -> float:
    """Return the largest half width of a window at a joint."""
    below = joint.angle_rad - joint.behind.reach.first
    above = joint.before.reach.last - joint.angle_rad
    reach = min(float(np.mod(angle + _ROUNDING, 2 * np.pi)) for angle in (below, above))
    return min(_ROOM * joint.room_rad, _SHARE_OF_REACH * reach)


def blend_of(joint: OutlineJoint, deviation_mm: float) -> Blend:
    """Return the widest blend of a joint whose deviation is within a limit."""

    def blend(half: float) -> Blend:
        return Blend(joint.before, joint.behind, joint.angle_rad, half)

    high = widest_rad(joint)
    widest = blend(high)
    if (found := widest.deviation_mm()) <= deviation_mm:
        return widest
    # the deviation is about a power of the width, so few steps are enough; halving keeps it safe
    power = 2 if abs(joint.slope_mm) < _SLIGHT * abs(joint.bend_mm) * high else 1
    low, at = 0.0, high
    for _ in range(_STEPS):
        guess = at * (deviation_mm / found) ** (1 / power) * (1 - _ROUNDING)
        at = guess if low < guess < high else (low + high) / 2
        found = blend(at).deviation_mm()
        low, high = (at, high) if found <= deviation_mm else (low, at)
        if deviation_mm * (1 - _SAME) < found <= deviation_mm:
            return blend(low)
    raise unsolved("polygon.blend_um")


def blended(outline: Outline, deviation_um: float) -> Blended:
    """Return an outline with all joints blended, as wide as a deviation allows."""
    deviation_mm = deviation_um / UM_PER_MM
    joints = [joint for joint in outline.joints() if not is_smooth(joint)]
    if not joints:
        return Blended(outline, (), False)
    first = joints[: max(1, len(joints) // outline.repeat)]
    found = [blend_of(joint, deviation_mm) for joint in first]
    widths = [blend.half_rad for blend in found]
    squeezed = any(
        blend.half_rad >= widest_rad(joint) for blend, joint in zip(found, first, strict=True)
    )
    blends = tuple(
        Blend(joint.before, joint.behind, joint.angle_rad, widths[i % len(widths)])
        for i, joint in enumerate(joints)
    )
    return Blended(_with(outline, joints, blends), blends, squeezed)


def _with(outline: Outline, joints: list[OutlineJoint], blends: tuple[Blend, ...]) -> Outline:
    starts: list[float] = []
    curves: list[Curve] = []
    of = {joint.i: blend for joint, blend in zip(joints, blends, strict=True)}
    for i, (start, curve) in enumerate(zip(outline.starts_rad, outline.curves, strict=True)):
        blend = of.get(i)
        if blend is not None:
            starts.append(start - blend.half_rad)
            curves.append(blend)
            start += blend.half_rad
        starts.append(start)
        curves.append(curve)
    return Outline(tuple(starts), tuple(curves), outline.repeat)


DEFAULT_TOLERANCES_NM = (1.0, 3.0, 10.0)  # the first that a stroke of millimetres allows
_MOST_BLEND_UM = 1000.0
_BISECTIONS, _SHARP = 30, 1e-3
_HINT_MARGIN = 1.02  # what is advised is a little more than what is needed


@dataclass(frozen=True, eq=False)
class GeneratedPolygon:
    """A table of a polygon and everything that is known about it."""

    part: PolygonPart
    drawing: Outline  # the section of the first height, as drawn
    blended: Blended  # the section as it is cut, with what the blends of its joints cost
    design: PolySurface  # surface of the drawing
    geometry: Geometry  # surface that the table holds
    tolerance_nm: float
    table: Table
    accuracy_u: Accuracy
    accuracy_x: Accuracy
    peaks: Peaks
    highest_speed: HighestSpeed
    middle_nm: int  # what X takes over from U, `process.u_zero`
    heel: Heel

    @property
    def deviation_um(self) -> float:
        """Return the largest deviation of the cut contour from the drawing [um]."""
        return self.blended.deviation_um * growth_of(self.part.polygon, self.drawing)


def growth_of(section: PolygonSection, drawing: Outline) -> float:
    """Return the size of the largest section over that of the first: so much blends grow."""
    _, largest_mm = extremes_of(drawing)
    return max(1.0, 1 + section.taper * section.length_mm / (2 * largest_mm))


def outline_of(section: PolygonSection) -> Outline:
    """Return the section of the first height as the part file draws it, or refuse its numbers."""
    phase, radii = float(np.radians(section.phase_deg)), section.corner_radius_mm or 0.0
    if section.form == "p3g":
        assert section.mean_diameter_mm and section.eccentricity_mm
        return p3g(section.mean_diameter_mm, section.eccentricity_mm, phase)
    if section.form == "p4c":
        assert section.outer_diameter_mm and section.inner_diameter_mm and section.eccentricity_mm
        diameters = section.outer_diameter_mm, section.inner_diameter_mm
        return p4c(*diameters, section.eccentricity_mm, phase)
    if section.form == "regular":
        assert section.sides and section.across_flats_mm and not isinstance(radii, list)
        return regular(section.sides, section.across_flats_mm, radii, phase)
    assert section.corners_mm
    many = radii if isinstance(radii, list) else [radii] * len(section.corners_mm)
    return cornered(section.corners_mm, many, phase)


def factors_of(part: PolygonPart, outer_mm: float) -> tuple[float, float]:
    """Return the size of the sections where the tool begins and ends, above 0, MATHS.md (118)."""
    section = part.polygon
    first, last = (1 + section.taper * (z - section.z_mm[0]) / outer_mm for z in part.heights_mm)
    if min(first, last) <= 0:
        problem = f"polygon.taper = {section.taper:g}: comes to a point within the path of the tool"
        raise CamtoolsError([f"{problem}; give less taper, or less run-in and run-out"])
    return first, last


def surfaces_of(part: PolygonPart, drawing: Outline, cut: Outline) -> tuple[Geometry, PolySurface]:
    """Return what the table holds, and the drawing's surface."""
    least, largest = extremes_of(drawing)
    heights = part.heights_mm
    factors = factors_of(part, 2 * largest)
    design = prism_of(drawing, largest, heights, factors)
    target = design if cut is drawing else prism_of(cut, largest, heights, factors)
    first, last = (largest * factor for factor in factors)
    radius = _over_height((last - first) / part.height_mm, first, heights)
    ovality = _over_height(0.0, 2 * (largest - least) * max(factors), heights)
    ends = float(part.polygon.z_mm[0]), float(part.polygon.z_mm[1])
    return Geometry(radius, ovality, target, *heights, gauge_mm=ends), design


def shapes_key(part: PolygonPart) -> Hashable:
    """Return what the shapes of a part follow from."""
    runs = part.process.run_in_mm, part.process.run_out_mm
    return part.polygon.model_dump_json(), runs


def shapes_of(part: PolygonPart) -> tuple[Outline, Blended, Geometry, PolySurface]:
    """Return drawing, blended section, what the table holds, and the drawing's surface.

    They are recalled where a memory is open.
    """

    def made() -> tuple[Outline, Blended, Geometry, PolySurface]:
        drawing = outline_of(part.polygon)
        cut = blended(drawing, part.polygon.blend_um / growth_of(part.polygon, drawing))
        return drawing, cut, *surfaces_of(part, drawing, cut.outline)

    return recall(("polygon shapes", shapes_key(part)), made)


def _over_height(slope: float, first: float, heights_mm: tuple[float, float]) -> PPoly:
    return PPoly(np.array([[0.0], [0.0], [slope], [first]]), np.array(heights_mm))


def choose_channel(
    geometry: Geometry, tolerance_nm: float, cut: Blended
) -> tuple[Channel, Accuracy]:
    """Return the smallest u channel within a tolerance: over height a polygon is straight."""
    n_slices = int(slice_counts(geometry)[0])
    z_nm = np.linspace(*geometry.ends_mm, 3) * NM_PER_MM
    best: Accuracy | None = None
    for log2_knots in range(MIN_LOG2_KNOTS, MAX_LOG2_KNOTS + 1):
        if (n_slices << log2_knots) * KNOT_SIZE > MAX_CHANNEL_BYTES:
            break
        try:
            channel = u_channel(geometry, log2_knots, n_slices, is_balanced=False)
        except TooLargeError:
            continue
        found = measure_u(geometry, channel, z_nm)
        if found.value_nm <= tolerance_nm and max(found.shares) <= DERIVATIVE_SHARE:
            return channel, found
        if best is None or _rank(found) < _rank(best):
            best = found
    raise _unreachable(tolerance_nm, best, cut)


def _within(
    geometry: Geometry, tolerance_nm: float | None, cut: Blended
) -> tuple[float, Channel, Accuracy]:
    """Return the tolerance with the channel; the least one by default that the stroke allows."""
    if tolerance_nm is not None:
        return tolerance_nm, *choose_channel(geometry, tolerance_nm, cut)
    for default_nm in DEFAULT_TOLERANCES_NM[:-1]:
        with suppress(CamtoolsError):
            return default_nm, *choose_channel(geometry, default_nm, cut)
    return DEFAULT_TOLERANCES_NM[-1], *choose_channel(geometry, DEFAULT_TOLERANCES_NM[-1], cut)


def _rank(accuracy: Accuracy) -> tuple[float, float]:
    """Return what makes a table better: derivatives that are close enough, then the value."""
    return max(*accuracy.shares, DERIVATIVE_SHARE), accuracy.value_nm


def _unreachable(tolerance_nm: float, best: Accuracy | None, cut: Blended) -> CamtoolsError:
    """Return why no table follows the outline, and what would help."""
    problem = f"tolerance_nm = {tolerance_nm:g}: unreachable for u"
    wider = "allow more polygon.blend_um"
    if not cut.blends:
        wider = "give less eccentricity"
    elif cut.is_squeezed:
        wider = "give larger corner radii, between which there is room for wider blends"
    if best is None:
        return CamtoolsError([f"{problem}, nothing fits the format; {wider}"])
    share = max(best.shares)
    if share <= DERIVATIVE_SHARE:
        remedy = f"ask for at least {best.value_nm * 1.05:.2g} nm, or {wider}"
        return CamtoolsError([f"{problem}, best achievable is {best.value_nm:.3g} nm; {remedy}"])
    off = f"the largest table is off by {100 * share:.2g} % of the peak acceleration"
    return CamtoolsError([f"{problem}, {off}, {100 * DERIVATIVE_SHARE:g} % is allowed; {wider}"])


def generate_polygon(part: PolygonPart, tolerance_nm: float | None = None) -> GeneratedPolygon:
    """Return the smallest table of a polygon whose u and x keep a tolerance to the blended outline.

    By default it is 1 nm, or the 3 or 10 that a long stroke allows. Raises CamtoolsError: the
    numbers make no polygon, the tolerance is out of reach, or the machine is too weak.
    """
    passes = checked_passes(part, part.tool, tolerance_nm)
    drawing, cut, geometry, design = shapes_of(part)
    heel = check_heel(geometry, part.tool, part.process.direction)
    tip = tip_geometry(geometry, part.tool)
    key = "polygon u", shapes_key(part), part.tool.nose_radius_mm, tolerance_nm
    tolerance_nm, u, accuracy_u = recall(key, partial(_within, tip, tolerance_nm, cut))
    x = x_channel(tip, int(slice_counts(tip)[0]))
    accuracy_x = measure_x(tip, x)
    middle = middle_nm(tip, part.process.u_zero)
    u, x = moved(u, middle), moved(x, middle)
    bounds = u_bounds(u, max(accuracy_u.value_nm, accuracy_x.value_nm))
    _check_sharpness(part, drawing, cut, bounds.u2_peak_nm_per_rad2 / NM_PER_MM)
    last, channels = passes[-1], (with_bounds(u), with_bounds(x))
    table = table_of(last, last.process.spindle_rpm, bounds, channels)
    table = replace(table, passes=records_of(part.process.passes, passes))
    best = judge_passes(passes, table, partial(_judge, drawing))
    drift = drift_of(table.channels[0], 1 / NM_PER_MM, last.process.feed_mm)
    peaks = peaks_of(bounds)._replace(u_drift=drift, feed_mm=last.process.feed_mm)
    return GeneratedPolygon(
        *(part, drawing, cut, design, geometry, tolerance_nm, table),
        *(accuracy_u, accuracy_x, peaks, best, middle, heel),
    )


def _check_sharpness(part: PolygonPart, drawing: Outline, cut: Blended, peak_mm: float) -> None:
    """Refuse blends that bend more than a table can say, with the least one that would do."""
    most_mm = MAX_PEAK_NM / NM_PER_MM
    if peak_mm <= most_mm:
        return
    least = least_blend_um(drawing, bend_of(cut) * most_mm / peak_mm / _HINT_MARGIN)
    remedy = "give larger corner radii"
    if least is not None:
        remedy = f"allow {least * growth_of(part.polygon, drawing):.4g} um"
    given = f"polygon.blend_um = {part.polygon.blend_um:g}"
    problem = f"U would need {peak_mm:.6g} mm/rad2, a table holds {most_mm:.6g}"
    raise CamtoolsError([f"{given}: {problem}; {remedy}"])


def _judge(drawing: Outline, part: PolygonPart, table: Table) -> HighestSpeed:
    """Return the highest speed, or refuse; of joints with the least blend that would do."""
    return judged(part.process, part.machine.limits, table, partial(_advice, part, drawing))


def _advice(part: PolygonPart, drawing: Outline) -> list[str]:
    if not blended(drawing, _MOST_BLEND_UM).blends:
        return []
    allowed = part.machine.limits.u_acceleration_mm_s2
    omega = omega_rad_s(part.process.spindle_rpm)
    grown = growth_of(part.polygon, drawing)
    least = least_blend_um(drawing, allowed / omega**2 / _HINT_MARGIN / grown)
    if least is None:
        return ["polygon.blend_um: no blend helps, the outline itself is too sharp; turn slower"]
    problem = f"at this speed {least * grown:.4g} would do"
    return [f"polygon.blend_um = {part.polygon.blend_um:g}: {problem}; allow that much"]


def least_blend_um(drawing: Outline, most_mm: float) -> float | None:
    """Return the least deviation whose blends keep r'' below a limit [mm/rad^2], if there is.

    Both are those of the first section.
    """

    def is_enough(deviation_um: float) -> bool:
        return bend_of(blended(drawing, deviation_um)) <= most_mm

    low, high = 0.0, _MOST_BLEND_UM
    if not is_enough(high):
        return None
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        low, high = (low, middle) if is_enough(middle) else (middle, high)
        if high - low < _SHARP * high:
            break
    return high
