r"""The text of a gauged surface: angle, height, deviation; of the simulator or of an instrument.

The header names quantities and units. A deviation above 0 is metal left standing.

>>> rows = "".join(f"{angle};0;0,{angle % 7}\n" for angle in range(0, 360, 5))
>>> found = parse_points("angle_deg;height_mm;deviation_um\n" + rows, "trace.csv")
>>> found.turn.size, found.deviation_um[:3].tolist()
(72, [0.0, 0.5, 0.3])
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from camtools.base.columns import Columns
from camtools.base.errors import InputError, numbers_shown
from camtools.base.quantities import Floats

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
MAX_HEIGHT_MM = 1000.0
MAX_BYTES = 200 * MAX_POINTS


class GaugedPoints(NamedTuple):
    """Gauged points, each of shape (n,)."""

    turn: Floats  # drawing's angle, 0 .. 1
    z_mm: Floats
    deviation_um: Floats  # from the drawing, above 0: metal left standing
    radius_mm: Floats | None = None  # where the file has it


class _Place(NamedTuple):
    """Where a quantity stands, and what its unit is worth."""

    column: int
    per_unit: float


def _find(columns: Columns, units: dict[str, float]) -> _Place | None:
    names = [name.casefold() for name in columns.names]  # instruments write some in capitals
    found = [name for name in names if name in units]
    return _Place(names.index(found[0]), units[found[0]]) if len(found) == 1 else None


def _places(columns: Columns, file: str) -> list[_Place]:
    """Return where angle, height and deviation stand, and the radius where there is one."""
    kinds = {"angle": ANGLES, "height": HEIGHTS, "deviation": DEVIATIONS}
    places = []
    for what, units in kinds.items():
        place = _find(columns, units)
        if place is None:
            problem = f"needs one column of the {what}: {', '.join(units)}"
            remedy = f'write a header as "{HEADER}", with , or ; or blanks between'
            raise InputError(file, "line 1", None, problem, remedy)
        places.append(place)
    radius = _find(columns, {RADIUS: 1.0})
    return places if radius is None else [*places, radius]


def parse_points(text: str, file: str) -> GaugedPoints:
    """Return the points of a text.

    Raises
    ------
    InputError
        With the line: wrong header, no numbers, numbers out of range, too many lines.
    """
    lines = text.splitlines()
    header = lines[0].strip() if lines else ""
    columns = Columns(header)
    places = _places(columns, file)
    if len(lines) > MAX_POINTS:
        problem = f"has {len(lines)} lines, at most {MAX_POINTS} are read"
        raise InputError(file, "", None, problem, "leave out points or heights")
    order, rows, numbers = [place.column for place in places], [], []
    for number, line in enumerate(lines[1:], start=2):
        if not line.strip():
            continue
        try:
            rows.append(columns.numbers(line, order))
        except (ValueError, IndexError) as error:
            problem, remedy = "no numbers", "write the line as the header says"
            shown = numbers_shown(line[:60])
            raise InputError(file, f"line {number}", shown, problem, remedy) from error
        numbers.append(number)
    if not rows:
        raise InputError(file, "", None, "has no point", "gauge the part")
    values = np.array(rows).T * np.array([[place.per_unit] for place in places])
    _check_ranges(values, numbers, lines, file)
    values[0] = np.mod(values[0], 1.0)
    return GaugedPoints(*values)


def _check_ranges(values: Floats, numbers: list[int], lines: list[str], file: str) -> None:
    """Refuse the first point that is no place of a part or no deviation."""
    turn, z_mm, deviation_um = values[:3]
    with np.errstate(invalid="ignore"):
        is_good = (turn >= 0) & (turn <= 1) & (np.abs(z_mm) <= MAX_HEIGHT_MM)
        is_good &= (np.abs(deviation_um) <= MAX_DEVIATION_UM) & np.isfinite(values).all(axis=0)
    if is_good.all():
        return
    worst = int(np.argmin(is_good))
    line = numbers[worst]
    problem = (
        f"beyond one turn, a height of {MAX_HEIGHT_MM:g} mm or a deviation of "
        f"{MAX_DEVIATION_UM / 1000:g} mm"
    )
    if not np.isfinite(values[:, worst]).all():
        problem = "no finite numbers"
    remedy = "give the drawing's angle and the deviation from the drawing in the header's units"
    raise InputError(file, f"line {line}", lines[line - 1][:60], problem, remedy)
