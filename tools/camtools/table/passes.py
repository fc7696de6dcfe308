"""The records of passes in a table image, exactly as firmware/table/TABLE_FORMAT.md, "Passes".

>>> len(bytes_of_passes((PassRecord(20_000, 100_000, 600_000), PassRecord(0, 50_000, 900_000))))
32
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from camtools.table.records import Demand, listed

KIND_PASSES = 8
MAX_PASSES = 16
MAX_ALLOWANCE_NM = 10_000_000
_RECORD = np.dtype(
    [("allowance_nm", "<i4"), ("feed_nm", "<u4"), ("spindle_mrpm", "<u4"), ("reserved", "<u4")]
)


class PassRecord(NamedTuple):
    """One pass of a table."""

    allowance_nm: int  # stock on the radius that it leaves
    feed_nm: int  # per turn; with a way the mean
    spindle_mrpm: int


def bytes_of_passes(passes: Sequence[PassRecord]) -> bytes:
    """Return the records of passes, in the order of cutting."""
    return np.array([(*one, 0) for one in passes], _RECORD).tobytes()


def passes_of(
    image: bytes, ends_nm: tuple[int, int], entries: Sequence[dict[str, Any]], demand: Demand
) -> tuple[PassRecord, ...]:
    """Return the passes of an image, checked as the firmware checks them; empty without."""
    found = [entry for entry in entries if entry["kind"] == KIND_PASSES]
    if not found:
        return ()
    demand(len(found) == 1, "kind: passes are there twice")
    rows = listed("passes", MAX_PASSES, _RECORD, image, found[0], ends_nm, demand)
    passes = tuple(PassRecord(*row[:3]) for row in rows)
    is_falling = all(low.allowance_nm < high.allowance_nm for high, low in pairwise(passes))
    demand(is_falling and passes[-1].allowance_nm == 0, "passes: allowances do not fall to 0")
    demand(passes[0].allowance_nm <= MAX_ALLOWANCE_NM, "allowance_nm: not at most 10^7")
    is_moving = all(one.feed_nm > 0 and one.spindle_mrpm > 0 for one in passes)
    demand(is_moving and not any(row[3] for row in rows), "passes: feed, speed or reserved wrong")
    return passes
