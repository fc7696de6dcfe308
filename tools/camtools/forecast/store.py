"""Results of cuts on the disk, by the digest of what they depend on: Parquet files in a folder.

Every batch becomes a file of its own, which appears complete or not at all; a forecast that was
stopped finds what is there and goes on.

>>> import tempfile
>>> with tempfile.TemporaryDirectory() as name:
...     store = Store(Path(name))
...     store.add([CutOutcome("a", "done", 0, "", "", 0.1, 0.05, 0.1, 0.1, 1000, 0.2)])
...     Store(Path(name)).found["a"].form_max_um
0.1
"""

from __future__ import annotations

import uuid
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from camtools.base.errors import InputError
from camtools.base.output import write_all
from camtools.base.parquet import parquet_bytes
from camtools.forecast.one_cut import CutOutcome

_FIELDS = {
    "key": pa.string(),
    "end": pa.string(),
    "status": pa.int32(),
    "faults": pa.string(),
    "message": pa.string(),
    "form_max_um": pa.float64(),
    "form_rms_um": pa.float64(),
    "roundness_um": pa.float64(),
    "following_max_um": pa.float64(),
    "ticks": pa.int64(),
    "wall_s": pa.float64(),
}
SCHEMA = pa.schema(list(_FIELDS.items()))


class Store:
    """Outcomes in a folder.

    Parameters
    ----------
    folder : Path
        Made when the first outcome is added.

    Attributes
    ----------
    found : dict
        All outcomes by key.

    Raises
    ------
    InputError
        A file there is none of ours.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.found: dict[str, CutOutcome] = {}
        self._paths = sorted(folder.glob("*.parquet"))
        for path in self._paths:
            for outcome in _read(path):
                self.found[outcome.key] = outcome

    def add(self, outcomes: Sequence[CutOutcome]) -> None:
        """Keep outcomes; they are on the disk on return."""
        name = f"{uuid.uuid4().hex}.parquet"
        columns = {name: [getattr(one, name) for one in outcomes] for name in _FIELDS}
        write_all(self.folder, {name: parquet_bytes(columns, SCHEMA, {})})
        self._paths.append(self.folder / name)
        self.found |= {outcome.key: outcome for outcome in outcomes}

    def pick(self, keys: Iterable[str]) -> list[CutOutcome]:
        """Return the outcomes of these keys that are there."""
        return [self.found[key] for key in keys if key in self.found]

    def compact(self) -> None:
        """Make one file of many."""
        before = self._paths
        if len(before) > 1:
            self.add(list(self.found.values()))
            self._paths = self._paths[-1:]
            for path in before[: len(before)]:
                if path != self._paths[0]:
                    with suppress(OSError):
                        path.unlink()


def _read(path: Path) -> list[CutOutcome]:
    try:
        rows = pq.read_table(path, schema=SCHEMA).to_pylist()
    except (OSError, pa.ArrowException) as error:
        reason = str(error).splitlines()[0]
        remedy = "remove it: its cuts are made again"
        raise InputError(str(path), "", None, f"is no result of ours: {reason}", remedy) from error
    return [CutOutcome(**row) for row in rows]
