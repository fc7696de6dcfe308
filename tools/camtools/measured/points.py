r"""Gauged points: their text, and their heights as traces or as bands along a helix.

The header names quantities and units. A deviation above 0 is metal left standing.

>>> rows = "".join(f"{angle};0;0,{angle % 7}\n" for angle in range(0, 360, 5))
>>> found = parse_points("angle_deg;height_mm;deviation_um\n" + rows, "trace.csv")
>>> found.turn.size, found.deviation_um[:3].tolist()
(72, [0.0, 0.5, 0.3])

>>> turn, z_mm = np.tile(np.arange(72) / 72, 5), np.repeat(np.linspace(0, 40, 5), 72)
>>> found = by_height(GaugedPoints(turn, z_mm, np.zeros(360)))
>>> found.z_mm.tolist(), found.most_order
([0.0, 10.0, 20.0, 30.0, 40.0], 16)
"""

from typing import NamedTuple

import numpy as np

from camtools.base.errors import CamtoolsError, InputError
from camtools.base.number_table import NumberTable, Units
from camtools.base.quantities import Bools, Floats, Ints
from camtools.cut.correction import nodes_of
from camtools.part.model import MAX_HEIGHT_MM

ANGLES = {"turn": 1.0, "angle_turn": 1.0, "angle_deg": 1 / 360}  # turns per unit
HEIGHTS = {"z_mm": 1.0, "height_mm": 1.0, "z_um": 1e-3, "height_um": 1e-3}  # mm per unit
DEVIATIONS = {  # um per unit
    "deviation_um": 1.0,
    "deviation_mm": 1e3,
    "deviation_nm": 1e-3,
    "error_um": 1.0,
    "error_nm": 1e-3,
}
RADIUS = "radius_mm"
HEADER = "angle_deg,height_mm,deviation_um"
MAX_POINTS = 1_000_000
MAX_DEVIATION_UM = 15_000.0
MAX_BYTES = 200 * MAX_POINTS


class GaugedPoints(NamedTuple):
    """Gauged points, each of shape (n,)."""

    turn: Floats  # drawing's angle, 0 .. 1
    z_mm: Floats
    deviation_um: Floats  # from the drawing, above 0: metal left standing
    radius_mm: Floats | None = None  # where the file has it

    def pick(self, rows: Bools) -> "GaugedPoints":
        """Return some of the points."""
        return GaugedPoints(*(column[rows] for column in self if column is not None))


def parse_points(text: str, file: str) -> GaugedPoints:
    """Return the points of a text, or refuse it with the line."""
    table = NumberTable(text, file, MAX_POINTS)
    kinds: dict[str, Units] = {"angle": ANGLES, "height": HEIGHTS, "deviation": DEVIATIONS}
    if RADIUS in table.names:
        kinds["radius"] = {RADIUS: 1.0}
    columns = table.columns(kinds, HEADER)
    if not table.rows:
        raise InputError(file, "", None, "has no point", "gauge the part")
    values = table.values(columns)
    _check_ranges(values, table)
    values[0] = np.mod(values[0], 1.0)
    return GaugedPoints(*values)


def _check_ranges(values: Floats, table: NumberTable) -> None:
    """Refuse the first point that is no place of a part or no deviation."""
    turn, z_mm, deviation_um = values[:3]
    is_good = (turn >= 0) & (turn <= 1) & (np.abs(z_mm) <= MAX_HEIGHT_MM)
    is_good &= np.abs(deviation_um) <= MAX_DEVIATION_UM
    if is_good.all():
        return
    problem = (
        f"beyond one turn, a height of {MAX_HEIGHT_MM:g} mm or a deviation of "
        f"{MAX_DEVIATION_UM / 1000:g} mm"
    )
    remedy = "give the drawing's angle and the deviation from the drawing in the header's units"
    raise table.refusal(int(np.argmin(is_good)), problem, remedy)


DEFAULT_ORDER = 16
MIN_HEIGHTS = 3
_MAX_TRACES = 128
_APART_MM, _LEVEL_MM = 2e-3, 0.02  # traces are so far apart, and each of them is so level
_PER_ORDER = 4  # points of a height per wave that is asked of it by default
_OVER = 1.5  # points per unknown
_GAP_WAVES = 0.5  # of the highest order, that may lack points


class Heights(NamedTuple):
    """Heights with enough points to fit their waves, rising, and the highest order fitted."""

    z_mm: Floats
    rows: list[Ints]  # of the points of each
    most_order: int
    n_left_out: int  # heights with too few points, or with a gap


def widest_gap(turn: Floats) -> float:
    """Return the widest angle without a point [turn]."""
    rising = np.sort(turn)
    return float(np.diff(rising, append=rising[0] + 1).max())


def _suffices(turn: Floats, order: int) -> bool:
    """Return whether points at these angles suffice to fit waves up to an order."""
    return turn.size >= _OVER * (2 * order + 1) and widest_gap(turn) * order <= _GAP_WAVES


def _traces(z_mm: Floats) -> list[Ints] | None:
    """Return the rows of each trace, nothing where the heights run through."""
    order = np.argsort(z_mm, kind="stable")
    groups = np.split(order, np.flatnonzero(np.diff(z_mm[order]) > _APART_MM) + 1)
    is_level = all(float(np.ptp(z_mm[group])) <= _LEVEL_MM for group in groups)
    return groups if is_level and len(groups) <= _MAX_TRACES else None


def _bands(points: GaugedPoints, order: int) -> list[Ints]:
    """Return the rows of bands as narrow as a fit allows, narrower at the ends."""
    rising = np.argsort(points.z_mm, kind="stable")
    ends_mm = float(points.z_mm[rising[0]]), float(points.z_mm[rising[-1]])
    inner_mm = nodes_of(ends_mm)[1:-1]
    found: list[Ints] = []
    rest = np.empty(0, dtype=np.int64)
    for group in np.split(rising, np.searchsorted(points.z_mm[rising], inner_mm)):
        rest = np.concatenate([rest, group])
        if rest.size and _suffices(points.turn[rest], order):
            found.append(rest)
            rest = np.empty(0, dtype=np.int64)
    if found and rest.size:
        found[-1] = np.concatenate([found[-1], rest])
    return found or [rest]


def by_height(points: GaugedPoints, most_order: int | None = None) -> Heights:
    """Return the points by height, for waves up to an order: by default 16, or less for few angles.

    Raises CamtoolsError: too few heights have enough points all round.
    """
    groups = _traces(points.z_mm)
    order = most_order or DEFAULT_ORDER
    if groups is None:
        groups = _bands(points, order)
    elif most_order is None:
        order = max(1, min(order, int(np.median([group.size for group in groups])) // _PER_ORDER))
    good = [group for group in groups if _suffices(points.turn[group], order)]
    if len(good) < MIN_HEIGHTS:
        raise CamtoolsError([_too_few(points, groups, len(good), order, most_order)])
    z_mm = np.array([points.z_mm[group].mean() for group in good])
    return Heights(z_mm, good, order, len(groups) - len(good))


def _too_few(
    points: GaugedPoints, groups: list[Ints], n_good: int, order: int, asked: int | None
) -> str:
    """Return why heights do not suffice, with the numbers of the best one."""
    best = max(groups, key=lambda group: group.size)
    gap_deg = 360 * widest_gap(points.turn[best])
    needed = int(np.ceil(_OVER * (2 * order + 1)))
    option = "--measured" if asked is None else f"--keep-harmonics {asked}"
    problem = (
        f"{n_good} of {len(groups)} heights have enough points all round, {MIN_HEIGHTS} are "
        f"needed; harmonics up to {order} need {needed} points and no gap above "
        f"{360 * _GAP_WAVES / order:.3g} degrees, the best height has {best.size} and a gap of "
        f"{gap_deg:.3g} degrees"
    )
    remedy = "gauge more angles and heights" + ("" if asked is None else ", or keep fewer")
    return f"{option}: {problem}; {remedy}"
