# SPDX-License-Identifier: Apache-2.0
r"""The trace of a cut as Parquet: the numbers of camsim's CSV, digit by digit, in a tenth of it.

camsim writes text into a pipe, which is packed here block by block, so that neither the text nor
the trace is ever whole in memory or on the disk. The same text gives the same bytes. What the CSV
tells twice is told once (`TOLD_TWICE`).

A column of whole numbers is int64, in differences. A decimal fraction is a double on a grid of
2^-k, the coarsest one on which rounding to the decimals of the text gives its digits back: a double
of the digits themselves would have a mantissa that nothing can pack. The decimals of a column stand
in its metadata, and `read_columns` rounds; who reads the file with other tools finds numbers that
are off by at most a quarter of the last digit.

>>> import io, tempfile
>>> text = b"tick,t_s,state\n0,0.10,off\n1,0.15,ready\n"
>>> path = Path(tempfile.mkdtemp()) / "trace.parquet"
>>> pack_trace(io.BytesIO(text), path)
2
>>> {name: values.tolist() for name, values in read_columns(path, ["t_s", "state"]).items()}
{'t_s': [0.1, 0.15], 'state': ['off', 'ready']}
"""

from __future__ import annotations

import io
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.csv as pc
import pyarrow.parquet as pq

# Columns of the CSV that are another one in a smaller unit: (its name, how many of them in one).
TOLD_TWICE = {
    "z_nm": ("z_mm", 1_000_000),
    "u_set_q6": ("u_set_nm", 64),
    "u_due_q6": ("u_due_nm", 64),
    "in_u_nm": ("u_act_nm", 1),
}
_BLOCK_BYTES = 8 << 20  # of text
_GROUP_ROWS = 1 << 17
_DECIMALS = b"decimals"
_LEVEL = 5  # of zstd: a higher one takes longer and saves 2 %


class _Text(io.RawIOBase):
    """The lines that were read to learn the columns, then the rest; whole blocks to the end."""

    def __init__(self, begin: bytes, rest: BinaryIO) -> None:
        self._begin, self._rest = begin, rest

    def readable(self) -> bool:
        """Return that it is."""
        return True

    def read(self, n: int = -1) -> bytes:
        """Return as many bytes as were asked for, fewer at the end only."""
        first, self._begin = (self._begin, b"") if n < 0 else (self._begin[:n], self._begin[n:])
        parts = [first]
        left = -1 if n < 0 else n - len(first)
        while left != 0 and (part := self._rest.read(left)):
            parts.append(part)
            left -= len(part) if left > 0 else 0
        return b"".join(parts)


def _type_of(cell: str) -> tuple[pa.DataType, int]:
    """Return the type of a column by a cell of it, and how many decimals it has."""
    if cell.startswith("0x"):
        return pa.int64(), 0
    number = cell.removeprefix("-")
    if number.isdigit():
        return pa.int64(), 0
    whole, _, part = number.partition(".")
    if whole.isdigit() and part.isdigit():
        return pa.float64(), len(part)
    return pa.string(), 0


def grid_bits(decimals: int) -> int:
    """Return k of the grid 2^-k on which rounding gives the decimals back.

    >>> [grid_bits(decimals) for decimals in (3, 6, 9)]
    [11, 21, 31]
    """
    return math.ceil(decimals * math.log2(10)) + 1


def _field(name: str, cell: str) -> pa.Field:
    kind, decimals = _type_of(cell)
    if kind == pa.string():
        return pa.field(name, pa.dictionary(pa.int32(), pa.string()))
    metadata = {_DECIMALS: str(decimals).encode()} if decimals else None
    return pa.field(name, kind, metadata=metadata)


def _packed(table: pa.Table, schema: pa.Schema) -> pa.Table:
    """Return rows with their fractions on the grid."""
    columns = []
    for field, column in zip(schema, table.columns, strict=True):
        if field.metadata:
            scale = 2.0 ** grid_bits(int(field.metadata[_DECIMALS]))
            column = pa.array(np.rint(column.to_numpy() * scale) / scale)
        columns.append(column.cast(field.type))
    return pa.table(columns, schema=schema)


def _groups(text: _Text, schema: pa.Schema) -> Iterator[pa.Table]:
    """Yield rows in groups of one length, however the text came."""
    types = {f.name: pa.string() if pa.types.is_dictionary(f.type) else f.type for f in schema}
    reader = pc.open_csv(
        pa.PythonFile(text, "r"),
        read_options=pc.ReadOptions(use_threads=False, block_size=_BLOCK_BYTES),
        convert_options=pc.ConvertOptions(column_types=types, include_columns=list(types)),
    )
    kept: list[pa.RecordBatch] = []
    n_kept = 0
    for batch in reader:
        kept.append(batch)
        n_kept += batch.num_rows
        while n_kept >= _GROUP_ROWS:
            table = pa.Table.from_batches(kept)
            yield table.slice(0, _GROUP_ROWS)
            kept = table.slice(_GROUP_ROWS).to_batches()
            n_kept -= _GROUP_ROWS
    if n_kept:
        yield pa.Table.from_batches(kept)


def pack_trace(stream: BinaryIO, path: Path) -> int:
    """Write the CSV that a stream gives as Parquet; return its rows.

    Of an empty stream, as camsim leaves it when it refuses a cut, no file is made.

    Raises
    ------
    OSError
        The file cannot be written.
    """
    header, first = stream.readline(), stream.readline()
    if not header:
        return 0
    names = header.decode("ascii").strip().split(",")
    # Without a line all are whole numbers.
    cells = first.decode("ascii").strip().split(",") if first else ["0"] * len(names)
    fields = [_field(name, cell) for name, cell in zip(names, cells, strict=True)]
    schema = pa.schema([f for f in fields if TOLD_TWICE.get(f.name, ("",))[0] not in names])
    n_rows = 0
    words = {pa.int64(): "DELTA_BINARY_PACKED", pa.float64(): "BYTE_STREAM_SPLIT"}
    encodings = {field.name: words[field.type] for field in schema if field.type in words}
    with pq.ParquetWriter(
        path,
        schema,
        compression="zstd",
        compression_level=_LEVEL,
        use_dictionary=[f.name for f in schema if pa.types.is_dictionary(f.type)],
        column_encoding=encodings,
        write_statistics=False,
    ) as writer:
        if first:
            for group in _groups(_Text(header + first, stream), schema):
                writer.write_table(_packed(group, schema), _GROUP_ROWS)
                n_rows += group.num_rows
    return n_rows


def column_names(path: Path) -> list[str]:
    """Return the names of the columns of a trace."""
    return list(pq.read_schema(path).names)


def read_columns(path: Path, names: Sequence[str]) -> dict[str, npt.NDArray[Any]]:
    """Return columns of a trace, with the digits that camsim wrote.

    Raises
    ------
    KeyError
        There is no such column.
    """
    table = pq.read_table(path, columns=list(names))
    found = {}
    for name in names:
        field, values = table.schema.field(name), table.column(name)
        array = values.cast(pa.string()) if pa.types.is_dictionary(field.type) else values
        numbers = array.to_numpy()
        decimals = int((field.metadata or {}).get(_DECIMALS, b"0"))
        found[name] = np.round(numbers, decimals) if decimals else numbers
    return found
