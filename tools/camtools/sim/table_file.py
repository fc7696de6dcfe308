r"""Tables of the simulator as files: CSV text, or Parquet in a tenth of it.

Both have the digits of `camsim run`, and the same rows give the same bytes. Rows are written group
by group, so that a trace is never whole in memory. Parquet omits the columns of the CSV that
repeat another column in a smaller unit (`DUPLICATES`).

A column of whole numbers is int64 in Parquet, in differences. A decimal fraction is a double on a
grid of 2^-k, the coarsest one on which rounding to the column's decimals gives its digits back: a
double of the digits themselves would have a mantissa that nothing can pack. The decimals of a
column stand in its metadata, and `read_columns` rounds; other readers find numbers that are off by
at most a quarter of the last digit.

>>> import tempfile
>>> columns = (Column("tick", "0"), Column("t_s", "2"), Column("state", "s"))
>>> path = Path(tempfile.mkdtemp()) / "trace.parquet"
>>> with ParquetFile(path, columns) as file:
...     file.write(np.array([[0, 10, 0], [1, 15, 2]]))
>>> {name: values.tolist() for name, values in read_columns(path, ["t_s", "state"]).items()}
{'t_s': [0.1, 0.15], 'state': [0, 2]}
>>> with CsvFile(path, columns) as text:
...     text.write(np.array([[0, 10, 0], [1, 15, 2]]))
>>> path.read_text()
'tick,t_s,state\n0,0.10,off\n1,0.15,ready\n'
"""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Self

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from camtools.sim.binding import Column
from camtools.sim.results import STATES

Numbers = npt.NDArray[np.int64]  # shape (rows, columns), as in `Table`

# Columns that are another one in a smaller unit: (its name, how many of them in one).
DUPLICATES = {
    "z_nm": ("z_mm", 1_000_000),
    "u_set_q6": ("u_set_nm", 64),
    "u_due_q6": ("u_due_nm", 64),
    "in_u_nm": ("u_act_nm", 1),
}
_DECIMALS = b"decimals"
_LEVEL = 5  # of zstd: a higher one takes longer and saves 2 %
_STATE = pa.dictionary(pa.int32(), pa.string())
_SHORT_MASK = 1 << 16  # longer ones have eight digits


def _cells(column: Column, numbers: Numbers) -> list[Any]:
    """Return numbers of a column for the format of a row."""
    if column.format == "s":
        return [STATES[number] for number in numbers.tolist()]
    if column.format == "x4":
        masks = numbers.tolist()
        return [f"0x{mask:04x}" if mask < _SHORT_MASK else f"0x{mask:08x}" for mask in masks]
    decimals = column.decimals
    return list((numbers / 10.0**decimals if decimals else numbers).tolist())


class CsvFile:
    """A table as CSV text; use it by `with`."""

    def __init__(self, path: Path, columns: Sequence[Column]) -> None:
        self._columns, self._stream = columns, path.open("w", encoding="ascii", newline="")
        formats = (f"%.{column.decimals}f" if column.decimals else "%s" for column in columns)
        self._line = ",".join(formats) + "\n"
        self._stream.write(",".join(column.name for column in columns) + "\n")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._stream.close()

    def write(self, numbers: Numbers) -> None:
        """Write rows."""
        cells = (_cells(column, numbers[:, i]) for i, column in enumerate(self._columns))
        self._stream.writelines(self._line % row for row in zip(*cells, strict=True))


def grid_bits(decimals: int) -> int:
    """Return k of the grid 2^-k on which rounding gives the decimals back."""
    return math.ceil(decimals * math.log2(10)) + 1


def _field(column: Column) -> pa.Field:
    if column.format == "s":
        return pa.field(column.name, _STATE)
    if not column.decimals:
        return pa.field(column.name, pa.int64())
    return pa.field(column.name, pa.float64(), metadata={_DECIMALS: column.format.encode()})


def _packed(column: Column, numbers: Numbers) -> pa.Array:
    """Return numbers of a column, fractions on their grid."""
    if column.format == "s":
        return pa.DictionaryArray.from_arrays(numbers.astype(np.int32), STATES)
    if not column.decimals:
        return pa.array(numbers)
    scale = 2.0 ** grid_bits(column.decimals)
    return pa.array(np.rint(numbers / 10.0**column.decimals * scale) / scale)


class ParquetFile:
    """A table as Parquet; use it by `with`."""

    def __init__(self, path: Path, columns: Sequence[Column]) -> None:
        names = [column.name for column in columns]
        self._kept = [
            (place, column)
            for place, column in enumerate(columns)
            if DUPLICATES.get(column.name, ("",))[0] not in names
        ]
        self._schema = pa.schema([_field(column) for _, column in self._kept])
        words = {pa.int64(): "DELTA_BINARY_PACKED", pa.float64(): "BYTE_STREAM_SPLIT"}
        self._writer = pq.ParquetWriter(
            path,
            self._schema,
            compression="zstd",
            compression_level=_LEVEL,
            use_dictionary=[field.name for field in self._schema if field.type == _STATE],
            column_encoding={
                field.name: words[field.type] for field in self._schema if field.type in words
            },
            write_statistics=False,
        )

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._writer.close()

    def write(self, numbers: Numbers) -> None:
        """Write rows, if there are any, as a group."""
        if len(numbers):
            columns = np.ascontiguousarray(numbers.T)
            arrays = [_packed(column, columns[place]) for place, column in self._kept]
            self._writer.write_table(pa.table(arrays, schema=self._schema), len(numbers))


TableFile = CsvFile | ParquetFile


def table_file(path: Path, columns: Sequence[Column]) -> TableFile:
    """Open the file of a table; its suffix gives the format."""
    return (ParquetFile if path.suffix == ".parquet" else CsvFile)(path, columns)


def column_names(path: Path) -> list[str]:
    """Return the names of the columns of a trace."""
    return list(pq.read_schema(path).names)


def read_columns(path: Path, names: Sequence[str]) -> dict[str, npt.NDArray[Any]]:
    """Return columns of a trace, with the digits that camsim writes; states by their numbers."""
    table = pq.read_table(path, columns=list(names))
    found = {}
    for name in names:
        field, values = table.schema.field(name), table.column(name)
        if pa.types.is_dictionary(field.type):
            places = pc.index_in(values.cast(pa.string()), pa.array(STATES))
            found[name] = places.to_numpy().astype(np.int64)
            continue
        numbers = values.to_numpy()
        decimals = int((field.metadata or {}).get(_DECIMALS, b"0"))
        found[name] = np.round(numbers, decimals) if decimals else numbers
    return found
