"""The image format: bytes there and back, and nothing damaged is accepted."""

import re
import struct
import zlib
from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from camtools.skirt.table.generate import GeneratedSkirt
from camtools.table.channel import (
    ENTRY,
    HEADER,
    KIND_U,
    KIND_X,
    SUM_LIMIT,
    Bounds,
    Channel,
    ImageError,
    ImageLimits,
    channel_coefficients,
    largest_sum,
    segment_coefficients,
    slices_per_nm_q48,
)
from camtools.table.image import Table, pack, unpack
from tests.tools.cases.part_cases import ROOT


def small_table(seed: int = 1, n_slices: int = 3, log2_knots: int = 2) -> Table:
    """Return a valid table of random knots."""
    random = np.random.default_rng(seed)
    z = (-1_000_000, 5_000_000)

    def channel(kind: int, n_knots: int) -> Channel:
        knots = random.integers(-9000, 9000, (n_slices, n_knots, 3)).astype(np.int32)
        p = (int(knots[..., 0].min()), int(knots[..., 0].max()))
        return Channel(kind, knots, int(kind == KIND_U), 4, *z, 77, *p, 9000, 9000)

    channels = (channel(KIND_U, 1 << log2_knots), channel(KIND_X, 1))
    limits, bounds = ImageLimits(1, 2, 3, 4), Bounds(-5, 6, 7, 8, 9)
    return Table(f"t{seed}", *z, -1, 2_500_000, 100_000, 0, limits, bounds, channels)


def assert_same(one: Table, other: Table) -> None:
    """Compare two tables field by field."""
    for field in fields(Table):
        if field.name != "channels":
            assert getattr(one, field.name) == getattr(other, field.name)
    for a, b in zip(one.channels, other.channels, strict=True):
        np.testing.assert_array_equal(a.knots, b.knots)
        for field in fields(Channel):
            if field.name != "knots":
                assert getattr(a, field.name) == getattr(b, field.name)


@settings(max_examples=30)
@given(st.integers(0, 10_000), st.integers(2, 9), st.integers(2, 5))
def test_image_round_trip(seed: int, n_slices: int, log2_knots: int) -> None:
    """Unpacking what was packed gives the same table, and packing again the same bytes."""
    table = small_table(seed, n_slices, log2_knots)
    image = pack(table)
    assert_same(unpack(image), table)
    assert pack(unpack(image)) == image
    assert len(image) % 32 == 0


def test_header_bytes_are_where_the_format_says(generated: GeneratedSkirt) -> None:
    """Magic, byte order, version, sizes, CRC and name stand at their offsets."""
    image = pack(generated.table)
    assert image[:8] == bytes.fromhex("43414d5441421a0a")
    assert struct.unpack_from("<IHHII", image, 8) == (
        *(0x01020304, 1, 0, len(image)),
        zlib.crc32(image[24:]),
    )
    assert image[32:64] == b"perkins240".ljust(32, b"\0")
    assert struct.unpack_from("<iiiIII", image, 64) == (
        *(0, 62_000_000, 1, 2_500_000, 100_000, 100_000),
    )
    limits = (1_200_000, 400_000, 250_000, 3_000_000)
    assert struct.unpack_from("<IIII", image, 88) == limits


@given(st.data())
def test_flipped_bit_is_refused(data: st.DataObject) -> None:
    """One flipped bit anywhere makes the image unacceptable."""
    image = bytearray(pack(small_table()))
    place = data.draw(st.integers(0, len(image) * 8 - 1))
    image[place // 8] ^= 1 << place % 8
    with pytest.raises(ImageError):
        unpack(bytes(image))


@pytest.mark.parametrize("length", [0, 1, 127, 128, 400, -1, -32])
def test_image_of_another_size_is_refused(length: int) -> None:
    """An image that lost its end is refused, and one with a signature of earlier versions."""
    image = pack(small_table())
    with pytest.raises(ImageError, match="size"):
        unpack(image[:length])
    with pytest.raises(ImageError, match=r"image_size: .* or has a signature"):
        unpack(image + b"CAMSIG\x1a\n".ljust(128, b"\0"))


def resealed(image: bytearray) -> bytes:
    """Return a changed image with a CRC that fits."""
    struct.pack_into("<I", image, 20, zlib.crc32(image[24:]))
    return bytes(image)


WRONG_FIELDS = [
    (0, "<I", 0, "magic"),
    (8, "<I", 0x04030201, "byte_order"),
    (12, "<H", 2, "version"),
    (14, "<H", 1, "version"),
    (24, "<I", 96, "header_size"),
    (28, "<I", 0, "n_channels"),
    (28, "<I", 9, "n_channels"),
    (32, "<B", 0, "part_name"),
    (33, "<B", 7, "part_name"),
    (68, "<i", -1_000_000, "z_last_nm"),
    (72, "<i", 0, "direction"),
    (76, "<I", 0, "spindle_mrpm"),
    (80, "<I", 0, "feed_nm"),
    (88, "<I", 0, "limits"),
    (108, "<i", -6, "u_max_nm"),
    (124, "<I", 1, "spindle_peak_ppm_per_rad"),
    (128, "<I", 4, "kind"),
    (128, "<I", 2, "log2_knots"),
    (132, "<I", 2**32 - 32, "size: beyond"),
    (132, "<I", 257, "offset"),
    (136, "<I", 2**32 - 1, "size: not that"),
    (140, "<I", 1, "n_slices"),
    (140, "<I", 4097, "n_slices"),
    (144, "<I", 13, "log2_knots"),
    (148, "<I", 5, "log2_repeat"),
    (152, "<I", 17, "frac_bits"),
    (156, "<i", 0, "z: range"),
    (160, "<i", 2**31 - 1, "spacing"),
    (164, "<I", 5, "slices_per_nm_q48"),
    (172, "<i", 2**31 - 1, "p_min"),
    (180, "<I", 0, "v_max"),
    (188, "<I", 1, "path: not 0"),
    (256, "<i", 2**31 - 1, "knots"),
    (256, "<i", -(2**31), "knots"),
]


@pytest.mark.parametrize(("offset", "kind", "value", "rule"), WRONG_FIELDS)
def test_wrong_field_is_named(offset: int, kind: str, value: int, rule: str) -> None:
    """Every kind of wrong field is refused by its name even when the CRC fits."""
    image = bytearray(pack(small_table()))
    struct.pack_into(kind, image, offset, value)
    with pytest.raises(ImageError, match=rule):
        unpack(resealed(image))


def test_missing_and_double_channels_are_refused() -> None:
    """Both u and x must be there, each once."""
    table = small_table()
    u, x = table.channels
    for channels, rule in (((u,), "missing"), ((u, u), "twice"), ((x,), "missing")):
        with pytest.raises(ImageError, match=rule):
            unpack(pack(replace(table, channels=channels)))


@given(st.integers(2, 4096), st.integers(-(2**31), 2**31 - 1), st.floats(65_537, 16_777_216))
def test_reciprocal_of_the_spacing_is_exact(n: int, z_first: int, spacing: float) -> None:
    """slices_per_nm_q48 is within half a unit of the quotient and has 25 to 32 bits."""
    span = max(65_537 * (n - 1), min(int(spacing * (n - 1)), 16_777_216 * (n - 1)))
    q48 = slices_per_nm_q48(n, z_first, z_first + span)
    assert abs(2 * (q48 * span - ((n - 1) << 48))) <= span
    assert 25 <= q48.bit_length() <= 32


@given(st.integers(0, 10_000))
def test_segments_end_exactly_on_the_next_knot(seed: int) -> None:
    """Value and both derivatives of a quintic at its end are the next knot's, in integers."""
    knots = np.random.default_rng(seed).integers(-(2**25), 2**25, (8, 3))
    c = segment_coefficients(knots, periodic=True)
    n = np.arange(6)
    following = np.roll(knots, -1, axis=0)
    np.testing.assert_array_equal(c.sum(axis=1), following[:, 0])
    np.testing.assert_array_equal((c * n).sum(axis=1), following[:, 1])
    np.testing.assert_array_equal((c * n * (n - 1)).sum(axis=1), 2 * following[:, 2])


def test_generated_table_keeps_the_overflow_bound(generated: GeneratedSkirt) -> None:
    """All three sums of every segment are at most 2^25 - 1, and one bit more would not fit."""
    for channel in generated.table.channels:
        most = largest_sum(channel_coefficients(channel))
        assert SUM_LIMIT / 2.1 < most <= SUM_LIMIT


FORMAT = ROOT / "firmware" / "table" / "TABLE_FORMAT.md"
TYPES = {"u8[8]": "S8", "u8[32]": "S32", "u16": "<u2", "u32": "<u4", "i32": "<i4"}


@pytest.mark.parametrize(
    ("title", "record"),
    [("## Header", HEADER), ("## Channel entry", ENTRY)],
    ids=["header", "entry"],
)
def test_records_are_those_of_the_document(title: str, record: np.dtype[np.void]) -> None:
    """Offset, type and name of every field stand in TABLE_FORMAT.md, and nothing else does."""
    section = FORMAT.read_text("utf-8").split(f"\n{title} ", 1)[1].split("\n## ", 1)[0]
    rows = re.findall(r"^\| (\d+) \| (\S+) \| (\w+) \|", section, re.MULTILINE)
    told = [(int(offset), np.dtype(TYPES[kind]), name) for offset, kind, name in rows]
    assert record.fields is not None
    assert told == [(field[1], field[0], name) for name, field in record.fields.items()]
