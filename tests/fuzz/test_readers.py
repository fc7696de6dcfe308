"""Readers of the tools take any bytes: they read them, or refuse them by an error of ours.

Real files are changed byte by byte, and pieces of one are put into another. CAMTURN_EXAMPLES sets
how often each reader is asked; a longer run takes other changes each time.
"""

import math
import os
import zlib
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from camtools.base.errors import CamtoolsError
from camtools.forecast.vary import read_vary
from camtools.identify.foreign_record import MIN_ROWS, parse_record
from camtools.link.kept_values import INFOS, N_VALUES, learned_text, learned_values
from camtools.link.kept_values import parse as parse_parameters
from camtools.measured.points import parse_points as parse_measured
from camtools.pipeline.load import parse as parse_part
from camtools.sim.machine_file import read_machine
from camtools.skirt.geometry.scan import parse_scan
from camtools.skirt.geometry.section_file import parse_sections
from camtools.table.channel import ImageError
from camtools.table.image import unpack
from camtools.table.points import parse_points
from tests.tools.cases.part_cases import ROOT

Reader = Callable[[bytes], object]
MACHINES = ROOT / "host_sim" / "machines"
N_EXAMPLES = int(os.environ.get("CAMTURN_EXAMPLES", "60"))
MOST_BYTES = 6000
CRC_AT = 20
CRC_FROM = 24


def text_of(reader: Callable[[str, str], object]) -> Reader:
    """Return a reader of bytes for one of text, as its caller decodes a file."""
    return lambda data: reader(data.decode("utf-8", "replace"), "input")


def named(reader: Callable[[bytes, str], object]) -> Reader:
    """Return a reader of bytes alone."""
    return lambda data: reader(data, "input")


def vary(data: bytes) -> object:
    """Read a file of what varies, of a machine whose values are not 0."""
    machine = read_machine((MACHINES / "real.toml").read_text("utf-8"), "real")
    return read_vary(data, "input", machine)


def sealed(data: bytes) -> object:
    """Read an image whose CRC is made right, as nothing gets beyond a wrong one."""
    size = len(data).to_bytes(4, "little")
    crc = zlib.crc32(data[CRC_FROM:]).to_bytes(4, "little")
    return unpack(data[: CRC_AT - 4] + size + crc + data[CRC_FROM:])


def files(*patterns: str) -> tuple[bytes, ...]:
    """Return the begins of files of the repository, in whole lines."""
    found = [path for pattern in patterns for path in sorted(ROOT.glob(pattern))]
    assert found, patterns
    begins = (path.read_bytes()[:MOST_BYTES] for path in found)
    return tuple(begin[: begin.rindex(b"\n") + 1] for begin in begins)


POINTS = b"angle_deg,radius_mm\n0,45.0\n1.5,45.01\n360,45\n"
HEIGHTS = b"turn,z_mm,radius_mm\n0,1,45.0\n0.25,1,44.9\n0.5,1,45\n0.75,1,44.9\n"
MOVED = "".join(f"{i};{i % 7};{i % 5}\n" for i in range(MIN_ROWS))
RECORD = f"time_ms;force_n;position_um\n{MOVED}".encode()
TRACE = "".join(f"{angle},0,{angle % 7}\n" for angle in range(0, 360, 5))
GAUGED = f"angle_deg,height_mm,deviation_um\n{TRACE}".encode()
TURN = b"X_deg;Y_mm\n" + b"".join(b"%d;%d,5\n" % (45 * i, i % 8) for i in range(9))
ROWS = TURN.partition(b"\n")[2].replace(b",", b".")
OUTLINE = b"x_mm,y_mm\n" + b"".join(
    b"%d,%d\n" % (40 * math.cos(0.3 * i), 30 * math.sin(0.3 * i)) for i in range(21)
)
MAKERS = (
    b"9\n" + ROWS,
    b"CYCLIC;YES;\nTABLE_BEGIN;;\n" + ROWS.replace(b"\n", b";SPLINE\n") + b"TABLE_END;;\n",
    b"Tabletype = 7 # ID\nLines = 9\nBegintable\n" + ROWS.replace(b";", b" ") + b"EndTable\n",
    b"Header=a\nYFactor=8\nXFactor=360\nXOffset=0\nCamPoints\n" + b"0.5\n" * 9,
)
PARAMETERS = "".join(f"{name} = {info.low}\n" for name, info in INFOS.items()).encode()

LEARNED = learned_text([1] * N_VALUES, "x").encode()

READERS: dict[str, tuple[Reader, tuple[bytes, ...]]] = {
    "part": (named(parse_part), files("tools/parts/*.toml")),
    "machine": (text_of(read_machine), files("host_sim/machines/*.toml")),
    "vary": (vary, files("tools/camtools/sim/vary.toml")),
    "parameters": (named(parse_parameters), (PARAMETERS, b"[u]\nu_stroke_nm = 1000000\n")),
    "learned": (named(learned_values), (LEARNED, b"k1 = 1\nc = [1, 2]\npart = 'x'\n")),
    "scan": (text_of(parse_scan), files("tools/parts/scan90.csv")),
    "sections": (text_of(parse_sections), (*files("tools/parts/scan90.csv"), POINTS, OUTLINE)),
    "record": (text_of(parse_record), (RECORD,)),
    "measured": (text_of(parse_measured), (GAUGED, HEIGHTS, POINTS)),
    "points": (text_of(parse_points), (TURN, HEIGHTS, POINTS, b"0;1\n1;2\n", *MAKERS)),
}
WORDS = tuple(
    b'nan|-inf|1e308|1e-320|99999999999999999999|\x00|\xff\xfe|[[|]]|"""|=|true|\r|,|;|\xef\xbb\xbf|-0|'
    b"1_0|1979-05-27T07:32:00Z|inf|0x7fffffffffffffff|\n\n|[a.b.c]|{}".split(b"|")
)
EXAMPLES = settings(
    max_examples=N_EXAMPLES,
    deadline=None,
    derandomize="CAMTURN_EXAMPLES" not in os.environ,
    database=None,
    suppress_health_check=list(HealthCheck),
)


@st.composite
def changed(draw: st.DrawFn, seeds: tuple[bytes, ...]) -> bytes:
    """Draw a file with some pieces replaced, repeated, removed or taken from another."""
    data = draw(st.sampled_from(seeds))
    other = draw(st.sampled_from(seeds))
    for _ in range(draw(st.integers(0, 5))):
        at = draw(st.integers(0, len(data)))
        end = min(len(data), at + draw(st.sampled_from((0, 1, 2, 8, 40, 400))))
        begin = draw(st.integers(0, len(other)))
        piece = draw(
            st.one_of(
                st.sampled_from(WORDS),
                st.binary(max_size=8),
                st.just(other[begin : begin + draw(st.integers(0, 60))]),
                st.just(data[at:end] * 2),
            )
        )
        data = data[:at] + piece + data[end:]
    return data


def expect_read_or_refused(reader: Reader, data: bytes) -> None:
    """Ask a reader; an error must be one of ours, and say something in single lines."""
    try:
        reader(data)
    except CamtoolsError as error:
        assert error.lines
        assert all(line.strip() and line.isprintable() for line in error.lines)


@pytest.mark.parametrize("name", sorted(READERS))
def test_first_seed_is_read(name: str) -> None:
    """Changes of a file that is refused at once would not reach the later checks."""
    reader, seeds = READERS[name]
    reader(seeds[0])


@pytest.mark.parametrize("name", sorted(READERS))
def test_any_bytes_are_read_or_refused(name: str) -> None:
    """No reader raises what its caller does not expect."""
    reader, seeds = READERS[name]

    @EXAMPLES
    @given(changed(seeds))
    def ask(data: bytes) -> None:
        expect_read_or_refused(reader, data)

    ask()


def test_any_image_is_read_or_refused(table_of: Callable[[str], Path]) -> None:
    """A table image with any bytes and a right CRC is a table or breaks a rule that is named."""
    seeds = (table_of("hexagon").read_bytes()[: 8 * MOST_BYTES],)

    @EXAMPLES
    @given(changed(seeds), st.integers(0, 511), st.binary(min_size=1, max_size=4))
    def ask(data: bytes, at: int, word: bytes) -> None:
        changed_head = data[:at] + word + data[at + len(word) :]
        try:
            sealed(changed_head)
        except ImageError as error:
            assert str(error)

    ask()
