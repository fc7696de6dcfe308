"""The table image, bytes <-> dataclasses, exactly as firmware/table/TABLE_FORMAT.md.

>>> slices_per_nm_q48(32, 0, 62_000_000)
140737488
"""

from __future__ import annotations

import re
import struct
import zlib
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

Knots = npt.NDArray[np.int32]
Ints = npt.NDArray[np.int64]

MAGIC = b"CAMTAB\x1a\n"
BYTE_ORDER = 0x01020304
KIND_U, KIND_X, KIND_SPEED, KIND_SWING, KIND_CONTACT = 1, 2, 3, 4, 5
RATIO_ONE = 1 << 20  # unit of a speed ratio's values, where u and x count nanometres
MIN_RATIO, MAX_RATIO = RATIO_ONE // 16, RATIO_ONE * 4
ANGLE_TURN, ANGLE_MAX = 1 << 26, 1 << 24  # unit of swing and contact; a quarter turn
HEADER_SIZE, ENTRY_SIZE, ALIGN, KNOT_SIZE = 128, 64, 32, 12
CRC_OFFSET, CRC_START = 20, 24
MAX_CHANNEL_BYTES = 1 << 20  # the generators make no larger one
SUM_LIMIT = 2**25 - 1
MIN_SPACING_NM, MAX_SPACING_NM = 65_537, 16_777_216
MAX_SLICES, MAX_LOG2_KNOTS, MIN_LOG2_KNOTS, MAX_LOG2_REPEAT, MAX_FRAC_BITS = 4096, 12, 2, 4, 8
_HEADER = struct.Struct("<8sIHHIIII32siiiIIIIIIIiiIIII")
_ENTRY = struct.Struct("<IIIIIIIiiIiiiIII")


class ImageError(Exception):
    """An image that the firmware would refuse; says which rule it breaks first."""


@dataclass(frozen=True)
class Limits:
    """U limits and spindle limit of the machine the table was made for, in the image's units."""

    u_stroke_nm: int
    u_speed_um_s: int
    u_acceleration_mm_s2: int
    spindle_mrpm: int


@dataclass(frozen=True)
class Bounds:
    """What the generator guarantees of u over the whole table, and the error it achieved.

    The peaks are velocity and acceleration of U over mean speed and its square; where the spindle
    speed is modulated, its ratio r is in them: u' r and u'' r^2 + u' r r'.
    """

    u_min_nm: int
    u_max_nm: int
    u1_peak_nm_per_rad: int
    u2_peak_nm_per_rad2: int
    error_pm: int
    spindle_peak_ppm: int = 0  # of r r', in 1e-6 per rad; 0 without modulation


@dataclass(frozen=True, eq=False)
class Channel:
    """One channel of a table.

    Attributes
    ----------
    kind : int
        KIND_U, KIND_X, KIND_SPEED, KIND_SWING or KIND_CONTACT.
    knots : ndarray of int32, shape (n_slices, n_knots, 3)
        (p, v, a) of each knot, LSB 2^-frac_bits nm, of speed 2^-frac_bits 2^-20, of
        swing and contact 2^-frac_bits 2^-26 turn; n_knots = 1 for x.
    log2_repeat : int
        The pattern repeats 2^log2_repeat times per turn; 0 for x.
    frac_bits : int
        0 .. 16.
    z_first_nm, z_last_nm : int
        Heights of the first and the last slice.
    offset_nm : int
        Value at p = 0.
    p_min, p_max, v_max, a_max : int
        Bounds of p and of the magnitudes of v and a.
    """

    kind: int
    knots: Knots
    log2_repeat: int
    frac_bits: int
    z_first_nm: int
    z_last_nm: int
    offset_nm: int
    p_min: int
    p_max: int
    v_max: int
    a_max: int

    @property
    def n_slices(self) -> int:
        """Number of slices (of knots over height for x)."""
        return int(self.knots.shape[0])

    @property
    def log2_knots(self) -> int:
        """Base-2 logarithm of the knots per slice."""
        return int(self.knots.shape[1]).bit_length() - 1

    @property
    def size(self) -> int:
        """Bytes of knots."""
        return int(self.knots.size) * 4

    @property
    def lsb_nm(self) -> float:
        """Value of one unit of the knots."""
        return float(2.0**-self.frac_bits)

    @property
    def slices_per_nm_q48(self) -> int:
        """Reciprocal of the slice spacing."""
        return slices_per_nm_q48(self.n_slices, self.z_first_nm, self.z_last_nm)


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
    limits: Limits
    bounds: Bounds
    channels: tuple[Channel, ...]
    is_ring_helix: bool = False  # a geared Z follows a ring-helix, not a helix

    def channel(self, kind: int) -> Channel:
        """Return the channel of this kind; `unpack` makes sure that u and x exist."""
        return next(channel for channel in self.channels if channel.kind == kind)

    @property
    def speed(self) -> Channel | None:
        """Return the speed ratio, when the table modulates the spindle."""
        return next((one for one in self.channels if one.kind == KIND_SPEED), None)

    @property
    def angle(self) -> Channel | None:
        """Return the angle of the normal at the contact, when the table is that of a cam."""
        kinds = (KIND_SWING, KIND_CONTACT)
        return next((one for one in self.channels if one.kind in kinds), None)


def slices_per_nm_q48(n_slices: int, z_first_nm: int, z_last_nm: int) -> int:
    """Return round((n - 1) 2^48 / (z_last - z_first)), half up, in exact integers."""
    span_nm = z_last_nm - z_first_nm
    return (((n_slices - 1) << 49) + span_nm) // (2 * span_nm)


def segment_coefficients(knots: Ints, *, periodic: bool) -> Ints:
    """Return the quintics between neighbouring knots, exactly, MATHS.md (46).

    Parameters
    ----------
    knots : ndarray of int64, shape (..., n, 3)
        Triples (p, v, a) along the second last axis.
    periodic : bool
        Whether the first knot follows the last one.

    Returns
    -------
    ndarray of int64, shape (..., n, 6) or (..., n - 1, 6)
        c0 .. c5 of each segment in t = 0 .. 1, LSB as the knots.
    """
    left = knots if periodic else knots[..., :-1, :]
    right = np.roll(knots, -1, axis=-2) if periodic else knots[..., 1:, :]
    p, v, a = left[..., 0], left[..., 1], left[..., 2]
    dp = right[..., 0] - p - v - a
    dv = right[..., 1] - v - 2 * a
    da = right[..., 2] - a
    c3, c4, c5 = 10 * dp - 4 * dv + da, -15 * dp + 7 * dv - 2 * da, 6 * dp - 3 * dv + da
    return np.stack([p, v, a, c3, c4, c5], axis=-1)


def channel_coefficients(channel: Channel) -> Ints:
    """Return the quintics of a channel: u (n_slices, n_knots, 6), x (n_slices - 1, 6)."""
    knots = channel.knots.astype(np.int64)
    if channel.kind == KIND_X:
        return segment_coefficients(knots[:, 0], periodic=False)
    return segment_coefficients(knots, periodic=True)


_SUM_WEIGHTS = np.array([[1, 1, 1, 1, 1, 1], [0, 1, 2, 3, 4, 5], [0, 0, 2, 6, 12, 20]])


def largest_sum(coefficients: Ints) -> int:
    """Return the largest of the three sums of TABLE_FORMAT.md over all segments."""
    return int((np.abs(coefficients) @ _SUM_WEIGHTS.T).max())


def _aligned(size: int) -> int:
    return -(-size // ALIGN) * ALIGN


def _offsets(channels: tuple[Channel, ...]) -> list[int]:
    offsets = [_aligned(HEADER_SIZE + ENTRY_SIZE * len(channels))]
    for channel in channels:
        offsets.append(_aligned(offsets[-1] + channel.size))
    return offsets


def _pack_header(table: Table, image_size: int, crc32: int) -> bytes:
    limits, bounds = table.limits, table.bounds
    return _HEADER.pack(
        *(MAGIC, BYTE_ORDER, 1, 0, image_size, crc32, HEADER_SIZE, len(table.channels)),
        *(table.part_name.encode("ascii"), table.z_first_nm, table.z_last_nm, table.direction),
        *(table.spindle_mrpm, table.feed_nm, table.depth_nm, limits.u_stroke_nm),
        *(limits.u_speed_um_s, limits.u_acceleration_mm_s2, limits.spindle_mrpm),
        *(bounds.u_min_nm, bounds.u_max_nm, bounds.u1_peak_nm_per_rad),
        *(bounds.u2_peak_nm_per_rad2, bounds.error_pm, bounds.spindle_peak_ppm),
    )


def _pack_entry(channel: Channel, offset: int, *, is_ring_helix: bool) -> bytes:
    path = int(is_ring_helix and channel.kind == KIND_X)
    return _ENTRY.pack(
        *(channel.kind, offset, channel.size, channel.n_slices, channel.log2_knots),
        *(channel.log2_repeat, channel.frac_bits, channel.z_first_nm, channel.z_last_nm),
        *(channel.slices_per_nm_q48, channel.offset_nm, channel.p_min, channel.p_max),
        *(channel.v_max, channel.a_max, path),
    )


def crc32_of(image: bytes) -> int:
    """Return the CRC-32 that belongs into an image's header."""
    return zlib.crc32(image[CRC_START:])


def pack(table: Table) -> bytes:
    """Return the image of a table; a valid table gives an image that `unpack` accepts.

    Raises
    ------
    struct.error
        A number does not fit its field.
    """
    offsets = _offsets(table.channels)
    image = bytearray(offsets[-1])
    image[:HEADER_SIZE] = _pack_header(table, len(image), 0)
    for i, (channel, offset) in enumerate(zip(table.channels, offsets, strict=False)):
        entry = HEADER_SIZE + ENTRY_SIZE * i
        image[entry : entry + ENTRY_SIZE] = _pack_entry(
            channel, offset, is_ring_helix=table.is_ring_helix
        )
        image[offset : offset + channel.size] = channel.knots.astype("<i4").tobytes()
    struct.pack_into("<I", image, CRC_OFFSET, crc32_of(bytes(image)))
    return bytes(image)


def _demand(condition: bool, rule: str) -> None:
    if not condition:
        raise ImageError(rule)


def unpack(image: bytes) -> Table:
    """Return the table of an image, checked as the firmware checks it.

    Raises
    ------
    ImageError
        The first rule of TABLE_FORMAT.md that the image breaks.
    """
    _demand(len(image) >= HEADER_SIZE, "size: shorter than a header")
    fields = _HEADER.unpack_from(image)
    _demand(fields[0] == MAGIC, "magic: not a cam table")
    _demand(fields[1] == BYTE_ORDER, "byte_order: image of another byte order")
    _demand(fields[2:4] == (1, 0), "version: not 1.0")
    _demand(fields[4] == len(image) and len(image) % ALIGN == 0, "image_size: not that of the file")
    _demand(fields[5] == crc32_of(image), "crc32: the image is damaged")
    table = _unpack_header(fields)
    channels = _unpack_channels(image, table, fields[7])
    path = any(
        _ENTRY.unpack_from(image, HEADER_SIZE + ENTRY_SIZE * i)[15] for i in range(fields[7])
    )
    table = replace(table, channels=channels, is_ring_helix=path)
    _demand(table.speed is None or not path, "path: a ring-helix is for one speed")
    return table


def _unpack_header(fields: tuple[Any, ...]) -> Table:
    _demand(fields[6] == HEADER_SIZE, "header_size: not 128")
    _demand(1 <= fields[7] <= 8, "n_channels: not 1 .. 8")
    found = re.fullmatch(rb"[\x20-\x7e]{1,31}\x00+", fields[8])
    _demand(found is not None, "part_name: not 1 .. 31 printable ASCII characters")
    name = fields[8].rstrip(b"\0").decode("ascii")
    _demand(fields[10] > fields[9], "z_last_nm: not above z_first_nm")
    _demand(fields[11] in (1, -1), "direction: not 1 or -1")
    _demand(fields[12] > 0 and fields[13] > 0, "spindle_mrpm, feed_nm: not above 0")
    _demand(all(limit > 0 for limit in fields[15:19]), "limits: not above 0")
    _demand(fields[20] >= fields[19], "u_max_nm: below u_min_nm")
    limits, bounds = Limits(*fields[15:19]), Bounds(*fields[19:25])
    z_first, z_last, direction, mrpm, feed, depth = fields[9:15]
    return Table(name, z_first, z_last, direction, mrpm, feed, depth, limits, bounds, ())


def _unpack_channels(image: bytes, table: Table, n_channels: int) -> tuple[Channel, ...]:
    free = HEADER_SIZE + ENTRY_SIZE * n_channels
    _demand(free <= len(image), "n_channels: directory outside the image")
    channels: list[Channel] = []
    for i in range(n_channels):
        entry = _ENTRY.unpack_from(image, HEADER_SIZE + ENTRY_SIZE * i)
        offset, size = entry[1], entry[2]
        _check_entry(entry, table)
        _demand(offset % ALIGN == 0 and offset >= free, "offset: misplaced")
        _demand(offset + size <= len(image), "size: beyond the image")
        free = offset + size
        channels.append(_make_channel(image, entry))
    kinds = [channel.kind for channel in channels]
    _demand(len(set(kinds)) == len(kinds), "kind: a channel is there twice")
    _demand(not {KIND_SWING, KIND_CONTACT} <= set(kinds), "kind: swing and contact are there")
    _demand({KIND_U, KIND_X} <= set(kinds), "kind: u or x is missing")
    has_speed = KIND_SPEED in kinds
    _demand(has_speed or table.bounds.spindle_peak_ppm == 0, "spindle_peak_ppm: not 0")
    for channel in channels:
        _check_knots(channel)
    return tuple(channels)


def _check_entry(entry: tuple[Any, ...], table: Table) -> None:
    kind, _, size, n_slices, log2_knots, log2_repeat, frac_bits, z_first, z_last, q48 = entry[:10]
    _demand(KIND_U <= kind <= KIND_CONTACT, "kind: unknown")
    _demand(2 <= n_slices <= MAX_SLICES, "n_slices: not 2 .. 4096")
    if kind != KIND_X:
        _demand(MIN_LOG2_KNOTS <= log2_knots <= MAX_LOG2_KNOTS, "log2_knots: not 2 .. 12")
        _demand(log2_repeat <= MAX_LOG2_REPEAT, "log2_repeat: not 0 .. 4")
    else:
        _demand(log2_knots == 0 and log2_repeat == 0, "log2_knots, log2_repeat: not 0 for x")
    _demand(size == (n_slices << log2_knots) * KNOT_SIZE, "size: not that of the knots")
    _demand(frac_bits <= MAX_FRAC_BITS, "frac_bits: not 0 .. 8")
    _demand(z_first <= table.z_first_nm and z_last >= table.z_last_nm, "z: range not covered")
    span_nm, n = z_last - z_first, n_slices - 1
    _demand(n * MIN_SPACING_NM <= span_nm <= n * MAX_SPACING_NM, "spacing: not 65537 .. 16777216")
    _demand(q48 == slices_per_nm_q48(n_slices, z_first, z_last), "slices_per_nm_q48: wrong")
    _demand(entry[15] <= int(kind == KIND_X), "path: not 0 or, of x, 1")
    low, high = (entry[10] * 2**frac_bits + p for p in entry[11:13])
    if kind == KIND_SPEED:
        is_ratio = low >= MIN_RATIO << frac_bits and high <= MAX_RATIO << frac_bits
        _demand(is_ratio, "p_min, p_max: no speed ratio of 1/16 .. 4")
    if kind in (KIND_SWING, KIND_CONTACT):
        is_angle = low >= -ANGLE_MAX << frac_bits and high <= ANGLE_MAX << frac_bits
        _demand(is_angle, "p_min, p_max: beyond a quarter turn")


def _make_channel(image: bytes, entry: tuple[Any, ...]) -> Channel:
    knots = np.frombuffer(image, dtype="<i4", count=entry[2] // 4, offset=entry[1])
    shape = (entry[3], 1 << entry[4], 3)
    return Channel(*(entry[0], knots.astype(np.int32).reshape(shape)), *entry[5:9], *entry[10:15])


def _check_knots(channel: Channel) -> None:
    knots = channel.knots.astype(np.int64)
    p, v, a = knots[..., 0], np.abs(knots[..., 1]), np.abs(knots[..., 2])
    _demand(int(np.abs(knots).max()) <= SUM_LIMIT, "knots: beyond 2^25 - 1")
    _demand(channel.p_min <= int(p.min()) and int(p.max()) <= channel.p_max, "p_min, p_max: wrong")
    _demand(int(v.max()) <= channel.v_max and int(a.max()) <= channel.a_max, "v_max, a_max: wrong")
    _demand(largest_sum(channel_coefficients(channel)) <= SUM_LIMIT, "knots: could overflow")
