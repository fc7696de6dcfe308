"""Part files of skirts: what is read, and what is refused with which words."""

import os
import re
from functools import partial
from pathlib import Path

import pytest

from camtools.base.errors import CamtoolsError
from camtools.part.common import DEFAULT_ALPHA_RAD_S2
from camtools.part.model import MAX_FILE_BYTES, rising
from camtools.skirt.part.part_file import SkirtPart
from tests.tools.cases.cut_cases import PARTS
from tests.tools.cases.part_cases import PERKINS, ROOT, load_part, parse_part, refused_lines, sure

GOOD = PERKINS.read_text()


def lines_of(text: str | bytes) -> list[str]:
    """Return the messages that a part file's text is refused with."""
    return refused_lines(lambda: parse_part(text, "p.toml"))


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


def test_defaults_are_the_documented_ones() -> None:
    """Tables and keys that may be left out have their documented values."""
    short = GOOD.partition("[machine.limits]")[0]
    for key in ("interpolation", "shape", "depth_mm", "direction"):
        short = re.sub(rf"^{key} = .*$", "", short, flags=re.MULTILINE)
    part = parse_part(short)
    assert part == SkirtPart.model_validate(part.model_dump())
    assert part.piston.ovality is not None
    assert (part.piston.ovality.interpolation, part.piston.section.shape) == ("linear", "ellipse")
    assert (part.process.depth_mm, part.process.direction) == (0.1, 1)
    limits = part.machine.limits
    assert (limits.u_stroke_mm, limits.u_speed_mm_s) == (1.2, 400)
    assert (limits.u_acceleration_mm_s2, limits.spindle_rpm) == (250_000, 3000)
    assert part.magnify is None


ARC = 'shape = "ellipse-arc"\ntrim_mm = 0.3\njoint_deg = 50\n'
REFIT = ARC + "[piston.section.refit]\n"
SECTION, LIMITS = "piston.section", "machine.limits"


def with_section(text: str) -> str:
    """Return the good file with another section."""
    return GOOD.replace('shape = "ellipse"\n', text)


def with_process(text: str) -> str:
    """Return the good file with lines added to [process]."""
    return GOOD.replace("direction = 1\n", f"direction = 1\n{text}\n")


def with_limits(text: str) -> str:
    """Return the good file with lines added to [machine.limits]."""
    return f"{GOOD.rstrip()}\n{text}\n"


def without_ovality() -> str:
    """Return the good file without an ovality."""
    head, _, tail = GOOD.partition("[piston.ovality]")
    return head + tail[tail.index("[piston.section]") :]


def changed(name: str, old: str, new: str) -> str:
    """Return another part file with a change."""
    text = (PARTS / f"{name}.toml").read_text()
    assert old in text
    return text.replace(old, new, 1)


sided, formula = partial(changed, "thrust90"), partial(changed, "perkins240_law")
BOTH = "spindle_torque_nm = 5\nspindle_inertia_kgm2 = 1\n"
OVAL = 'shape = "double-ellipse"\nbeta = [0.6, 1.0, 1.4]'
ARC_SIDES, OTHER = ARC.replace("0.3", "0.1"), "piston.antithrust"
PROFILE, OVALITY = "piston.profile", "piston.ovality"
MACHINE, TOOL = "machine.limits", f"{GOOD}\n[tool]\n"
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
    (GOOD + "\n[magnify]\nfactor = 2\nfaktor = 3\n", "magnify.faktor: ", "remove it"),
    ("beta = 1\n" + GOOD, "beta: ", "remove it"),
    ("magnify = 3\n" + GOOD, "magnify = 3", "give a table"),
    ('"a\\nb" = 1\n' + GOOD, "a?b: ", "remove it"),
    ("", "part", "add it"),
    (with_section('shape = "ellipse-arc"\n'), f"{SECTION}.trim_mm", "add it"),
    (with_section(ARC.replace("0.3", '"a"')), f"{SECTION}.trim_mm = 'a'", "without quotes"),
    (with_section(ARC.replace("0.3", "[0.3]")), f"{SECTION}.trim_mm", "at least 2 entries"),
    (with_section(ARC.replace("0.3", "[1, 2]")), f"{SECTION}.trim_mm = [1.0, 2.0]", "one for each"),
    (with_section(ARC.replace("0.3", "nan")), f"{SECTION}.trim_mm = nan", "finite"),
    (with_section(ARC.replace("50", "5")), f"{SECTION}.joint_deg = 5", "at least 10"),
    (with_section(ARC.replace("50", "[40, 85, 50]")), f"{SECTION}.joint_deg.1", "at most 80"),
    (with_section(ARC + 'base = "arc"\n'), f"{SECTION}.base = 'arc'", "'cosine', 'ellipse' or"),
    (with_section(ARC + "beta = 1\n"), f"{SECTION}.beta = 1", "double-ellipse"),
    (with_section(ARC + "eccentricity_mm = inf\n"), f"{SECTION}.eccentricity_mm", "finite"),
    (with_section(ARC + "harmonics = 3\n"), f"{SECTION}.harmonics = 3", 'shape = "table"'),
    (with_section('shape = "cosine"\ntrim_mm = 1\n'), f"{SECTION}.trim_mm = 1", "ellipse-arc"),
    (with_section('shape = "table"\n'), f"{SECTION}.csv", "add it"),
    (with_section('shape = "table"\ncsv = ""\n'), f"{SECTION}.csv = ''", "at least 1 char"),
    (with_section('shape = "table"\ncsv = "a"\n'), "piston.ovality", "remove [piston.ovality]"),
    (with_section(REFIT + "delete = [3, 9]\n"), f"{SECTION}.refit.delete.1 = 9", "at most 6"),
    (with_section(REFIT + "delete = [3]\n"), f"{SECTION}.refit.delete", "at least 2 entries"),
    (with_section(REFIT + 'delete = "all"\n'), f"{SECTION}.refit.delete = 'all'", "'optimise'"),
    (with_section(REFIT + 'ends = "free"\n'), f"{SECTION}.refit.ends = 'free'", "or 'as-paper'"),
    (with_process('mode = "even"'), "process.mode = 'even'", "'uniform' or 'equal-volume'"),
    (with_process("parts = 1"), "process.parts = 1", "at least 2"),
    (
        GOOD.replace("form_error_um = 0.2", "form_error_um = 0"),
        "process.form_error_um = 0",
        "at least 0.01",
    ),
    (
        with_process('mode = "equal-volume"').replace("depth_mm = 0.1", "depth_mm = 0"),
        "process.mode = 'equal-volume'",
        "depth_mm above 0",
    ),
    (with_limits("spindle_torque_nm = 5"), f"{LIMITS}.spindle_torque_nm", "inertia"),
    (with_limits(BOTH + "spindle_acceleration_rad_s2 = 5"), f"{LIMITS}.spindle_torque_nm", "alone"),
    (with_limits("spindle_acceleration_rad_s2 = 0"), f"{LIMITS}.spindle_acc", "at least 1"),
    (sided(OVAL, ARC_SIDES), f"{SECTION}.shape = 'ellipse-arc': has no sides", "remove it"),
    (sided("56]\ndrop_mm", "50]\ndrop_mm"), f"{OTHER}.height_mm = ", "add points at the ends"),
    (sided("0.020, ", ""), f"{OTHER}.drop_mm = [0.012, 0.03]: has 2 entries, height_mm has 3", ""),
    (sided("[0.6, 1.0, 1.4]", "[0.6, 1.0]"), f"{SECTION}.beta = ", "one for each height"),
    (sided("blend_deg = 30", 'meet = "long-axis"'), f"{OTHER}.ovality_mm: is missing", "add it"),
    (sided("beta = 0.4", "exponent = 3"), f"{OTHER}.exponent = 3.0: has no meaning", "remove it"),
    (sided("blend_deg = 30", "blend_deg = 1"), f"{OTHER}.blend_deg = 1", "at least 2"),
    (sided(OVAL, 'shape = "power"'), f"{SECTION}.exponent: is missing", "add it"),
    (sided(OVAL, 'shape = "power"\nexponent = 1.5'), f"{SECTION}.exponent = 1.5", "at least 2"),
    (with_section('shape = "power"\nexponent = [2, 3]\n'), f"{SECTION}.exponent", "one for each"),
    (formula('"power"', '"cubic"'), f"{PROFILE}.law = 'cubic': Input should be 'power'", ""),
    (formula("exponent = 2", "exponent = 1.5"), f"{PROFILE}.exponent = 1.5", "at least 2"),
    (formula("= 7.4546e-5", "= 1"), f"{PROFILE}.coefficient = 1.0: makes", "mm of radius"),
    (formula("range_mm = [0, 62]", "range_mm = [62, 0]"), f"{PROFILE}.range_mm", "upwards"),
    (formula("[0, 62]\npeak_height_mm = 62", "[5, 62]\npeak_height_mm = 62"),
     f"{OVALITY}.height_mm = [5.0, 62.0]: must cover", "add points"),
    (formula("per_mm = 0.00238", "per_mm = 1 #"), f"{OVALITY}.fall_mm_per_mm = 1.0: makes", "less"),
    (formula("peak_diameter_mm", "diameter_mm"), f"{PROFILE}.peak_diameter_mm: is miss", "add it"),
    (TOOL + "nose_radius_mm = 0.005\n", "tool.nose_radius_mm = 0.005: must be 0 or", "give 0"),
    (TOOL + "nose_radius_mm = -1\n", "tool.nose_radius_mm = -1", "at least 0"),
    (TOOL + "clearance_deg = 0\n", "tool.clearance_deg = 0", "at least 0.1"),
    (TOOL + "wear_um = -1\n", "tool.wear_um = -1", "at least 0"),
    (TOOL + "radius = 1\n", "tool.radius: unknown key", "remove it"),
    (with_process('path = "spiral"'), "process.path = 'spiral'", "'helix', 'ring-helix' or"),
    (with_process('path = "ring-helix"\nmode = "equal-volume"'), "process.path = 'ring-helix'",
     "or path"),
    (without_ovality(), "piston.ovality: is missing", "add it"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "field", "remedy"), BAD)
def test_bad_field_is_named_first(text: str, field: str, remedy: str) -> None:
    """The first line names file, dotted field and remedy; every terminal can show each."""
    lines = lines_of(text)
    assert lines[0].startswith(f"p.toml: {field}")
    assert remedy in lines[0].split("; ", 1)[1]
    assert all(re.fullmatch(r"[\x20-\x7e]{10,300}", line) for line in lines)
    assert not any("(law)" in line or "(points)" in line for line in lines)


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


def test_sections_and_spindles_have_their_defaults() -> None:
    """Refits, a CSV file beside the part, the spindle's acceleration by torque and inertia."""
    section = parse_part(with_section(ARC)).piston.section
    assert (section.base, section.refit, section.eccentricity_mm) == ("cosine", None, None)
    refit = sure(parse_part(with_section(REFIT)).piston.section.refit)
    assert (refit.spline, refit.delete, refit.ends) == ("quintic", "optimise", "mirror")
    lists = ARC.replace("0.3", "[0.1, 0.2, 0.3]").replace("50", "[48, 50, 52]")
    assert parse_part(with_section(lists)).piston.section.joint_deg == [48, 50, 52]
    part = load_part(ROOT / "tools" / "parts" / "scan90.toml")
    assert part.piston.ovality is None
    assert Path(sure(part.piston.section.csv)) == ROOT / "tools" / "parts" / "scan90.csv"
    given = parse_part(with_limits("spindle_acceleration_rad_s2 = 750")).machine.limits
    torque = "spindle_torque_nm = 60\nspindle_inertia_kgm2 = 0.2"
    assert given.alpha_rad_s2 == 750
    assert parse_part(with_limits(torque)).machine.limits.alpha_rad_s2 == 300
    assert parse_part(GOOD).machine.limits.alpha_rad_s2 == DEFAULT_ALPHA_RAD_S2
