"""The table image, bytes <-> dataclasses, exactly as firmware/table/TABLE_FORMAT.md.

Every record is packed and read by the names of its fields, which are those of that document.

>>> hex(crc32_of(bytes(HEADER_SIZE)))
'0xd71f022f'
"""

import re
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from camtools.table.channel import (
    ALIGN,
    CRC_START,
    ENTRY,
    ENTRY_SIZE,
    HEADER,
    HEADER_SIZE,
    KIND_CONTACT,
    KIND_LOBES,
    KIND_PASSES,
    KIND_SPEED,
    KIND_SWING,
    KIND_U,
    KIND_WAY,
    KIND_X,
    KNOT,
    OVER_HEIGHT,
    Bounds,
    Channel,
    ImageLimits,
    LobePlace,
    PassRecord,
    bytes_of,
    bytes_of_lobes,
    bytes_of_passes,
    check_entry,
    check_knots,
    check_way,
    demand,
    fields_of,
    lobes_of,
    passes_of,
)

MAGIC = b"CAMTAB\x1a\n"
BYTE_ORDER, VERSION, NEWER_VERSION = 0x01020304, (1, 0), (1, 1)


@dataclass(frozen=True, eq=False)
class Table:
    """A whole table image without its redundancies."""

    part_name: str
    z_first_nm: int
    z_last_nm: int
    direction: int
    spindle_mrpm: int
    feed_nm: int
    depth_nm: int
    limits: ImageLimits
    bounds: Bounds
    channels: tuple[Channel, ...]
    is_ring_helix: bool = False  # a geared Z follows a ring-helix, not a helix
    lobes: tuple[LobePlace, ...] = ()  # upwards; channels over angle hold their patterns
    passes: tuple[PassRecord, ...] = ()  # in the order of cutting; without: one, of the header
    has_stations: bool = False  # Z may stand and go back; all else is found by the turns of a helix

    def channel(self, kind: int) -> Channel:
        """Return the channel of this kind; `unpack` makes sure that u and x exist."""
        return next(channel for channel in self.channels if channel.kind == kind)

    @property
    def speed(self) -> Channel | None:
        """Return the speed ratio, when the table modulates the spindle."""
        return next((channel for channel in self.channels if channel.kind == KIND_SPEED), None)

    @property
    def way(self) -> Channel | None:
        """Return how far Z is ahead of a plain helix, when the feed changes with the height."""
        return next((channel for channel in self.channels if channel.kind == KIND_WAY), None)

    @property
    def z_end_nm(self) -> int:
        """Return where Z ends: with stations the highest place that it reaches."""
        way = self.way
        if way is None or not self.has_stations:
            return self.z_last_nm
        return self.z_last_nm + way.value_offset + (int(way.knots[-1, 0, 0]) >> way.frac_bits)

    @property
    def is_newer(self) -> bool:
        """Whether the image is of version 1.1."""
        return bool(self.lobes or self.passes or self.way)

    @property
    def angle(self) -> Channel | None:
        """Return the angle of the normal at the contact, when the table is that of a lobe."""
        kinds = (KIND_SWING, KIND_CONTACT)
        return next((channel for channel in self.channels if channel.kind in kinds), None)


def _aligned(size: int) -> int:
    return -(-size // ALIGN) * ALIGN


# Fields of the header that a table has by the same name.
_SAME = ("z_first_nm", "z_last_nm", "direction", "spindle_mrpm", "feed_nm", "depth_nm")


def _header_of(table: Table, image_size: int, crc32: int) -> bytes:
    version = NEWER_VERSION if table.is_newer else VERSION
    values = {
        "magic": MAGIC,
        "byte_order": BYTE_ORDER,
        "version_major": version[0],
        "version_minor": version[1],
        "image_size": image_size,
        "crc32": crc32,
        "header_size": HEADER_SIZE,
        "n_channels": len(table.channels) + bool(table.lobes) + bool(table.passes),
        "part_name": table.part_name.encode("ascii"),
    }
    same = {name: getattr(table, name) for name in _SAME}
    limits = {f"limit_{name}": value for name, value in vars(table.limits).items()}
    return bytes_of(HEADER, values | same | limits | vars(table.bounds))


# Fields of an entry that a channel has by the same name: its own, and worked out from its knots.
_OWN = (
    *("kind", "log2_repeat", "frac_bits", "z_first_nm", "z_last_nm"),
    *("value_offset", "p_min", "p_max", "v_max", "a_max"),
)
_WORKED_OUT = ("size", "n_slices", "log2_knots", "slices_per_nm_q48")


def _entry_of(channel: Channel, *, is_ring_helix: bool, has_stations: bool) -> dict[str, int]:
    """Return the fields of a channel's entry but its offset."""
    same = {name: getattr(channel, name) for name in _OWN + _WORKED_OUT}
    is_bent = is_ring_helix if channel.kind == KIND_X else has_stations
    return same | {"path": int(is_bent and channel.kind in OVER_HEIGHT)}


def _plain_entry(table: Table, kind: int, n: int, content: bytes) -> tuple[dict[str, int], bytes]:
    """Return the entry of n records but its offset, most of its fields 0, and the records."""
    place = {"z_first_nm": table.z_first_nm, "z_last_nm": table.z_last_nm}
    size = {"n_slices": n, "size": len(content)}
    nothing = dict.fromkeys((*_OWN, *_WORKED_OUT, "path"), 0)
    return nothing | {"kind": kind} | place | size, content


def crc32_of(image: bytes) -> int:
    """Return the CRC-32 that belongs into an image's header."""
    return zlib.crc32(image[CRC_START:])


def pack(table: Table) -> bytes:
    """Return the image of a table; `unpack` accepts that of a valid one."""
    lobes, passes = table.lobes, table.passes
    bent = {"is_ring_helix": table.is_ring_helix, "has_stations": table.has_stations}
    parts = []
    if lobes:
        parts.append(_plain_entry(table, KIND_LOBES, len(lobes), bytes_of_lobes(lobes)))
    parts += [
        (_entry_of(channel, **bent), channel.knots.astype("<i4").tobytes())
        for channel in table.channels
    ]
    if passes:
        parts.append(_plain_entry(table, KIND_PASSES, len(passes), bytes_of_passes(passes)))
    offset = _aligned(HEADER_SIZE + ENTRY_SIZE * len(parts))
    directory, body = bytes(HEADER_SIZE), b""
    for values, content in parts:
        directory += bytes_of(ENTRY, values | {"offset": offset + len(body)})
        body += content.ljust(_aligned(len(content)), b"\0")
    image = bytearray(directory.ljust(offset, b"\0") + body)
    image[:HEADER_SIZE] = _header_of(table, len(image), 0)
    image[:HEADER_SIZE] = _header_of(table, len(image), crc32_of(bytes(image)))
    return bytes(image)


def unpack(image: bytes) -> Table:
    """Return the table of an image, or the first rule of TABLE_FORMAT.md that it breaks."""
    demand(len(image) >= HEADER_SIZE, "size: shorter than a header")
    header = fields_of(HEADER, image, 0)
    demand(header["magic"] == MAGIC, "magic: not a cam table")
    demand(header["byte_order"] == BYTE_ORDER, "byte_order: image of another byte order")
    version = header["version_major"], header["version_minor"]
    demand(version in (VERSION, NEWER_VERSION), "version: neither 1.0 nor 1.1")
    is_whole = header["image_size"] == len(image) and len(image) % ALIGN == 0
    demand(is_whole, "image_size: not that of the file, which is cut off or has a signature")
    demand(header["crc32"] == crc32_of(image), "crc32: the image is damaged")
    table = _table_of(header)
    n_channels = header["n_channels"]
    demand(
        HEADER_SIZE + ENTRY_SIZE * n_channels <= len(image),
        "n_channels: directory outside the image",
    )
    starts = [HEADER_SIZE + ENTRY_SIZE * i for i in range(n_channels)]
    entries = [fields_of(ENTRY, image, start) for start in starts]
    path = any(entry["path"] for entry in entries if entry["kind"] == KIND_X)
    stands = any(entry["path"] for entry in entries if entry["kind"] == KIND_WAY)
    is_newer = any(entry["kind"] >= KIND_LOBES for entry in entries)
    demand(is_newer == (version == NEWER_VERSION), "version: 1.1 is that of the kinds from 6 on")
    ends_nm = table.z_first_nm, table.z_last_nm
    lobes = lobes_of(image, ends_nm, entries)
    found = _channels_of(image, table, entries, has_patterns=bool(lobes))
    passes = passes_of(image, ends_nm, entries)
    table = replace(table, channels=found, is_ring_helix=path, lobes=lobes, passes=passes)
    table = replace(table, has_stations=stands)
    if table.way is not None:
        ends = (table.way.z_first_nm, table.way.z_last_nm)
        demand(ends == ends_nm, "way: not over the whole table")
        demand(not path and (stands or not lobes), "way: rings have none, lobes have stations")
        check_way(table.way, has_stations=stands)
    demand(table.speed is None or not path, "path: a ring-helix is for one speed")
    _check_lobes(table)
    return table


def _check_lobes(table: Table) -> None:
    if not table.lobes:
        return
    counts = {channel.n_slices for channel in table.channels if channel.has_patterns}
    demand(table.angle is not None and not table.is_ring_helix, "lobes: no channel of their angle")
    demand(len(counts) == 1, "n_slices: channels have not the same patterns")
    is_there = all(lobe.pattern < min(counts) for lobe in table.lobes)
    demand(is_there, "pattern: beyond the slices")


def _table_of(header: dict[str, Any]) -> Table:
    demand(header["header_size"] == HEADER_SIZE, "header_size: not 128")
    demand(1 <= header["n_channels"] <= 8, "n_channels: not 1 .. 8")
    found = re.fullmatch(rb"[\x20-\x7e]{1,31}", header["part_name"])
    demand(found is not None, "part_name: not 1 .. 31 printable ASCII characters")
    demand(header["z_last_nm"] > header["z_first_nm"], "z_last_nm: not above z_first_nm")
    demand(header["direction"] in (1, -1), "direction: not 1 or -1")
    is_moving = header["spindle_mrpm"] > 0 and header["feed_nm"] > 0
    demand(is_moving, "spindle_mrpm, feed_nm: not above 0")
    limits = ImageLimits(
        **{field.name: header[f"limit_{field.name}"] for field in fields(ImageLimits)}
    )
    demand(all(limit > 0 for limit in vars(limits).values()), "limits: not above 0")
    bounds = Bounds(**{field.name: header[field.name] for field in fields(Bounds)})
    demand(bounds.u_max_nm >= bounds.u_min_nm, "u_max_nm: below u_min_nm")
    return Table(
        part_name=header["part_name"].decode("ascii"),
        **{name: header[name] for name in _SAME},
        limits=limits,
        bounds=bounds,
        channels=(),
    )


def _channels_of(
    image: bytes, table: Table, entries: Sequence[dict[str, Any]], *, has_patterns: bool
) -> tuple[Channel, ...]:
    """Return the channels of the directory, checked one by one and together."""
    free, ends_nm = HEADER_SIZE + ENTRY_SIZE * len(entries), (table.z_first_nm, table.z_last_nm)
    channels: list[Channel] = []
    for entry in entries:
        is_plain = entry["kind"] in (KIND_LOBES, KIND_PASSES)
        if not is_plain:
            check_entry(entry, ends_nm, has_patterns=has_patterns)
        offset, size = entry["offset"], entry["size"]
        demand(offset % ALIGN == 0 and offset >= free, "offset: misplaced")
        demand(offset + size <= len(image), "size: beyond the image")
        free = offset + size
        if not is_plain:
            is_pattern = has_patterns and entry["kind"] not in OVER_HEIGHT
            channels.append(replace(_make_channel(image, entry), has_patterns=is_pattern))
    kinds = [channel.kind for channel in channels]
    demand(len(set(kinds)) == len(kinds), "kind: a channel appears twice")
    demand(not {KIND_SWING, KIND_CONTACT} <= set(kinds), "kind: swing and contact are there")
    demand({KIND_U, KIND_X} <= set(kinds), "kind: u or x is missing")
    has_speed = KIND_SPEED in kinds
    demand(
        has_speed or table.bounds.spindle_peak_ppm_per_rad == 0, "spindle_peak_ppm_per_rad: not 0"
    )
    for channel in channels:
        check_knots(channel)
    return tuple(channels)


def _make_channel(image: bytes, entry: dict[str, Any]) -> Channel:
    n_knots = entry["n_slices"] << entry["log2_knots"]
    knots = np.frombuffer(image, KNOT, count=n_knots, offset=entry["offset"])
    triples = np.stack([knots[name] for name in ("p", "v", "a")], axis=-1).astype(np.int32)
    own = {name: entry[name] for name in _OWN}
    return Channel(knots=triples.reshape(entry["n_slices"], -1, 3), **own)
