r"""A recording of another instrument: time, command or force, and position in columns with units.

>>> rows = "".join(f"{i * 1e-3},{i % 7},{i % 5}\n" for i in range(4096))
>>> found = parse_record("time_s,force_n,position_um\n" + rows, "scope.csv")
>>> found.command, round(found.rate_hz), found.u.size, float(found.y[4])
('force_n', 1000, 4096, 4e-06)
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from camtools.base.errors import InputError, numbers_shown
from camtools.base.quantities import Floats
from camtools.base.text import NumberLines

TIMES = {"time_s": 1.0, "time_ms": 1e-3, "time_us": 1e-6}  # seconds per unit
LENGTHS = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "nm": 1e-9}  # metres per unit
COMMANDS = {f"command_{unit}": metres for unit, metres in LENGTHS.items()} | {"command_v": 1.0}
FORCES = {"force_n": 1.0, "force_kn": 1e3}  # newtons per unit
POSITIONS = {f"position_{unit}": metres for unit, metres in LENGTHS.items()}
Units = Mapping[str, float]
HEADER = "time_s,command_um,position_um"
MIN_ROWS, MAX_ROWS = 1024, 2_000_000
MAX_BYTES = 200 * MAX_ROWS
_UNEVEN = 0.01  # of a step, that a time may be off


class ForeignRecord(NamedTuple):
    """What another instrument recorded at even times."""

    rate_hz: float
    u: Floats  # shape (n,); command [m] or [V], or force [N]
    y: Floats  # shape (n,); position [m]
    command: str  # name of its column


def _column(
    columns: NumberLines, units: Units, what: str, file: str, header: str
) -> tuple[int, float]:
    """Return where a quantity is, and what its unit is worth."""
    names = [name.strip('"').casefold() for name in columns.names]
    found = [name for name in names if name in units]
    if len(found) == 1:
        return names.index(found[0]), units[found[0]]
    problem = (
        f"needs one column of the {what}: {', '.join(units)}; has {', '.join(found) or 'none'}"
    )
    remedy = "rename all but one of them" if found else f'write a header as "{header}"'
    raise InputError(file, "line 1", None, problem, remedy)


def _rows(lines: list[str], columns: NumberLines, places: list[int], file: str) -> Floats:
    """Return the numbers of all lines, shape (columns, n)."""
    rows = []
    for number, line in enumerate(lines[1:], start=2):
        try:
            row = columns.numbers(line, places)
            if not np.isfinite(row).all():
                raise ValueError(line)
        except (ValueError, IndexError) as error:
            problem = f"not {len(places)} finite numbers where the header names them"
            remedy = "correct or delete the line and all before it"
            shown = numbers_shown(line[:60])
            raise InputError(file, f"line {number}", shown, problem, remedy) from error
        rows.append(row)
    return np.array(rows, dtype=np.float64).T


def _rate_hz(time_s: Floats, file: str) -> float:
    step_s = float(time_s[-1] - time_s[0]) / (time_s.size - 1)
    even_s = time_s[0] + step_s * np.arange(time_s.size)
    wrong = np.abs(np.diff(time_s) - step_s) > max(_UNEVEN * step_s, 1e-12 * abs(even_s[-1]))
    if step_s > 0 and not wrong.any():
        return 1 / step_s
    line = int(np.argmax(wrong)) + 3
    problem = f"the step to this time is not the mean one, {step_s:.6g} s"
    remedy = "record at an even rate without gaps, and write more digits of the time"
    raise InputError(file, f"line {line}", None, problem, remedy)


class Table(NamedTuple):
    """Columns in SI units at even times."""

    rate_hz: float
    values: dict[str, Floats]  # of each quantity but the time
    names: dict[str, str]  # of their columns


def parse_table(text: str, file: str, quantities: Mapping[str, Units], header: str) -> Table:
    """Return columns, by the names that each may have with their units in SI, or refuse a line."""
    lines = text.rstrip().splitlines()
    columns = NumberLines(lines[0] if lines else "")
    kinds = {"time": TIMES} | dict(quantities)
    places = [_column(columns, units, name, file, header) for name, units in kinds.items()]
    if not MIN_ROWS <= len(lines) - 1 <= MAX_ROWS:
        problem = f"has {max(0, len(lines) - 1)} rows, {MIN_ROWS} .. {MAX_ROWS} are needed"
        raise InputError(file, "", None, problem, "record for longer, or at another rate")
    order = [place for place, _ in places]
    time, *rows = _rows(lines, columns, order, file) * [[unit] for _, unit in places]
    values = dict(zip(quantities, rows, strict=True))
    for name, row in values.items():
        if np.ptp(row) == 0:
            problem, remedy = f"the {name} does not change", "excite the drive, see its connections"
            raise InputError(file, "", None, problem, remedy)
    found = (columns.names[place].strip('"').casefold() for place in order[1:])
    names = dict(zip(quantities, found, strict=True))
    return Table(_rate_hz(time, file), values, names)


def parse_record(text: str, file: str) -> ForeignRecord:
    """Return the recording of a text; errors as of `parse_table`."""
    what, where = "command or force", "position"
    found = parse_table(text, file, {what: COMMANDS | FORCES, where: POSITIONS}, HEADER)
    return ForeignRecord(found.rate_hz, found.values[what], found.values[where], found.names[what])
