"""From a part to its table, checked against the exact geometry and the machine's limits.

A table through every point of a long scan plays the instrument's noise and needs several knots per
point; the format has 4096 per turn and the generator makes no channel above a mebibyte.

>>> WAVES[:3]
(120, 60, 30)

>>> from camtools.skirt.part.part_file import example_part
>>> result = generate(example_part(), tolerance_nm=1.0)
>>> result.accuracy_u.value_nm < 1.0, result.accuracy_x.value_nm < 1.0
(True, True)
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import partial

from camtools.base.cache import recall
from camtools.base.errors import CamtoolsError, GeometryError
from camtools.base.quantities import NM_PER_MM, NM_PER_UM
from camtools.cut.correction import Correction
from camtools.cut.feasibility import HighestSpeed, Peaks, drift_of, highest_speed, peaks_of
from camtools.cut.passes import checked_passes, judge_passes, records_of
from camtools.part.common import Tool
from camtools.skirt.geometry.corner import refuse_deviation
from camtools.skirt.geometry.outliers import REMEDY_OF_OUTLIERS, outliers
from camtools.skirt.geometry.run_in import corrected, with_run
from camtools.skirt.geometry.skirt_geometry import Geometry, keeping
from camtools.skirt.part.part_file import SkirtPart
from camtools.skirt.table.accuracy import (
    Accuracy,
    UnreachableError,
    choose_u,
    choose_x,
    measure_x,
)
from camtools.skirt.table.speed import SpeedTable, make_speed
from camtools.skirt.tool.exact_shape import geometry_of, law_key, way_key
from camtools.skirt.tool.nose import tip_geometry
from camtools.skirt.tool.program import StationGeometry, program_of
from camtools.skirt.tool.texture import check_texture
from camtools.skirt.tool.turning import (
    Heel,
    check_heel,
    judged,
    largest_share,
    middle_nm,
    moved,
    path_of,
    way_channel,
)
from camtools.table.channel import Channel
from camtools.table.evaluate import moving_bounds
from camtools.table.header import table_of, u_bounds, with_bounds
from camtools.table.image import Table

WAVES = (120, 60, 30, 15, 8, 4)  # numbers of harmonics that are tried


def refuse_scan(
    part: SkirtPart,
    geometry: Geometry,
    followed: Callable[[Geometry], Geometry],
    tolerance_nm: float,
    error: UnreachableError,
) -> None:
    """Refuse a measured part that has no table, with the most waves that make one.

    It names how far those are off the points, and does nothing for other parts. `followed` returns
    what the tool's tip follows of a geometry.
    """
    section = part.piston.section
    if geometry.measured is None:
        return
    scan = geometry.measured[1]
    factor = part.magnify.factor if part.magnify else 1.0
    most = min(section.harmonics or scan.angle_deg.size, (scan.angle_deg.size - 1) // 2 + 1)
    n_points = f"{scan.angle_deg.size} points a turn at {scan.z_mm.size} heights"
    kept = "all points" if section.harmonics is None else f"{section.harmonics} waves per turn"
    problem = f"no table through {kept} of the scan ({n_points}) keeps {tolerance_nm:g} nm"
    for waves in (number for number in WAVES if number < most):
        try:
            fewer = keeping(geometry, waves, factor, section.interpolation)
            channel, _ = choose_u(followed(fewer), tolerance_nm)
        except CamtoolsError:
            continue
        remedy = (
            f"set harmonics = {waves}: its surface is within {fewer.off_points_um:.3g} um of the "
            f"points and takes {channel.size} bytes"
        )
        raise GeometryError("piston.section.harmonics", problem, remedy) from error


DEFAULT_TOLERANCE_NM = 1.0
REFIT_TOLERANCE_NM = 5.0  # of u, where a spline replaces a corner
CORRECTED_NM = (3.0, 10.0, 30.0, 100.0, 300.0)  # the first that a correction allows
CORNER_SHARE = 0.5  # of the form error that a profile with corners may cost


@dataclass(frozen=True, eq=False)
class GeneratedSkirt:
    """A table and everything that is known about it."""

    part: SkirtPart
    geometry: Geometry
    tolerance_nm: float
    table: Table
    accuracy_u: Accuracy
    accuracy_x: Accuracy
    highest_speed: HighestSpeed
    heel: Heel
    speed: SpeedTable | None = None
    middle_nm: int = 0  # of the reduction, carried by X


def make_table(
    part: SkirtPart, u: Channel, x: Channel, error_nm: float, speed: SpeedTable | None = None
) -> Table:
    """Return the table of a part with its channels, bounds filled in."""
    bounds = u_bounds(u, error_nm)
    channels: tuple[Channel, ...] = (with_bounds(u), with_bounds(x))
    if speed is not None:
        bounds, channels = moving_bounds(bounds, speed.peaks), (*channels, speed.channel)
    table = table_of(part, part.process.spindle_rpm, bounds, channels)
    return replace(table, is_ring_helix=part.process.path == "ring-helix")


def refuse_corner(geometry: Geometry) -> None:
    """Refuse a composite section whose corner has no refit: no axis can follow it."""
    corner = geometry.corner
    if corner is None or corner.recipe is not None:
        return
    jump = float(corner.joint(corner.worst_mm).corner_mm_rad())
    angle_deg = float(corner.joint_deg(corner.worst_mm))
    problem = (
        f"is missing: the slope jumps by {jump:.4g} mm/rad at {angle_deg:g} degrees (height "
        f"{corner.worst_mm:.4g} mm), so U would need infinite acceleration"
    )
    raise GeometryError("piston.section.refit", problem, "add the table [piston.section.refit]")


def _u_of(
    part: SkirtPart, geometry: Geometry, tip: Geometry, tolerance_nm: float, most_nm: float = 0.0
) -> tuple[Channel, Accuracy]:
    """Return the u channel for the way of the tip; of a long scan with a remedy when none fits."""
    sieve = followed(part, geometry, Tool()) if part.tool.is_round else None
    try:
        return choose_u(tip, tolerance_nm, sieve, most_nm)
    except UnreachableError as error:
        way = partial(followed, part, tool=part.tool)
        refuse_scan(part, geometry, way, tolerance_nm, error)
        raise


def followed(part: SkirtPart, geometry: Geometry, tool: Tool) -> Geometry:
    """Return what the tip of a tool follows; of a part with lands over the station."""
    if part.piston.lands:
        return program_of(part, geometry, tool).geometry()
    return tip_geometry(with_run(geometry, *part.process.runs_mm), tool)


def _x_of(tip: Geometry, tolerance_nm: float, most_nm: float) -> tuple[Channel, Accuracy]:
    """Return the x channel for the path of the tip; a program has a knot for each turn."""
    if not isinstance(tip, StationGeometry):
        return choose_x(tip, tolerance_nm, most_nm)
    channel = tip.program.x_channel
    accuracy = measure_x(tip, channel)
    if accuracy.value_nm > max(tolerance_nm, most_nm):
        raise UnreachableError("x", tolerance_nm, accuracy.value_nm)
    return channel, accuracy


def _within(
    part: SkirtPart, geometry: Geometry, tip: Geometry, tolerance_nm: float | None, most_nm: float
) -> tuple[float, tuple[Channel, Accuracy]]:
    """Return the tolerance of u with its channel; of a correction the least one that it allows."""
    default_nm = DEFAULT_TOLERANCE_NM if geometry.corner is None else REFIT_TOLERANCE_NM
    default_nm = tolerance_nm or default_nm
    if tolerance_nm is None and geometry.correction is not None:
        for wider_nm in CORRECTED_NM[:-1]:
            if wider_nm >= default_nm:
                with suppress(UnreachableError):
                    return wider_nm, _u_of(part, geometry, tip, wider_nm)
        default_nm = CORRECTED_NM[-1]
    is_drawn = geometry.measured is None and geometry.correction is None
    return default_nm, _u_of(part, geometry, tip, default_nm, most_nm if is_drawn else 0.0)


def _geometry_of(part: SkirtPart, passes: list[SkirtPart]) -> Geometry:
    """Return the exact geometry of a part, or refuse what Z or U cannot follow at any speed."""
    if part.process.path == "stepped":  # a controller plays helices and ring-helices
        problem = "is only for analyse and mkgcode; a controller cannot play it"
        remedy = 'give --axes cxzu to mkgcode, or set path = "ring-helix" or "helix"'
        raise GeometryError("process.path", problem, remedy)
    geometry = geometry_of(part)
    low_mm, high_mm = geometry.skirt_mm
    for pass_part in passes:
        path_of(pass_part, low_mm - part.process.run_in_mm, high_mm + part.process.run_out_mm)
    refuse_corner(geometry)
    if geometry.corner is not None and part.piston.section.refit is not None:
        refuse_deviation(geometry.corner, part.piston.section.refit)
    return geometry


@contextmanager
def naming_outliers(geometry: Geometry) -> Iterator[None]:
    """Add a line to a refusal of a measured part with a point that is off its neighbours."""
    try:
        yield
    except CamtoolsError as error:
        found = outliers(geometry.measured[0]) if geometry.measured is not None else []
        if found:
            line = f"piston.section.csv: {found[0].words}; {REMEDY_OF_OUTLIERS}"
            error.lines = [line, *error.lines]
            error.args = ("\n".join(error.lines),)
        raise


def generate(
    part: SkirtPart, tolerance_nm: float | None = None, correction: Correction | None = None
) -> GeneratedSkirt:
    """Return the smallest table of a part that keeps the tolerance.

    The tolerance is the largest error of u and of x anywhere on the skirt [nm], the firmware's
    rounding included; by default 1 nm, for u of a refitted composite section 5 nm, of a corrected
    drawing the first of 3, 10, 30, 100 and 300 nm that can be reached, and of a profile or an
    ovality with corners or steps of curvature what can be reached, at most half of the accepted
    form error. A correction by a gauged part is taken off the drawing. Raises CamtoolsError: the
    shape is impossible, the tolerance is out of reach, or the machine is too weak.
    """
    passes = checked_passes(part, part.tool, tolerance_nm)
    check_texture(passes[-1])
    geometry = _geometry_of(part, passes)
    if correction is not None:
        geometry = corrected(geometry, correction)
    with naming_outliers(geometry):
        return _generated(part, geometry, passes, tolerance_nm)


def _generated(
    part: SkirtPart, geometry: Geometry, passes: list[SkirtPart], tolerance_nm: float | None
) -> GeneratedSkirt:
    """Return the table of a geometry, see `generate`."""
    process, correction = part.process, geometry.correction
    heel = check_heel(geometry, part.tool, process.direction)
    tip = followed(part, geometry, part.tool)
    most_nm = 0.0 if tolerance_nm else part.tightest_um * NM_PER_UM * CORNER_SHARE
    key = way_key(part, tolerance_nm), correction
    tolerance_u_nm, (u, accuracy_u) = recall(
        ("skirt u", key), lambda: _within(part, geometry, tip, tolerance_nm, most_nm)
    )
    x, accuracy_x = recall(
        ("skirt x", key), lambda: _x_of(tip, tolerance_nm or DEFAULT_TOLERANCE_NM, most_nm)
    )
    middle = middle_nm(tip, process.u_zero)
    u, x = moved(u, middle), moved(x, middle)
    error_nm = max(accuracy_u.value_nm, accuracy_x.value_nm)
    speed = None
    if process.mode != "uniform":
        uniform = highest_speed(peaks_of(u_bounds(u, error_nm)), part.machine.limits)
        law = "skirt law", law_key(part, tolerance_nm), correction
        air = with_run(geometry, *process.runs_mm)
        speed = recall(law, lambda: make_speed(part, air, u, uniform.rpm))
    table = make_table(passes[-1], u, x, error_nm, speed)
    if isinstance(tip, StationGeometry):
        way, feed_nm = tip.program.way_channel, tip.program.feed_nm
        channels = (*table.channels, way)
        table = replace(table, feed_nm=feed_nm, channels=channels, has_stations=True)
        best = _judge(geometry, part, table)
    else:
        table = with_passes(table, part, passes)
        best = judge_passes(passes, table, partial(_judge, geometry))
    return GeneratedSkirt(
        part, geometry, tolerance_u_nm, table, accuracy_u, accuracy_x, best, heel, speed, middle
    )


def with_passes(table: Table, part: SkirtPart, passes: list[SkirtPart]) -> Table:
    """Return a table with the records of its passes and the way of its feed."""
    law = part.process.feed_law
    if law is not None:
        ends = table.z_first_nm, table.z_last_nm
        way = recall(("skirt way", law.model_dump_json(), ends), lambda: way_channel(law, ends))
        table = replace(table, channels=(*table.channels, way))
    return replace(table, passes=records_of(part.process.passes, passes))


def peaks_of_table(table: Table, speed: SpeedTable | None) -> Peaks:
    """Return what the axes need of the table of a skirt."""
    ratio = speed.peaks.ratio if speed else 1.0
    along_mm = table.feed_nm / NM_PER_MM
    feed_mm = along_mm * largest_share(table.way)
    along_mm = along_mm if table.has_stations else feed_mm
    drift = drift_of(table.channels[0], 1 / NM_PER_MM, along_mm)
    return peaks_of(table.bounds, ratio)._replace(u_drift=drift.at(ratio), feed_mm=feed_mm)


def _judge(geometry: Geometry, part: SkirtPart, table: Table) -> HighestSpeed:
    """Return the highest speed, or refuse; of a corner with what another refit would need."""

    def other_refit() -> list[str]:
        if geometry.corner is None:
            return []
        best = min(geometry.corner.candidates, key=lambda candidate: candidate.acceleration_mm_s2)
        return [
            "piston.section.refit.delete: the corner decides; of all deletions "
            f"[{best.s1}, {best.s2}] needs least, {best.acceleration_mm_s2:.6g} mm/s2 at this "
            "speed; trim less or turn slower"
        ]

    return judged(part.process, part.machine.limits, table, other_refit)
