"""Part files of composite and measured sections and of equal-volume turning."""

from pathlib import Path

import pytest

from camtools.base.errors import CamtoolsError
from camtools.part.common import DEFAULT_ALPHA_RAD_S2
from camtools.skirt.part.part_file import SkirtPart
from tests.tools.cases.part_cases import PERKINS, ROOT, load_part, parse_part

GOOD = PERKINS.read_text()
ARC = 'shape = "ellipse-arc"\ntrim_mm = 0.3\njoint_deg = 50\n'
SECTION = "piston.section"


def with_section(text: str) -> str:
    """Return the good file with another section."""
    return GOOD.replace('shape = "ellipse"\n', text)


def with_process(text: str) -> str:
    """Return the good file with lines added to [process]."""
    return GOOD.replace("direction = 1\n", f"direction = 1\n{text}\n")


def with_limits(text: str) -> str:
    """Return the good file with lines added to [machine.limits]."""
    return f"{GOOD.rstrip()}\n{text}\n"


def lines_of(text: str) -> list[str]:
    """Return the messages that a part file's text is refused with."""
    with pytest.raises(CamtoolsError) as info:
        parse_part(text.encode(), "p.toml")
    return info.value.lines


def read(text: str) -> SkirtPart:
    """Return the part of a text."""
    return parse_part(text.encode(), "p.toml")


def test_composite_section_has_its_defaults() -> None:
    """Cosine base, no refit; a refit is quintic, optimised, with mirrored ends."""
    section = read(with_section(ARC)).piston.section
    assert (section.base, section.refit, section.eccentricity_mm) == ("cosine", None, None)
    refit = read(with_section(ARC + "[piston.section.refit]\n")).piston.section.refit
    assert refit is not None
    assert (refit.spline, refit.delete, refit.ends) == ("quintic", "optimise", "mirror")
    lists = ARC.replace("0.3", "[0.1, 0.2, 0.3]").replace("50", "[48, 50, 52]")
    assert read(with_section(lists)).piston.section.joint_deg == [48, 50, 52]


def test_measured_section_is_beside_its_part_file() -> None:
    """The CSV file is looked for beside the part file; such a part has no ovality."""
    part = load_part(ROOT / "tools" / "parts" / "scan90.toml")
    assert part.piston.ovality is None
    assert part.piston.section.csv is not None
    assert Path(part.piston.section.csv) == ROOT / "tools" / "parts" / "scan90.csv"


def test_spindle_acceleration_comes_from_three_places() -> None:
    """Given, from torque and inertia, or that of a common lathe."""
    given = read(with_limits("spindle_acceleration_rad_s2 = 750")).machine.limits
    derived = read(with_limits("spindle_torque_nm = 60\nspindle_inertia_kgm2 = 0.2")).machine.limits
    assert given.alpha_rad_s2 == 750
    assert derived.alpha_rad_s2 == 300
    assert read(GOOD).machine.limits.alpha_rad_s2 == DEFAULT_ALPHA_RAD_S2


BAD = [
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
    (
        with_section(ARC + "[piston.section.refit]\ndelete = [3, 9]\n"),
        f"{SECTION}.refit.delete.1 = 9",
        "at most 6",
    ),
    (
        with_section(ARC + "[piston.section.refit]\ndelete = [3]\n"),
        f"{SECTION}.refit.delete",
        "at least 2 entries",
    ),
    (
        with_section(ARC + '[piston.section.refit]\ndelete = "all"\n'),
        f"{SECTION}.refit.delete = 'all'",
        "'optimise'",
    ),
    (
        with_section(ARC + '[piston.section.refit]\nends = "free"\n'),
        f"{SECTION}.refit.ends = 'free'",
        "'mirror' or 'as-paper'",
    ),
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
    (with_limits("spindle_torque_nm = 5"), "machine.limits.spindle_torque_nm", "inertia"),
    (
        with_limits(
            "spindle_torque_nm = 5\nspindle_inertia_kgm2 = 1\nspindle_acceleration_rad_s2 = 5"
        ),
        "machine.limits.spindle_torque_nm",
        "alone",
    ),
    (with_limits("spindle_acceleration_rad_s2 = 0"), "machine.limits.spindle_acc", "at least 1"),
]


@pytest.mark.parametrize(("text", "field", "remedy"), BAD)
def test_bad_field_is_named(text: str, field: str, remedy: str) -> None:
    """One of the lines, the first where there is one only, names field and remedy."""
    lines = lines_of(text)
    first = next((line for line in lines if line.startswith(f"p.toml: {field}")), None)
    assert first is not None, lines
    assert remedy in first.split("; ", 1)[1]


def test_missing_ovality_is_told() -> None:
    """A section that is not measured needs its ovality."""
    head, _, tail = GOOD.partition("[piston.ovality]")
    text = head + tail[tail.index("[piston.section]") :]
    assert any("piston.ovality: is missing; add it" in line for line in lines_of(text))
