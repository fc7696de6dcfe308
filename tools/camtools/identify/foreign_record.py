r"""A recording of another instrument: time, command or force, and position in columns with units.

>>> rows = "".join(f"{i * 1e-3},{i % 7},{i % 5}\n" for i in range(4096))
>>> found = parse_record("time_s,force_n,position_um\n" + rows, "scope.csv")
>>> found.command, round(found.rate_hz), found.u.size, float(found.y[4])
('force_n', 1000, 4096, 4e-06)
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from camtools.base.errors import InputError
from camtools.base.number_table import NumberTable, Units
from camtools.base.quantities import Floats

TIMES = {"time_s": 1.0, "time_ms": 1e-3, "time_us": 1e-6}  # seconds per unit
LENGTHS = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "nm": 1e-9}  # metres per unit
COMMANDS = {f"command_{unit}": metres for unit, metres in LENGTHS.items()} | {"command_v": 1.0}
FORCES = {"force_n": 1.0, "force_kn": 1e3}  # newtons per unit
POSITIONS = {f"position_{unit}": metres for unit, metres in LENGTHS.items()}
HEADER = "time_s,command_um,position_um"
MIN_ROWS, MAX_ROWS = 1024, 2_000_000
MAX_BYTES = 200 * MAX_ROWS
_UNEVEN = 0.01  # of a step, that a time may be off
_COPY = 1e-5  # of a signal's rms: what a copy leaves of it; digits and steps of a scale leave more


class ForeignRecord(NamedTuple):
    """What another instrument recorded at even times."""

    rate_hz: float
    u: Floats  # shape (n,); command [m] or [V], or force [N]
    y: Floats  # shape (n,); position [m]
    command: str  # name of its column


def _rate_hz(time_s: Floats, table: NumberTable) -> float:
    step_s = float(time_s[-1] - time_s[0]) / (time_s.size - 1)
    even_s = time_s[0] + step_s * np.arange(time_s.size)
    wrong = np.abs(np.diff(time_s) - step_s) > max(_UNEVEN * step_s, 1e-12 * abs(even_s[-1]))
    if step_s > 0 and not wrong.any():
        return 1 / step_s
    problem = f"the step to this time is not the mean one, {step_s:.6g} s"
    remedy = "record at an even rate without gaps, and write more digits of the time"
    raise table.refusal(int(np.argmax(wrong)) + 1, problem, remedy)


def _is_copy(u: Floats, y: Floats) -> bool:
    """Return whether two signals that change differ by offset and factor only."""
    u, y = ((row - row.mean()) / np.ptp(row) for row in (u, y))
    rest = y - u * (u @ y) / (u @ u)
    return bool(rest @ rest <= _COPY**2 * (y @ y))


class Table(NamedTuple):
    """Columns in SI units at even times."""

    rate_hz: float
    values: dict[str, Floats]  # of each quantity but the time
    names: dict[str, str]  # of their columns


def parse_table(text: str, file: str, quantities: Mapping[str, Units], header: str) -> Table:
    """Return columns, by the names that each may have with their units in SI, or refuse a line.

    The last one is what moves. Refuses a last column that is a copy of another one, as after a
    wrong connection.
    """
    table = NumberTable(text, file, MAX_ROWS)
    columns = table.columns({"time": TIMES} | dict(quantities), header)
    if len(table.rows) < MIN_ROWS:
        problem = f"has {len(table.rows)} rows, {MIN_ROWS} .. {MAX_ROWS} are needed"
        raise InputError(file, "", None, problem, "record for longer, or at another rate")
    time_s, *rows = table.values(columns)
    values = dict(zip(quantities, rows, strict=True))
    for name, row in values.items():
        if np.ptp(row) == 0:
            problem, remedy = f"the {name} does not change", "excite the drive, see its connections"
            raise InputError(file, "", None, problem, remedy)
    *given, (last, moved) = values.items()
    for name, row in given:
        if _is_copy(row, moved):
            problem = f"the {last} is the {name} times a constant: one signal is in both columns"
            raise InputError(file, "", None, problem, f"record the {last} that the scale measures")
    names = dict(zip(quantities, (column.name for column in columns[1:]), strict=True))
    return Table(_rate_hz(time_s, table), values, names)


def parse_record(text: str, file: str) -> ForeignRecord:
    """Return the recording of a text; errors as of `parse_table`."""
    what, where = "command or force", "position"
    found = parse_table(text, file, {what: COMMANDS | FORCES, where: POSITIONS}, HEADER)
    return ForeignRecord(found.rate_hz, found.values[what], found.values[where], found.names[what])
