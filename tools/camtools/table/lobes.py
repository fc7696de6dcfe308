"""The directory of lobes of a table image: where each sits, its phase, and its pattern.

Exactly as firmware/table/TABLE_FORMAT.md, "Lobes".

>>> low = LobePlace(0, 14_000_000, 0, 0)
>>> high = LobePlace(45_000_000, 59_000_000, 1 << 30, 0)
>>> change_nm(low, high), len(bytes_of_lobes((low, high)))
(15480000, 40)
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple, Protocol

import numpy as np

from camtools.table.records import Demand, listed

KIND_LOBES = 6
MAX_LOBES = 64
LEAST_GAP_NM = 200_000
KEPT_OFF_NM = 20_000  # beside a lobe its lift is whole: a tenth of the narrowest gap
_RECORD = np.dtype(
    [
        ("z_first_nm", "<i4"),
        ("z_last_nm", "<i4"),
        ("phase_q32", "<u4"),
        ("pattern", "<u4"),
        ("changes_per_nm_q48", "<u4"),
    ]
)


class LobePlace(NamedTuple):
    """One lobe of a table."""

    z_first_nm: int
    z_last_nm: int
    phase_q32: int  # turn / 2^32, 0 .. 2^32 - 1
    pattern: int  # slice of all channels over angle


class _Patterned(Protocol):
    """A channel over angle, as far as the directory needs it."""

    @property
    def kind(self) -> int: ...

    @property
    def n_slices(self) -> int: ...

    @property
    def has_patterns(self) -> bool: ...


class _Table(Protocol):
    """A table, as far as the directory needs it."""

    @property
    def z_first_nm(self) -> int: ...

    @property
    def z_last_nm(self) -> int: ...

    @property
    def is_ring_helix(self) -> bool: ...

    @property
    def lobes(self) -> tuple[LobePlace, ...]: ...

    @property
    def channels(self) -> Sequence[_Patterned]: ...

    @property
    def angle(self) -> _Patterned | None: ...


def change_nm(below: LobePlace, above: LobePlace) -> int:
    """Return the height over which the lift falls, and over which that of the next lobe rises."""
    return (above.z_first_nm - below.z_last_nm) // 2 - KEPT_OFF_NM


def _per_nm_q48(change: int) -> int:
    return ((1 << 48) + change // 2) // change


def _reciprocals(lobes: Sequence[LobePlace]) -> list[int]:
    """Return the reciprocal of every change above a lobe; 0 above the last."""
    return [_per_nm_q48(change_nm(*two)) for two in pairwise(lobes)] + [0]


def bytes_of_lobes(lobes: Sequence[LobePlace]) -> bytes:
    """Return the directory of lobes, upwards, at least LEAST_GAP_NM apart."""
    rows = [(*lobe, q48) for lobe, q48 in zip(lobes, _reciprocals(lobes), strict=True)]
    return np.array(rows, _RECORD).tobytes()


def lobes_of(
    image: bytes, table: _Table, entries: Sequence[dict[str, Any]], demand: Demand
) -> tuple[LobePlace, ...]:
    """Return the lobes of an image, checked as far as the directory alone shows; empty without."""
    places = [i for i, entry in enumerate(entries) if entry["kind"] == KIND_LOBES]
    if not places:
        return ()
    demand(places == [0], "kind: lobes are not the first channel alone")
    ends_nm = table.z_first_nm, table.z_last_nm
    rows = listed("lobes", MAX_LOBES, _RECORD, image, entries[0], ends_nm, demand)
    lobes = tuple(LobePlace(*row[:4]) for row in rows)
    demand(all(one.z_last_nm > one.z_first_nm for one in lobes), "lobes: one ends below its begin")
    ends = (lobes[0].z_first_nm, lobes[-1].z_last_nm)
    demand(ends == ends_nm, "lobes: ends differ from the table's")
    gaps = [above.z_first_nm - below.z_last_nm for below, above in pairwise(lobes)]
    demand(min(gaps, default=LEAST_GAP_NM) >= LEAST_GAP_NM, "lobes: a gap below 0.2 mm")
    demand([row[4] for row in rows] == _reciprocals(lobes), "changes_per_nm_q48: wrong")
    return lobes


def check_lobes(table: _Table, demand: Demand) -> None:
    """Check that every lobe has its pattern in all channels over angle."""
    if not table.lobes:
        return
    counts = {one.n_slices for one in table.channels if one.has_patterns}
    demand(table.angle is not None and not table.is_ring_helix, "lobes: no channel of their angle")
    demand(len(counts) == 1, "n_slices: channels have not the same patterns")
    is_there = all(lobe.pattern < min(counts) for lobe in table.lobes)
    demand(is_there, "pattern: beyond the slices")
