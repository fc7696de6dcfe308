"""Part files: what is read, and what is refused with which words."""

import os
import re
from pathlib import Path

import pytest

from camtools.base.errors import CamtoolsError
from camtools.part.file import MAX_FILE_BYTES
from camtools.part.model import rising
from camtools.skirt.part.part_file import SkirtPart
from tests.tools.cases.part_cases import PERKINS, load_part, parse_part

GOOD = PERKINS.read_text()


def lines_of(text: str | bytes) -> list[str]:
    """Return the messages that a part file's text is refused with."""
    data = text if isinstance(text, bytes) else text.encode()
    with pytest.raises(CamtoolsError) as info:
        parse_part(data, "p.toml")
    return info.value.lines


def with_line(key: str, value: str, table: str = "") -> str:
    """Return the good file with one line replaced; `table` tells equal keys apart."""
    head, found, tail = GOOD.partition(f"[{table}]") if table else ("", "", GOOD)
    line = re.compile(rf"^{key} = .*$", re.MULTILINE)
    changed, n = line.subn(lambda _: f"{key} = {value}", tail, count=1)
    assert n == 1
    return head + found + changed


def without_line(key: str, table: str = "") -> str:
    """Return the good file with one line taken out."""
    return with_line(key, "@", table).replace(f"{key} = @", "")


def test_perkins_file_is_read() -> None:
    """The shipped part has the drawing's numbers and says that they are reconstructed."""
    part = load_part(PERKINS)
    assert part.piston.profile.height_mm == [0, 10, 20, 30, 40, 50, 62]
    assert part.piston.ovality is not None
    assert part.piston.ovality.ovality_mm == [0.15, 0.20, 0.30]
    assert part.part.source.startswith("Reconstructed")
    assert part.process.direction == 1


def test_defaults_are_the_documented_ones() -> None:
    """Tables and keys that may be left out have their documented values."""
    short = GOOD.partition("[machine.limits]")[0]
    for key in ("interpolation", "shape", "depth_mm", "direction"):
        short = re.sub(rf"^{key} = .*$", "", short, flags=re.MULTILINE)
    part = parse_part(short.encode(), "p.toml")
    assert part == SkirtPart.model_validate(part.model_dump())
    assert part.piston.ovality is not None
    assert (part.piston.ovality.interpolation, part.piston.section.shape) == ("linear", "ellipse")
    assert (part.process.depth_mm, part.process.direction) == (0.1, 1)
    limits = part.machine.limits
    assert (limits.u_stroke_mm, limits.u_speed_mm_s) == (1.2, 400)
    assert (limits.u_acceleration_mm_s2, limits.spindle_rpm) == (250_000, 3000)
    assert part.magnify is None


PROFILE, OVALITY = "piston.profile", "piston.ovality"
MACHINE = "machine.limits"
BAD = [
    # what the file says, the field that must be named, what to do about it
    (with_line("name", '"a b"'), "part.name = 'a b'", "use 1 to 31 letters"),
    (with_line("name", '""'), "part.name = ''", "use 1 to 31 letters"),
    (with_line("name", '"../up"'), "part.name", "use 1 to 31 letters"),
    (with_line("name", '"-o"'), "part.name", "use 1 to 31 letters"),
    (with_line("name", '"x\\n"'), "part.name", "use 1 to 31 letters"),
    (with_line("name", '"ä"'), "part.name = '\\xe4'", "use 1 to 31 letters"),
    (with_line("name", f'"{"n" * 32}"'), "part.name", "use 1 to 31 letters"),
    (with_line("name", "7"), "part.name = 7", 'give text in "quotes"'),
    (with_line("kind", '"gear"'), "part.kind = 'gear'", "use one of: 'piston', 'cam' or 'polygon'"),
    (with_line("source", '""'), "part.source", "at least 1 characters"),
    (without_line("source"), "part.source", "add it"),
    (without_line("diameter_mm"), "piston.profile.diameter_mm", "add it"),
    (with_line("height_mm", "[0, 10, 10, 30, 40, 50, 62]"), f"{PROFILE}.height_mm", "upwards"),
    (with_line("height_mm", "[62, 50, 40, 30, 20, 10, 0]"), f"{PROFILE}.height_mm", "upwards"),
    (with_line("height_mm", "[0, 10]"), f"{PROFILE}.diameter_mm", "one value for each height"),
    (with_line("height_mm", "[0]"), f"{PROFILE}.height_mm", "at least 2 entries"),
    (with_line("height_mm", "[]"), f"{PROFILE}.height_mm", "at least 2 entries"),
    (with_line("height_mm", "5"), f"{PROFILE}.height_mm = 5", "give a list"),
    (with_line("height_mm", "[0, 0.5]"), f"{PROFILE}.height_mm", "in mm"),
    (with_line("height_mm", "[0, 1e9]"), f"{PROFILE}.height_mm.1", "at most 1000"),
    (with_line("height_mm", "[nan, 1]"), f"{PROFILE}.height_mm.0 = nan", "finite"),
    (with_line("diameter_mm", "[inf, 1]"), f"{PROFILE}.diameter_mm.0 = inf", "finite"),
    (with_line("diameter_mm", '["92", 1]'), f"{PROFILE}.diameter_mm.0 = '92'", "number"),
    (with_line("diameter_mm", "[true, 1]"), f"{PROFILE}.diameter_mm.0 = True", "number"),
    (with_line("diameter_mm", "[4001, 1]"), f"{PROFILE}.diameter_mm.0", "at most 4000"),
    (with_line("diameter_mm", "[-92, 1]"), f"{PROFILE}.diameter_mm.0", "at least 1"),
    (with_line("diameter_mm", f"[1{'0' * 400}, 1]"), f"{PROFILE}.diameter_mm.0", ""),
    (with_line("spline", '"cubic"'), f"{PROFILE}.spline = 'cubic'", "'clamped', 'not-a-knot' or"),
    (without_line("end_slopes"), f"{PROFILE}.end_slopes", "not-a-knot"),
    (with_line("spline", '"natural"'), f"{PROFILE}.end_slopes", "remove them"),
    (with_line("end_slopes", "[1]"), f"{PROFILE}.end_slopes", "at least 2 entries"),
    (with_line("end_slopes", "[1, 200]"), f"{PROFILE}.end_slopes.1", "at most 100"),
    (with_line("ovality_mm", "[0.1, -0.1, 0.3]"), f"{OVALITY}.ovality_mm.1 = -0.1", "at least 0"),
    (with_line("ovality_mm", "[0.1, 91.8, 0.3]"), f"{OVALITY}.ovality_mm", "long minus short"),
    (with_line("ovality_mm", "[0.1, 0.3]"), f"{OVALITY}.ovality_mm", "one value for each height"),
    (with_line("height_mm", "[0, 20, 61]", OVALITY), f"{OVALITY}.height_mm", "add points"),
    (with_line("height_mm", "[1, 20, 62]", OVALITY), f"{OVALITY}.height_mm", "add points"),
    (with_line("height_mm", "[0, 20, 20]", OVALITY), f"{OVALITY}.height_mm", "upwards"),
    (with_line("interpolation", '"none"'), f"{OVALITY}.interpolation", "'linear', 'pchip'"),
    (with_line("shape", '"round"'), "piston.section.shape = 'round'", "use one of"),
    (with_line("shape", '"ellipse"\nbeta = 1'), "piston.section.beta", "double-ellipse"),
    (with_line("shape", '"double-ellipse"\nbeta = 6.26'), "piston.section.beta", "at most 6.25"),
    (with_line("shape", '"double-ellipse"\nbeta = -7'), "piston.section.beta", "at least -6.25"),
    (with_line("spindle_rpm", "0"), "process.spindle_rpm = 0", "at least 1"),
    (with_line("spindle_rpm", "-2500"), "process.spindle_rpm = -2500", "at least 1"),
    (with_line("spindle_rpm", "nan"), "process.spindle_rpm = nan", "finite"),
    (with_line("feed_mm", "0"), "process.feed_mm = 0", "at least 0.0001"),
    (with_line("depth_mm", "-0.1"), "process.depth_mm = -0.1", "at least 0"),
    (with_line("direction", "0"), "process.direction = 0", "use one of: 1 or -1"),
    (with_line("direction", "true"), "process.direction = True", "use one of: 1 or -1"),
    (with_line("u_stroke_mm", "0", MACHINE), "machine.limits.u_stroke_mm = 0", "at least"),
    (GOOD + "\n[magnify]\nfactor = 0.5\n", "magnify.factor = 0.5", "at least 1"),
    (GOOD + "\n[magnify]\n", "magnify.factor", "add it"),
    (GOOD + "\n[magnify]\nfactor = 2\nfaktor = 3\n", "magnify.faktor = 3", "remove it"),
    ("beta = 1\n" + GOOD, "beta = 1", "remove it"),
    ("magnify = 3\n" + GOOD, "magnify = 3", "give a table"),
    ('"a\\nb" = 1\n' + GOOD, "a?b = 1", "remove it"),
    ("", "part", "add it"),
]


@pytest.mark.parametrize(("text", "field", "remedy"), BAD)
def test_bad_field_is_named_first(text: str, field: str, remedy: str) -> None:
    """The first line names file, dotted field and remedy; every terminal can show each."""
    lines = lines_of(text)
    assert lines[0].startswith(f"p.toml: {field}")
    assert remedy in lines[0].split("; ", 1)[1]
    assert all(re.fullmatch(r"[\x20-\x7e]{10,300}", line) for line in lines)


def test_all_errors_are_reported() -> None:
    """Three mistakes give three lines, in the order of the file's tables."""
    text = with_line("name", "1").replace("feed_mm = 0.1", "feed_mm = 0")
    lines = lines_of(text.replace('shape = "ellipse"', 'shape = "ring"'))
    assert [line.split()[1] for line in lines] == [
        *("part.name", "piston.section.shape", "process.feed_mm")
    ]


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (b"part = ", "not TOML"),
        (b"[part]\nname = 'a'\nname = 'b'\n", "not TOML"),
        (b"a = " + b"[" * 100_000, "not TOML"),
        (b"a = " + b"1" * 10_000, "not TOML"),
        (b"\xff\xfe\x00", "not UTF-8"),
        (b"a = '\x00'", "not TOML"),
    ],
)
def test_undecodable_bytes_are_refused(data: bytes, words: str) -> None:
    """What is not UTF-8 or not TOML is refused as such, on one line with a remedy."""
    (line,) = lines_of(data)
    assert line.startswith("p.toml: " + words)
    assert "; " in line


def test_unreadable_files_are_refused(tmp_path: Path) -> None:
    """A missing file, a directory, a pipe, a device and a huge file are refused by name."""
    pipe = tmp_path / "pipe.toml"
    os.mkfifo(pipe)
    huge = tmp_path / "huge.toml"
    huge.write_bytes(b"#" * (MAX_FILE_BYTES + 1))
    for path, words in (
        (tmp_path / "none.toml", "cannot be read: No such file"),
        (tmp_path, "cannot be read: Is a directory"),
        (Path("/dev/null"), "cannot be read: not a file"),
        (pipe, "cannot be read: not a file"),
        (huge, "cannot be read: larger than 1000000 bytes; give the path of a part file"),
    ):
        with pytest.raises(CamtoolsError, match=words) as info:
            load_part(path)
        assert info.value.lines[0].startswith(str(path))


def test_heights_as_far_apart_as_they_must_be_are_taken() -> None:
    """Whatever their binary fractions: 4.1 - 3.1 is below 1, 0.12 - 0.11 below 0.01."""
    for heights in ([3.1, 4.1], [0.11, 0.12, 1.11]):
        assert rising(heights) == heights
