"""Tables as Parquet files; pyarrow is slow to load, so that only who writes them reads this.

>>> data = parquet_bytes({"t_s": [0.0, 0.5]}, pa.schema([("t_s", pa.float64())]), {"part": "a"})
>>> table = pq.read_table(BytesIO(data))
>>> table["t_s"].to_pylist(), table.schema.metadata[b"part"]
([0.0, 0.5], b'a')
"""

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
