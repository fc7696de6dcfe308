"""The MISRA gate: deviations cover what they say and nothing else."""

import shutil
from pathlib import Path

import pytest

from checks.misra import Finding, check, cppcheck, judge, parse_deviations
from tests.tools.cases.part_cases import ROOT

TABLE = """
| | rule | category | scope | words | reason |
|---|---|---|---|---|---|
| D1 | 10.1, shiftNegativeLHS | required | `firmware/*` | `<<` `>>` | arithmetic shifts |
| D2 | 15.5 | advisory | `firmware/a.c` `firmware/b.c` |  | guards |
| D3 | 11.6 | required | in place |  | alignment |
"""
LINES = ["a = b >> 1;", "return;", "// MISRA D3", "p = q;", "p = q; // MISRA D33", "p = q;"]


@pytest.mark.parametrize(
    ("finding", "number"),
    [
        (("firmware/a.c", 1, "10.1"), "D1"),
        (("firmware/tick/a.h", 1, "shiftNegativeLHS"), "D1"),
        (("firmware/a.c", 2, "10.1"), None),
        (("hal/a.h", 1, "10.1"), None),
        (("firmware/b.c", 2, "15.5"), "D2"),
        (("firmware/c.c", 2, "15.5"), None),
        (("firmware/c.c", 3, "11.6"), "D3"),
        (("firmware/c.c", 4, "11.6"), "D3"),
        (("firmware/c.c", 5, "11.6"), None),
        (("firmware/c.c", 6, "11.6"), None),
        (("firmware/c.c", 4, "11.5"), None),
    ],
)
def test_scope_of_a_deviation(finding: tuple[str, int, str], number: str | None) -> None:
    """Rule, file, words of the line or the mark must all fit."""
    found = Finding(*finding)
    left, covered = judge([found], parse_deviations("MISRA.md", TABLE), {found.file: LINES})
    assert left == ([] if number else [found])
    assert list(covered) == ([number] if number else [])


@pytest.mark.skipif(shutil.which("cppcheck") is None, reason="cppcheck is not installed")
@pytest.mark.long
def test_gate(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A breach fails, its deviation passes, a deviation without a breach fails."""
    folder = tmp_path / "firmware"
    folder.mkdir()
    source, table = folder / "a.c", folder / "MISRA.md"
    source.write_text("int f(int a);\nint f(int a)\n{\n    return a >> 1;\n}\n", "utf-8")
    table.write_text("", "utf-8")
    assert check(tmp_path) == 1
    assert "firmware/a.c:4: rule 10.1: return a >> 1;" in capsys.readouterr().out
    rows = "| D1 | 10.1 | required | `firmware/*` | `>>` | x |\n"
    table.write_text(rows, "utf-8")
    assert check(tmp_path) == 0
    source.write_text("int f(int a);\nint f(int a)\n{\n    return a + 1;\n}\n", "utf-8")
    assert check(tmp_path) == 1
    assert "D1 covers nothing any more" in capsys.readouterr().out


@pytest.mark.skipif(shutil.which("cppcheck") is None, reason="cppcheck is not installed")
@pytest.mark.long
def test_breach_in_a_line_of_the_core_is_found(tmp_path: Path) -> None:
    """Lines that only a compiler for the core reads are held to the rules as well."""
    (tmp_path / "firmware").mkdir()
    core = "#if defined(__ARM_FEATURE_DSP) && __ARM_FEATURE_DSP\n    a = a >> 1;\n#endif\n"
    text = f"int f(int a);\nint f(int a)\n{{\n{core}    return a;\n}}\n"
    (tmp_path / "firmware" / "a.c").write_text(text, "utf-8")
    assert ("firmware/a.c", 5, "10.1") in cppcheck(tmp_path)


def test_table_of_the_firmware_is_understood() -> None:
    """Every row of the firmware's own table is a deviation with a reason."""
    text = (ROOT / "firmware" / "MISRA.md").read_text("utf-8")
    found = parse_deviations("MISRA.md", text)
    assert len(found) == text.count("\n| D")
    assert all(len(one.reason) > 20 for one in found)
