"""From a polygon to its table, checked against the outline and the machine's limits.

>>> from camtools.polygon.part import example_polygon
>>> made = generate_polygon(example_polygon())
>>> made.accuracy_u.value_nm < 1.0, made.blended.deviation_um
(True, 0.0)
"""

from __future__ import annotations

from collections.abc import Hashable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.interpolate import PPoly

from camtools.base.cache import recall
from camtools.base.errors import CamtoolsError
from camtools.base.quantities import NM_PER_MM, omega_rad_s
from camtools.cut.feasibility import HighestSpeed, Peaks, drift_of, peaks_of
from camtools.cut.passes import checked_passes, judge_passes, records_of
from camtools.cut.verdict import check_table
from camtools.polygon.blend import Blended, bend_of, blended
from camtools.polygon.outline import Outline, extremes_of, prism_of
from camtools.polygon.part import PolygonPart, PolygonSection
from camtools.polygon.shapes import cornered, p3g, p4c, regular
from camtools.skirt.geometry.poly_surface import PolySurface
from camtools.skirt.geometry.skirt_geometry import Geometry
from camtools.skirt.table.accuracy import Accuracy, measure_u, measure_x, u_channel, x_channel
from camtools.skirt.table.search import DERIVATIVE_SHARE, slice_counts
from camtools.skirt.tool.heel import Heel, check_heel
from camtools.skirt.tool.nose import tip_geometry
from camtools.skirt.tool.turning import middle_nm, moved, with_mean
from camtools.table.channel import MAX_CHANNEL_BYTES, MAX_LOG2_KNOTS, MIN_LOG2_KNOTS, Channel
from camtools.table.header import MAX_PEAK_NM, table_of, u_bounds
from camtools.table.image import Table
from camtools.table.quantise import TooLargeError, with_bounds
from camtools.table.records import KNOT_SIZE

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
    z_nm = np.linspace(geometry.z_first_mm, geometry.z_last_mm, 3) * NM_PER_MM
    best: Accuracy | None = None
    for log2_knots in range(MIN_LOG2_KNOTS, MAX_LOG2_KNOTS + 1):
        if (n_slices << log2_knots) * KNOT_SIZE > MAX_CHANNEL_BYTES:
            break
        try:
            channel = u_channel(geometry, log2_knots, n_slices, is_balanced=False)
        except TooLargeError:
            continue
        found = measure_u(geometry, channel, z_nm)
        if found.value_nm <= tolerance_nm and _share(found) <= DERIVATIVE_SHARE:
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


def _share(one: Accuracy) -> float:
    return max(one.first_share, one.second_share)


def _rank(one: Accuracy) -> tuple[float, float]:
    """Return what makes a table better: derivatives that are close enough, then the value."""
    return max(_share(one), DERIVATIVE_SHARE), one.value_nm


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
    share = _share(best)
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
    try:
        return check_table(table, part.machine.limits)
    except CamtoolsError as error:
        lines = with_mean(error.lines, part.process.u_zero, table.bounds)
        if any("u_acceleration" in line for line in lines):
            lines += _advice(part, drawing)
        raise CamtoolsError(lines) from error


def _advice(part: PolygonPart, drawing: Outline) -> list[str]:
    """Return which blend would keep the acceleration within its limit, if any does."""
    if not blended(drawing, _MOST_BLEND_UM).blends:
        return []
    allowed = part.machine.limits.u_acceleration_mm_s2
    omega = omega_rad_s(part.process.spindle_rpm)
    grown = growth_of(part.polygon, drawing)
    least = least_blend_um(drawing, allowed / omega**2 / _HINT_MARGIN / grown)
    if least is None:
        return ["polygon.blend_um: no blend helps, the outline itself is too sharp; turn slower"]
    given = part.polygon.blend_um
    return [
        f"polygon.blend_um = {given:g}: at this speed {least * grown:.4g} would do; allow that much"
    ]


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
