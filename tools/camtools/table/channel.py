"""Channels of a table, before they are an image: knots, kinds, bounds, quintics, mirrored ones.

The drawing's angle phi counts the same way round whatever the spindle does (PARTFILE.md, "The
drawing's angle"). The angle of a table counts in the sense of cutting: phi with M3, -phi with M4.
Generators make channels over the drawing's angle, and `table_of` hands all of them to `in_sense`
for `process.direction = -1`, so a kind of part has nothing else to do. What a table says about
angles beside its channels, such as the phase of a pattern, goes through `angle_in_sense`.

Values keep their signs, the swing's and the contact's too: tool and follower stand still in the
machine, and at the same angle phi the same part lies before them in the same place, so the normal
at the contact has the same direction in space. Only derivatives by the angle change their signs.

Records, lobes and passes are exactly those of firmware/table/TABLE_FORMAT.md.

>>> knots = np.array([[[0, 5, 1], [10, 6, 2], [20, 7, 3], [30, 8, 4]]], dtype=np.int32)
>>> channel = Channel(KIND_U, knots, 0, 0, 0, 1_000_000, 0, 0, 30, 8, 4)
>>> in_sense(channel, -1).knots[0].tolist()
[[0, -5, 1], [30, -8, 4], [20, -7, 3], [10, -6, 2]]
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from camtools.base.quantities import Ints


def _record(fields: str) -> np.dtype[np.void]:
    """Return a record of fields, name and type of each."""
    return np.dtype([(name, kind) for kind, name in (field.split() for field in fields.split(","))])


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
    row = np.zeros((), record)
    for name, value in values.items():
        row[name] = value
    return row.tobytes()


def fields_of(record: np.dtype[np.void], image: bytes, offset: int) -> dict[str, Any]:
    """Return the fields of a record as Python's own numbers and bytes."""
    [row] = np.frombuffer(image, record, count=1, offset=offset).tolist()
    return dict(zip(record.names or (), row, strict=True))


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
    image: bytes, ends_nm: tuple[int, int], entries: Sequence[dict[str, Any]]
) -> tuple[LobePlace, ...]:
    """Return the lobes of an image, checked as far as the directory alone shows; empty without."""
    places = [i for i, entry in enumerate(entries) if entry["kind"] == KIND_LOBES]
    if not places:
        return ()
    demand(places == [0], "kind: lobes are not the first channel alone")
    rows = listed("lobes", MAX_LOBES, _LOBE, image, entries[0], ends_nm)
    lobes = tuple(LobePlace(*row[:4]) for row in rows)
    demand(
        all(lobe.z_last_nm > lobe.z_first_nm for lobe in lobes), "lobes: one ends below its begin"
    )
    ends = (lobes[0].z_first_nm, lobes[-1].z_last_nm)
    demand(ends == ends_nm, "lobes: ends differ from the table's")
    gaps = [above.z_first_nm - below.z_last_nm for below, above in pairwise(lobes)]
    demand(min(gaps, default=LEAST_GAP_NM) >= LEAST_GAP_NM, "lobes: a gap below 0.2 mm")
    demand([row[4] for row in rows] == _reciprocals(lobes), "changes_per_nm_q48: wrong")
    return lobes


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
    return np.array([(*record, 0) for record in passes], _PASS).tobytes()


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
    is_moving = all(record.feed_nm > 0 and record.spindle_mrpm > 0 for record in passes)
    demand(is_moving and not any(row[3] for row in rows), "passes: feed, speed or reserved wrong")
    return passes


Numbers = TypeVar("Numbers", npt.NDArray[np.int64], npt.NDArray[np.float64])


def segment_coefficients(knots: Numbers, *, periodic: bool) -> Numbers:
    """Return the quintics between neighbouring knots, of integers exactly, MATHS.md (46).

    `knots`, shape (..., n, 3): triples (p, v, a) along the second last axis. `periodic`: whether
    the first knot follows the last one. Returns shape (..., n, 6) or (..., n - 1, 6): c0 .. c5 of
    each segment in t = 0 .. 1, LSB as the knots.
    """
    left = knots if periodic else knots[..., :-1, :]
    right = np.roll(knots, -1, axis=-2) if periodic else knots[..., 1:, :]
    p, v, a = left[..., 0], left[..., 1], left[..., 2]
    dp = right[..., 0] - p - v - a
    dv = right[..., 1] - v - 2 * a
    da = right[..., 2] - a
    c3, c4, c5 = 10 * dp - 4 * dv + da, -15 * dp + 7 * dv - 2 * da, 6 * dp - 3 * dv + da
    return np.stack([p, v, a, c3, c4, c5], axis=-1)


Knots = npt.NDArray[np.int32]

KIND_U, KIND_X, KIND_SPEED, KIND_SWING, KIND_CONTACT, KIND_WAY = 1, 2, 3, 4, 5, 7
OVER_HEIGHT = (KIND_X, KIND_WAY)  # one knot per slice
RATIO_ONE = 1 << 20  # unit of a speed ratio's values, where u and x count nanometres
MIN_RATIO, MAX_RATIO = RATIO_ONE // 16, RATIO_ONE * 4
ANGLE_TURN, ANGLE_MAX = 1 << 26, 1 << 24  # unit of swing and contact; a quarter turn
DEG_PER_UNIT = 360 / ANGLE_TURN
ALIGN = 32
LEAST_FEED = 0.02  # of its mean: a way that falls below is refused
BEYOND_NM = 1000  # with stations: rounding of knots of a Z that stands
MAX_HEIGHT_NM = 1_000_000_000
MAX_CHANNEL_BYTES = 1 << 20  # the generators make no larger one
SUM_LIMIT = 2**25 - 1
MIN_SPACING_NM, MAX_SPACING_NM = 65_537, 16_777_216
MAX_SLICES, MAX_LOG2_KNOTS, MIN_LOG2_KNOTS, MAX_LOG2_REPEAT, MAX_FRAC_BITS = 4096, 12, 2, 4, 8


@dataclass(frozen=True)
class ImageLimits:
    """U limits and spindle limit of the machine the table was made for, in the image's units."""

    u_stroke_nm: int
    u_speed_um_per_s: int
    u_acceleration_mm_per_s2: int
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
    spindle_peak_ppm_per_rad: int = 0  # of r r', in 1e-6 per rad; 0 without modulation


@dataclass(frozen=True, eq=False)
class Channel:
    """One channel of a table."""

    kind: int  # KIND_U, KIND_X, KIND_SPEED, KIND_SWING or KIND_CONTACT
    knots: Knots  # (p, v, a), shape (n_slices, n_knots, 3); n_knots = 1 over height
    log2_repeat: int  # the pattern repeats 2^log2_repeat times per turn; 0 for x
    frac_bits: int  # LSB 2^-frac_bits nm, of speed 2^-20 and of angles 2^-26 turn of that
    z_first_nm: int  # height of the first slice
    z_last_nm: int  # height of the last slice
    value_offset: int  # value at p = 0, in the unit of the channel
    p_min: int
    p_max: int
    v_max: int  # of the magnitude, as a_max
    a_max: int
    has_patterns: bool = False  # slices are patterns of lobes, found by number, not height

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
    def lsb(self) -> float:
        """Value of one unit of the knots, in the unit of the channel: nm for u and x."""
        return float(2.0**-self.frac_bits)

    @property
    def slices_per_nm_q48(self) -> int:
        """Reciprocal of the slice spacing; 0 of patterns."""
        if self.has_patterns:
            return 0
        return slices_per_nm_q48(self.n_slices, self.z_first_nm, self.z_last_nm)


def slices_per_nm_q48(n_slices: int, z_first_nm: int, z_last_nm: int) -> int:
    """Return round((n - 1) 2^48 / (z_last - z_first)), half up, in exact integers."""
    span_nm = z_last_nm - z_first_nm
    return (((n_slices - 1) << 49) + span_nm) // (2 * span_nm)


def channel_coefficients(channel: Channel) -> Ints:
    """Return the quintics of a channel: u (n_slices, n_knots, 6), x (n_slices - 1, 6)."""
    knots = channel.knots.astype(np.int64)
    if channel.kind in OVER_HEIGHT:
        return segment_coefficients(knots[:, 0], periodic=False)
    return segment_coefficients(knots, periodic=True)


_SUM_WEIGHTS = np.array([[1, 1, 1, 1, 1, 1], [0, 1, 2, 3, 4, 5], [0, 0, 2, 6, 12, 20]])


def largest_sum(coefficients: Ints) -> int:
    """Return the largest of the three sums of TABLE_FORMAT.md over all segments."""
    return int((np.abs(coefficients) @ _SUM_WEIGHTS.T).max())


def _check_heights(entry: dict[str, Any], ends_nm: tuple[int, int], *, has_patterns: bool) -> None:
    """Check the range of heights and the spacing; patterns are those of the whole table."""
    z_first, z_last, n = entry["z_first_nm"], entry["z_last_nm"], entry["n_slices"] - 1
    if has_patterns and entry["kind"] not in OVER_HEIGHT:
        demand(
            (z_first, z_last) == ends_nm and entry["slices_per_nm_q48"] == 0,
            "z: not that of patterns",
        )
        return
    demand(z_first <= ends_nm[0] and z_last >= ends_nm[1], "z: range not covered")
    span_nm = z_last - z_first
    demand(n * MIN_SPACING_NM <= span_nm <= n * MAX_SPACING_NM, "spacing: not 65537 .. 16777216")
    q48 = slices_per_nm_q48(n + 1, z_first, z_last)
    demand(entry["slices_per_nm_q48"] == q48, "slices_per_nm_q48: wrong")


def check_entry(entry: dict[str, Any], ends_nm: tuple[int, int], *, has_patterns: bool) -> None:
    """Check the entry of a channel in the directory; `ends_nm`: heights of the whole table."""
    kind, n_slices, log2_knots = entry["kind"], entry["n_slices"], entry["log2_knots"]
    frac_bits = entry["frac_bits"]
    demand(KIND_U <= kind <= KIND_CONTACT or kind == KIND_WAY, "kind: unknown")
    demand(2 <= n_slices <= MAX_SLICES, "n_slices: not 2 .. 4096")
    if kind not in OVER_HEIGHT:
        demand(MIN_LOG2_KNOTS <= log2_knots <= MAX_LOG2_KNOTS, "log2_knots: not 2 .. 12")
        demand(entry["log2_repeat"] <= MAX_LOG2_REPEAT, "log2_repeat: not 0 .. 4")
    else:
        is_flat = log2_knots == 0 and entry["log2_repeat"] == 0
        demand(is_flat, "log2_knots, log2_repeat: not 0 over height alone")
    is_sized = entry["size"] == (n_slices << log2_knots) * KNOT_SIZE
    demand(is_sized, "size: not that of the knots")
    demand(frac_bits <= MAX_FRAC_BITS, "frac_bits: not 0 .. 8")
    _check_heights(entry, ends_nm, has_patterns=has_patterns)
    demand(entry["path"] <= int(kind in OVER_HEIGHT), "path: not 0 or, of x and way, 1")
    low, high = ((entry["value_offset"] << frac_bits) + entry[name] for name in ("p_min", "p_max"))
    if kind == KIND_SPEED:
        is_ratio = low >= MIN_RATIO << frac_bits and high <= MAX_RATIO << frac_bits
        demand(is_ratio, "p_min, p_max: no speed ratio of 1/16 .. 4")
    if kind in (KIND_SWING, KIND_CONTACT):
        is_angle = low >= -ANGLE_MAX << frac_bits and high <= ANGLE_MAX << frac_bits
        demand(is_angle, "p_min, p_max: beyond a quarter turn")


def _check_within(way: Channel, zero: int, span_nm: int, risen_nm: int) -> None:
    """Check that Z stays between its first and its last height, by its Bernstein coefficients."""
    p, v, a = way.knots[:, 0].astype(np.int64).T
    low, high = 10 * (p[:-1] - zero), 10 * (p[1:] - zero)  # the coefficients, times 10
    from_low = [low, low + 2 * v[:-1], low + 4 * v[:-1] + a[:-1]]
    tenfold = np.stack([*from_low, high - 4 * v[1:] + a[1:], high - 2 * v[1:], high], axis=1)
    fifths = 5 * np.arange(p.size - 1)[:, None] + np.arange(6)
    tenth_nm = 10 * fifths * span_nm // (5 * (p.size - 1)) + (tenfold >> way.frac_bits)
    room_nm = 10 * BEYOND_NM
    is_within = -room_nm <= tenth_nm.min() and tenth_nm.max() <= 10 * risen_nm + room_nm
    demand(bool(is_within), "way: Z leaves the heights between its first and its last")


def check_way(way: Channel, *, has_stations: bool) -> None:
    """Check that a way begins and ends with 0, and that Z rises.

    With stations Z may stand and go back, but stays between its first and its last height.
    """
    zero = -(way.value_offset << way.frac_bits)
    p, v, a = way.knots[:, 0].astype(np.int64).T
    span_nm = way.z_last_nm - way.z_first_nm
    risen_nm = span_nm + way.value_offset + (int(p[-1]) >> way.frac_bits)
    is_reached = 0 <= risen_nm <= MAX_HEIGHT_NM - way.z_first_nm
    is_ended = is_reached if has_stations else int(p[-1]) == zero
    demand(int(p[0]) == zero and is_ended, "way: does not begin and end with 0")
    if has_stations:
        _check_within(way, zero, span_nm, risen_nm)
        return
    inner = [v[:-1], v[:-1] + a[:-1] / 2, v[1:] - a[1:] / 2, v[1:]]
    middle = 5 * np.diff(p) - sum(inner)  # Bernstein coefficients of the slope: MATHS.md (51)
    plain = (span_nm << way.frac_bits) / (way.n_slices - 1)
    least = plain + float(np.min([*inner, middle]))
    demand(least >= LEAST_FEED * plain, "way: Z reverses or nearly stops")


def check_knots(channel: Channel) -> None:
    """Check knots, their bounds and their sums as the firmware does."""
    knots = channel.knots.astype(np.int64)
    p, v, a = knots[..., 0], np.abs(knots[..., 1]), np.abs(knots[..., 2])
    demand(int(np.abs(knots).max()) <= SUM_LIMIT, "knots: beyond 2^25 - 1")
    demand(channel.p_min <= int(p.min()) and int(p.max()) <= channel.p_max, "p_min, p_max: wrong")
    demand(int(v.max()) <= channel.v_max and int(a.max()) <= channel.a_max, "v_max, a_max: wrong")
    demand(largest_sum(channel_coefficients(channel)) <= SUM_LIMIT, "knots: could overflow")


def in_sense(channel: Channel, direction: int) -> Channel:
    """Return a channel over the drawing's angle in the sense of cutting, or the other way round.

    Knot k becomes knot -k of the pattern: (p, v, a) -> (p, -v, a), exactly, so the mirror of the
    mirror is the same channel. Bounds stay, and so does the size. A channel over height alone
    stays as it is. `quantise` makes no channel whose mirror would overflow.
    `direction`: `process.direction`: 1 (M3) changes nothing, -1 (M4) mirrors.
    """
    if direction == 1 or channel.kind in OVER_HEIGHT:
        return channel
    turned = np.roll(channel.knots[:, ::-1], 1, axis=1) * np.array([1, -1, 1], dtype=np.int32)
    return replace(channel, knots=turned)


def angle_in_sense(angle: float, direction: int) -> float:
    """Return a drawing's angle in the sense of cutting, or the other way round, in any unit."""
    return angle if direction == 1 else -angle
