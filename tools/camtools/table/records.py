"""The records of a table image, field by field as firmware/table/TABLE_FORMAT.md names them.

>>> bytes_of(KNOT, {"p": 1, "v": -1, "a": 0}).hex()
'01000000ffffffff00000000'
>>> fields_of(KNOT, bytes(12), 0)
{'p': 0, 'v': 0, 'a': 0}
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

HEADER = np.dtype(
    [
        ("magic", "S8"),
        ("byte_order", "<u4"),
        ("version_major", "<u2"),
        ("version_minor", "<u2"),
        ("image_size", "<u4"),
        ("crc32", "<u4"),
        ("header_size", "<u4"),
        ("n_channels", "<u4"),
        ("part_name", "S32"),
        ("z_first_nm", "<i4"),
        ("z_last_nm", "<i4"),
        ("direction", "<i4"),
        ("spindle_mrpm", "<u4"),
        ("feed_nm", "<u4"),
        ("depth_nm", "<u4"),
        ("limit_u_stroke_nm", "<u4"),
        ("limit_u_speed_um_per_s", "<u4"),
        ("limit_u_acceleration_mm_per_s2", "<u4"),
        ("limit_spindle_mrpm", "<u4"),
        ("u_min_nm", "<i4"),
        ("u_max_nm", "<i4"),
        ("u1_peak_nm_per_rad", "<u4"),
        ("u2_peak_nm_per_rad2", "<u4"),
        ("error_pm", "<u4"),
        ("spindle_peak_ppm_per_rad", "<u4"),
    ]
)


ENTRY = np.dtype(
    [
        ("kind", "<u4"),
        ("offset", "<u4"),
        ("size", "<u4"),
        ("n_slices", "<u4"),
        ("log2_knots", "<u4"),
        ("log2_repeat", "<u4"),
        ("frac_bits", "<u4"),
        ("z_first_nm", "<i4"),
        ("z_last_nm", "<i4"),
        ("slices_per_nm_q48", "<u4"),
        ("value_offset", "<i4"),
        ("p_min", "<i4"),
        ("p_max", "<i4"),
        ("v_max", "<u4"),
        ("a_max", "<u4"),
        ("path", "<u4"),
    ]
)


_UNUSED_OF_LISTS = (
    *("log2_knots", "log2_repeat", "frac_bits", "slices_per_nm_q48", "value_offset"),
    *("p_min", "p_max", "v_max", "a_max", "path"),
)
Demand = Callable[[bool, str], None]
"""Refuses by a rule of TABLE_FORMAT.md where a condition does not hold."""

KNOT = np.dtype([("p", "<i4"), ("v", "<i4"), ("a", "<i4")])
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
    demand: Demand,
) -> list[tuple[int, ...]]:
    """Return the records of an entry that holds no knots but a list, checked as far as all are.

    Parameters
    ----------
    name : str
        What the list has, at most `most` of it: "lobes", "passes".
    ends_nm : tuple of int
        Heights of the whole table, which every list has.
    demand : callable
        Raises with the rule that is broken.
    """
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
