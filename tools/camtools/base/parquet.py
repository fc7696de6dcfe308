# SPDX-License-Identifier: Apache-2.0
"""Tables as Parquet files.

>>> data = parquet_bytes({"t_s": [0.0, 0.5]}, pa.schema([("t_s", pa.float64())]), {"part": "a"})
>>> columns, about = parquet_read(data)
>>> columns["t_s"].tolist(), about["part"]
([0.0, 0.5], 'a')
"""

from __future__ import annotations

from io import BytesIO
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq


def parquet_bytes(columns: dict[str, Any], schema: Any, about: dict[str, str]) -> bytes:  # noqa: ANN401
    """Return a table as a Parquet file; `about` goes into its metadata."""
    coded = {name.encode(): text.encode() for name, text in about.items()}
    table = pa.table(columns, schema=schema.with_metadata(coded))
    stream = BytesIO()
    pq.write_table(table, stream, compression="zstd")
    return stream.getvalue()


def parquet_read(data: bytes) -> tuple[dict[str, Any], dict[str, str]]:
    """Return the columns of a Parquet file as arrays, and its metadata."""
    table = pq.read_table(BytesIO(data))
    about = {name.decode(): text.decode() for name, text in (table.schema.metadata or {}).items()}
    return {name: table[name].to_numpy() for name in table.column_names}, about
