"""The records of a table image, its lobes and passes, exactly as firmware/table/TABLE_FORMAT.md.

>>> bytes_of(KNOT, {"p": 1, "v": -1, "a": 0}).hex()
'01000000ffffffff00000000'
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from camtools.table.image import Table


def _record(fields: str) -> np.dtype[np.void]:
    """Return a record of fields, name and type of each."""
    return np.dtype([(name, kind) for kind, name in (one.split() for one in fields.split(","))])


HEADER = _record(
    "S8 magic, <u4 byte_order, <u2 version_major, <u2 version_minor, <u4 image_size, <u4 crc32, "
    "<u4 header_size, <u4 n_channels, S32 part_name, <i4 z_first_nm, <i4 z_last_nm, <i4 direction, "
    "<u4 spindle_mrpm, <u4 feed_nm, <u4 depth_nm, <u4 limit_u_stroke_nm, "
    "<u4 limit_u_speed_um_per_s, <u4 limit_u_acceleration_mm_per_s2, <u4 limit_spindle_mrpm, "
    "<i4 u_min_nm, <i4 u_max_nm, <u4 u1_peak_nm_per_rad, <u4 u2_peak_nm_per_rad2, <u4 error_pm, "
    "<u4 spindle_peak_ppm_per_rad"
)
ENTRY = _record(
    "<u4 kind, <u4 offset, <u4 size, <u4 n_slices, <u4 log2_knots, <u4 log2_repeat, <u4 frac_bits, "
    "<i4 z_first_nm, <i4 z_last_nm, <u4 slices_per_nm_q48, <i4 value_offset, <i4 p_min, <i4 p_max, "
    "<u4 v_max, <u4 a_max, <u4 path"
)
_UNUSED_OF_LISTS = (
    *("log2_knots", "log2_repeat", "frac_bits", "slices_per_nm_q48", "value_offset"),
    *("p_min", "p_max", "v_max", "a_max", "path"),
)


class ImageError(Exception):
    """An image that the firmware would refuse; says which rule it breaks first."""


def demand(condition: bool, rule: str) -> None:
    """Refuse by a rule of TABLE_FORMAT.md where a condition does not hold."""
    if not condition:
        raise ImageError(rule)


KNOT = _record("<i4 p, <i4 v, <i4 a")
HEADER_SIZE, ENTRY_SIZE, KNOT_SIZE = HEADER.itemsize, ENTRY.itemsize, KNOT.itemsize
CRC_START = HEADER.fields["crc32"][1] + 4  # type: ignore[index]


def bytes_of(record: np.dtype[np.void], values: Mapping[str, object]) -> bytes:
    """Return a record whose fields, all of them, have these values."""
    assert values.keys() == set(record.names or ())
    one = np.zeros((), record)
    for name, value in values.items():
        one[name] = value
    return one.tobytes()


def fields_of(record: np.dtype[np.void], image: bytes, offset: int) -> dict[str, Any]:
    """Return the fields of a record as Python's own numbers and bytes."""
    [one] = np.frombuffer(image, record, count=1, offset=offset).tolist()
    return dict(zip(record.names or (), one, strict=True))


def listed(
    name: str,
    most: int,
    record: np.dtype[np.void],
    image: bytes,
    entry: Mapping[str, Any],
    ends_nm: tuple[int, int],
) -> list[tuple[int, ...]]:
    """Return the checked records of an entry that is a list of at most so many names."""
    n, offset = entry["n_slices"], entry["offset"]
    demand(1 <= n <= most, f"n_slices: not 1 .. {most} {name}")
    unused = any(entry[field] for field in _UNUSED_OF_LISTS)
    demand(not unused, f"{name}: a field without meaning is not 0")
    is_whole = (entry["z_first_nm"], entry["z_last_nm"]) == ends_nm
    demand(is_whole, f"z: {name} are not those of the whole table")
    demand(entry["size"] == n * record.itemsize, f"size: not that of the {name}")
    demand(offset % 4 == 0 and offset + entry["size"] <= len(image), "offset: misplaced")
    rows: list[tuple[int, ...]] = np.frombuffer(image, record, count=n, offset=offset).tolist()
    return rows


KIND_LOBES = 6
MAX_LOBES = 64
LEAST_GAP_NM = 200_000
KEPT_OFF_NM = 20_000  # beside a lobe its lift is whole: a tenth of the narrowest gap
_LOBE = _record("<i4 z_first_nm, <i4 z_last_nm, <u4 phase_q32, <u4 pattern, <u4 changes_per_nm_q48")


class LobePlace(NamedTuple):
    """One lobe of a table."""

    z_first_nm: int
    z_last_nm: int
    phase_q32: int  # turn / 2^32, 0 .. 2^32 - 1
    pattern: int  # slice of all channels over angle


def change_nm(below: LobePlace, above: LobePlace) -> int:
    """Return the height over which the lift falls, and over which that of the next lobe rises."""
    return (above.z_first_nm - below.z_last_nm) // 2 - KEPT_OFF_NM


def _reciprocals(lobes: Sequence[LobePlace]) -> list[int]:
    """Return the reciprocal of every change above a lobe; 0 above the last."""
    changes = (change_nm(*two) for two in pairwise(lobes))
    return [((1 << 48) + change // 2) // change for change in changes] + [0]


def bytes_of_lobes(lobes: Sequence[LobePlace]) -> bytes:
    """Return the directory of lobes, upwards, at least LEAST_GAP_NM apart."""
    rows = [(*lobe, q48) for lobe, q48 in zip(lobes, _reciprocals(lobes), strict=True)]
    return np.array(rows, _LOBE).tobytes()


def lobes_of(
    image: bytes, table: Table, entries: Sequence[dict[str, Any]]
) -> tuple[LobePlace, ...]:
    """Return the lobes of an image, checked as far as the directory alone shows; empty without."""
    places = [i for i, entry in enumerate(entries) if entry["kind"] == KIND_LOBES]
    if not places:
        return ()
    demand(places == [0], "kind: lobes are not the first channel alone")
    ends_nm = table.z_first_nm, table.z_last_nm
    rows = listed("lobes", MAX_LOBES, _LOBE, image, entries[0], ends_nm)
    lobes = tuple(LobePlace(*row[:4]) for row in rows)
    demand(all(one.z_last_nm > one.z_first_nm for one in lobes), "lobes: one ends below its begin")
    ends = (lobes[0].z_first_nm, lobes[-1].z_last_nm)
    demand(ends == ends_nm, "lobes: ends differ from the table's")
    gaps = [above.z_first_nm - below.z_last_nm for below, above in pairwise(lobes)]
    demand(min(gaps, default=LEAST_GAP_NM) >= LEAST_GAP_NM, "lobes: a gap below 0.2 mm")
    demand([row[4] for row in rows] == _reciprocals(lobes), "changes_per_nm_q48: wrong")
    return lobes


def check_lobes(table: Table) -> None:
    """Check that every lobe has its pattern in all channels over angle."""
    if not table.lobes:
        return
    counts = {one.n_slices for one in table.channels if one.has_patterns}
    demand(table.angle is not None and not table.is_ring_helix, "lobes: no channel of their angle")
    demand(len(counts) == 1, "n_slices: channels have not the same patterns")
    is_there = all(lobe.pattern < min(counts) for lobe in table.lobes)
    demand(is_there, "pattern: beyond the slices")


KIND_PASSES = 8
MAX_PASSES = 16
MAX_ALLOWANCE_NM = 10_000_000
_PASS = _record("<i4 allowance_nm, <u4 feed_nm, <u4 spindle_mrpm, <u4 reserved")


class PassRecord(NamedTuple):
    """One pass of a table."""

    allowance_nm: int  # stock on the radius that it leaves
    feed_nm: int  # per turn; with a way the mean
    spindle_mrpm: int


def bytes_of_passes(passes: Sequence[PassRecord]) -> bytes:
    """Return the records of passes, in the order of cutting."""
    return np.array([(*one, 0) for one in passes], _PASS).tobytes()


def passes_of(
    image: bytes, ends_nm: tuple[int, int], entries: Sequence[dict[str, Any]]
) -> tuple[PassRecord, ...]:
    """Return the passes of an image, checked as the firmware checks them; empty without."""
    found = [entry for entry in entries if entry["kind"] == KIND_PASSES]
    if not found:
        return ()
    demand(len(found) == 1, "kind: passes are there twice")
    rows = listed("passes", MAX_PASSES, _PASS, image, found[0], ends_nm)
    passes = tuple(PassRecord(*row[:3]) for row in rows)
    is_falling = all(low.allowance_nm < high.allowance_nm for high, low in pairwise(passes))
    demand(is_falling and passes[-1].allowance_nm == 0, "passes: allowances do not fall to 0")
    demand(passes[0].allowance_nm <= MAX_ALLOWANCE_NM, "allowance_nm: not at most 10^7")
    is_moving = all(one.feed_nm > 0 and one.spindle_mrpm > 0 for one in passes)
    demand(is_moving and not any(row[3] for row in rows), "passes: feed, speed or reserved wrong")
    return passes
