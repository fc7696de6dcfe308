"""A table as text for other controllers: points with velocity and acceleration, or value alone.

A cam of kind XYVA of CODESYS is a polynomial of degree five between points of master position X,
slave position Y, velocity V = dY/dX and acceleration A: just what the knots of a table are. Drives
of other makers read two columns, angle and value, some within lines of their own (`maker_forms`).
Angles are the drawing's, in degrees.

>>> name_of_height(12.5), name_of_height(-3.0)
('z12.5', 'z-3')
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import DEG_PER_RAD, DEG_PER_TURN, NM_PER_MM, Floats
from camtools.table.channel import (
    DEG_PER_UNIT,
    KIND_CONTACT,
    KIND_SPEED,
    KIND_SWING,
    KIND_U,
    KIND_X,
    RATIO_ONE,
    Channel,
    angle_in_sense,
    in_sense,
    segment_coefficients,
)
from camtools.table.evaluate import knot_interval, locate, power_rows
from camtools.table.image import Table
from camtools.table.maker_forms import FORMS as MAKER_FORMS
from camtools.table.maker_forms import WRITTEN

FORMS = ("xyva", "text", *WRITTEN)
_TEXT_POINTS = 360


class _Quantity(NamedTuple):
    name: str
    unit: str
    scale: float  # of the channel's unit in this one


_QUANTITIES = {
    KIND_U: _Quantity("u", "mm", 1 / NM_PER_MM),
    KIND_SPEED: _Quantity("speed", "ratio", 1 / RATIO_ONE),
    KIND_SWING: _Quantity("swing", "deg", DEG_PER_UNIT),
    KIND_CONTACT: _Quantity("contact", "deg", DEG_PER_UNIT),
}
_LIFT = _Quantity("lift", "mm", -1 / NM_PER_MM)  # of lobes: the follower moves outwards


class Export(NamedTuple):
    """What is to be written."""

    form: str  # one of FORMS
    heights_mm: tuple[float, ...] = ()  # a file for each; without any, one file for all slices
    n_points: int | None = None  # per turn; by default the knots of xyva, text per degree

    @property
    def per_turn(self) -> int:
        """Return the points per turn, 0 for the knots."""
        usual = 0 if self.form == "xyva" else _TEXT_POINTS
        return usual if self.n_points is None else self.n_points


class ExportedPoints(NamedTuple):
    """Points of one turn, both ends included, each of shape (n,)."""

    x_deg: Floats
    y: Floats
    v: Floats  # dy/dx, per degree
    a: Floats  # per degree^2


def quantity_of(table: Table, channel: Channel) -> _Quantity:
    """Return what a channel holds: of lobes u is a lift."""
    is_lift = channel.kind == KIND_U and table.angle is not None
    return _LIFT if is_lift else _QUANTITIES[channel.kind]


def _at_height(table: Table, drawn: Channel, z_mm: float) -> tuple[Floats, float]:
    """Return the knots that are played at a height, and by how many turns they come later."""
    z_nm = z_mm * NM_PER_MM
    if not drawn.has_patterns:
        i_slice, weight = locate(drawn, np.array([z_nm]))
        i, w = int(i_slice[0]), float(weight[0])
        return (1 - w) * drawn.knots[i] + w * drawn.knots[i + 1], 0.0
    for lobe in table.lobes:
        if lobe.z_first_nm <= z_nm <= lobe.z_last_nm:
            knots = np.asarray(drawn.knots[lobe.pattern], dtype=np.float64)
            return knots, angle_in_sense(lobe.phase_q32 / 2**32, table.direction)
    problem = f"--export-height {z_mm:g}: lies between two lobes"
    raise CamtoolsError([f"{problem}; give a height inside of a lobe"])


def _sampled(
    table: Table, channel: Channel, knots: Floats, shift: float, n_points: int
) -> ExportedPoints:
    """Return points of a pattern of knots that is turned by a share of a turn."""
    n_knots = knots.shape[0]
    total = n_knots << channel.log2_repeat
    n = n_points or total
    first = 0.0 if n_points else (shift * total) % 1.0 / total
    turn = first + np.arange(n + 1) / n
    place = np.mod((turn - shift) * total, n_knots)
    if not n_points:
        place = np.mod(np.rint(place), n_knots)
    segment = place.astype(np.int64)
    quintics = segment_coefficients(knots, periodic=True)[segment]
    value, v, a = np.einsum("nc,dcn->dn", quintics, power_rows(place - segment))
    scale, h_deg = quantity_of(table, channel).scale, knot_interval(channel) * DEG_PER_RAD
    lsb = channel.lsb * scale
    y = channel.value_offset * scale + value * lsb
    x_deg = DEG_PER_TURN * first + DEG_PER_TURN * np.arange(n + 1) / n
    return ExportedPoints(x_deg, y, v * (lsb / h_deg), a * (lsb / h_deg**2))


def points_of(table: Table, channel: Channel, z_mm: float, n_points: int = 0) -> ExportedPoints:
    """Return a channel over the drawing's angle at a height; 0 points per turn: its knots."""
    drawn = in_sense(channel, table.direction)
    return _sampled(table, drawn, *_at_height(table, drawn, z_mm), n_points)


def name_of_height(z_mm: float) -> str:
    """Return a height as part of a file's name."""
    return f"z{z_mm:.9g}"


def _rows(columns: Sequence[Floats], before: str, separator: str) -> Iterator[str]:
    for row in zip(*(column.tolist() for column in columns), strict=True):
        yield before + separator.join(repr(value) for value in row)


def _header(quantity: _Quantity, form: str, *, with_height: bool) -> list[str]:
    unit = quantity.unit
    names = ["X_deg", f"Y_{unit}", f"V_{unit}_per_deg", f"A_{unit}_per_deg2"]
    return [*(["Z_mm"] if with_height else []), *(names if form == "xyva" else names[:2])]


def _one_turn(quantity: _Quantity, points: ExportedPoints, form: str) -> str:
    if form in WRITTEN:
        return MAKER_FORMS[form].written(points.x_deg.tolist(), points.y.tolist())
    if form == "text":
        return "\n".join(_rows(points[:2], "", " ")) + "\n"
    header = ";".join(_header(quantity, form, with_height=False))
    return "\n".join([header, *_rows(points, "", ";")]) + "\n"


def _all_heights(table: Table, channel: Channel, export: Export) -> str:
    form = export.form
    heights = np.linspace(channel.z_first_nm, channel.z_last_nm, channel.n_slices) / NM_PER_MM
    lines = [";".join(_header(quantity_of(table, channel), form, with_height=True))]
    for z_mm in heights.tolist():
        points = points_of(table, channel, z_mm, export.per_turn)
        lines += _rows(points if form == "xyva" else points[:2], f"{z_mm!r};", ";")
    return "\n".join(lines) + "\n"


def _over_height(table: Table, form: str) -> str:
    """Return X over height: knots of the long half axis, or of the centre of a follower."""
    x = table.channel(KIND_X)
    z_nm = np.linspace(x.z_first_nm, x.z_last_nm, x.n_slices)
    h_mm, lsb_mm = knot_interval(x) / NM_PER_MM, x.lsb / NM_PER_MM
    knots = x.knots[:, 0].astype(np.float64)
    y = x.value_offset / NM_PER_MM + knots[:, 0] * lsb_mm
    columns = z_nm / NM_PER_MM, y, knots[:, 1] * (lsb_mm / h_mm), knots[:, 2] * 2 * lsb_mm / h_mm**2
    names = ["Z_mm", "X_mm", "V_mm_per_mm", "A_mm_per_mm2"]
    n = 4 if form == "xyva" else 2
    return "\n".join([";".join(names[:n]), *_rows(columns[:n], "", ";")]) + "\n"


def export_files(table: Table, export: Export) -> dict[str, bytes]:
    """Return the files of an export by name, or refuse a height outside of the table."""
    if table.has_stations and table.angle is None:
        problem = "the table of a part with [[piston.land]] is over the turns, not over heights"
        raise CamtoolsError([f"--export: {problem}; export skirt and lands as parts of their own"])
    low, high = table.z_first_nm / NM_PER_MM, table.z_last_nm / NM_PER_MM
    for z_mm in export.heights_mm:
        if not low <= z_mm <= high:
            problem = f"--export-height {z_mm:g}: outside of the table, {low:g} .. {high:g} mm"
            raise CamtoolsError([f"{problem}; give a height of the part"])
    start, form = table.part_name, export.form
    if form in WRITTEN and table.angle is None and not export.heights_mm:
        problem = f"--export {form}: a file holds one section"
        raise CamtoolsError([f"{problem}; give its height, --export-height MM"])
    over_height = "xyva" if form == "xyva" else "text"
    files = {f"{start}_x_{over_height}.csv": _over_height(table, over_height)}
    for channel in table.channels:
        if channel.kind in _QUANTITIES:
            name = f"{start}_{quantity_of(table, channel).name}"
            files |= dict(_channel_files(table, channel, export, name))
    return {name: text.encode("ascii") for name, text in files.items()}


def _channel_files(
    table: Table, channel: Channel, export: Export, name: str
) -> Iterator[tuple[str, str]]:
    form, quantity, per_turn = export.form, quantity_of(table, channel), export.per_turn
    end = f"{form}.csv" if form in WRITTEN else f"{form}.txt"
    for z_mm in export.heights_mm:
        points = points_of(table, channel, z_mm, per_turn)
        yield f"{name}_{name_of_height(z_mm)}_{end}", _one_turn(quantity, points, form)
    if export.heights_mm:
        return
    if table.angle is None:
        yield f"{name}_{form}.csv", _all_heights(table, channel, export)
        return
    for i in sorted({lobe.pattern for lobe in table.lobes} or {0}):  # a lobe alone has one
        drawn = in_sense(channel, table.direction)
        knots = np.asarray(drawn.knots[i], dtype=np.float64)
        points = _sampled(table, drawn, knots, 0.0, per_turn)
        yield f"{name}_profile{i + 1}_{end}", _one_turn(quantity, points, form)
