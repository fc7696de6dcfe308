"""The command line of elfcheck: exit status, messages, the record of sizes."""

import subprocess
import sys
from pathlib import Path

import pytest

from camtools.base.errors import InputError
from checks.elf_isr import load_bounds
from checks.elf_sizes import Size, compare, emit_sizes, measure, parse_sizes
from checks.elfcheck import main
from tests.tools.cases.elf_cases import LOOP, link, needs_gcc
from tests.tools.cases.part_cases import Capture

SIZED = """
    static const int squares[16] = {1, 4, 9, 16, 25, 36, 49, 64, 81, 100, 121, 144, 169, 196, 225};
    int counted = 5; int zeroed[25];
    int root(int n) { zeroed[n & 7] = counted++; return squares[n & 15]; }
"""


def loops_file(folder: Path, text: str = 'root = "counts r0 down"') -> Path:
    """Write a table of loops."""
    path = folder / "loops.toml"
    path.write_text(f"[loops]\n{text}\n", "utf-8")
    return path


def isr(folder: Path, *words: str) -> int:
    """Check the interrupt root() of the image that lies in a folder."""
    return main(["isr", str(folder / "tiny.elf"), "--root", "root", *words])


def test_needs_no_library() -> None:
    """The builds run elfcheck with the Python of the system, which has no numpy."""
    code = "import sys; sys.modules['numpy'] = None; import checks.elfcheck"
    subprocess.run([sys.executable, "-c", code], check=True)


@needs_gcc
def test_limit_of_the_stack(tmp_path: Path, capsys: Capture) -> None:
    """36 bytes of entry and none besides."""
    link(tmp_path, LOOP)
    words = ("--loops", str(loops_file(tmp_path)), "--stack-limit")
    assert isr(tmp_path, *words, "36") == 0
    assert isr(tmp_path, *words, "35") == 1
    out, err = capsys.readouterr()
    assert "isr-stack 36 bytes, 36 of them for the interrupt's entry" in out
    assert err.splitlines()[0] == "FAILED: 36 bytes of stack, limit 35"


@needs_gcc
def test_bounds_from_several_files(tmp_path: Path, capsys: Capture) -> None:
    """A loop that nobody bounded fails; a bound without a loop may be needed on another core."""
    link(tmp_path, LOOP)
    (tmp_path / "port").mkdir()
    port = loops_file(tmp_path / "port", 'other = "the port\'s"')
    assert isr(tmp_path, "--loops", str(port)) == 1
    assert isr(tmp_path, "--loops", str(port), "--loops", str(loops_file(tmp_path))) == 0
    out, err = capsys.readouterr()
    assert err.startswith("FAILED: root: loop at")
    assert "note: no loop of other is reached" in out
    assert "loop: root (tiny.c:1): counts r0 down" in out


@needs_gcc
def test_bad_input_is_one_line(tmp_path: Path, capsys: Capture) -> None:
    """A missing symbol, image or table of loops: status 2."""
    link(tmp_path, LOOP)
    assert main(["isr", str(tmp_path / "tiny.elf"), "--root", "nobody"]) == 2
    assert main(["isr", str(tmp_path / "missing.elf")]) == 2
    assert isr(tmp_path, "--loops", str(tmp_path / "missing.toml")) == 2
    told = capsys.readouterr().err.splitlines()
    assert len(told) == 3
    assert all(line.startswith("elfcheck: ") for line in told)


@pytest.mark.parametrize("text", ["f = 3", "f = ' '", "f = 'x'\nf = 'y'", "f", "[more]\nf = 3"])
def test_bad_bounds_are_refused(tmp_path: Path, text: str) -> None:
    """Each bound has a function and a reason."""
    path = loops_file(tmp_path, text)
    if text.startswith("[more]"):
        path.write_text(text, "utf-8")
    with pytest.raises(InputError):
        load_bounds(path)


@needs_gcc
def test_sizes_by_source_file(tmp_path: Path) -> None:
    """Constants, data and zeroed data are those of the source; code is all of the function."""
    image = link(tmp_path, SIZED)
    (size,) = measure(image, [tmp_path.name]).values()
    assert size[1:] == (64, 4, 100)
    listed = image.ask("nm", "-S", str(image.path)).splitlines()
    (root,) = (line.split() for line in listed if line.endswith(" root"))
    assert size.code == int(root[1], 16)
    assert measure(image, ["firmware"]) == {}


@needs_gcc
def test_record_of_sizes(tmp_path: Path, capsys: Capture) -> None:
    """What was recorded passes; code that grew does not, and the remedy is told."""
    record = tmp_path / "sizes.toml"
    words = [str(tmp_path / "tiny.elf"), "--source", tmp_path.name, "--recorded", str(record)]
    link(tmp_path, SIZED)
    assert main(["sizes", *words, "--build", "m7"]) == 2
    assert main(["sizes", *words, "--build", "m7", "--record"]) == 0
    assert main(["sizes", *words, "--build", "m4", "--record"]) == 0
    assert main(["sizes", *words, "--build", "m7"]) == 0
    link(tmp_path, SIZED.replace("zeroed[25]", "zeroed[42]"))
    assert main(["sizes", *words, "--build", "m7"]) == 1
    told = capsys.readouterr().out
    assert "bss 100 -> 168 bytes" in told
    assert "--build m7 --record" in told
    link(tmp_path, SIZED.replace("zeroed[25]", "zeroed[41]"))
    assert main(["sizes", *words, "--build", "m7"]) == 0


def test_growth_and_shrinking() -> None:
    """More than 64 bytes and more than 2 %; a new module is growth, a lost one is not."""
    assert compare({"a": Size(code=5100)}, {"a": Size(code=5000)}) == []
    (grown,) = compare({"a": Size(code=5101)}, {"a": Size(code=5000)})
    (new,) = compare({"b": Size(bss=65)}, {})
    (lost,) = compare({}, {"b": Size(bss=65)})
    assert (grown.is_growth, new.is_growth, lost.is_growth) == (True, True, False)


def test_record_reads_as_written() -> None:
    """Text and sizes are the same thing; other text is refused."""
    builds = {"m7": {"firmware/a.c": Size(1, 2, 3, 4)}, "m4": {"b.c": Size(5)}}
    assert parse_sizes("sizes.toml", emit_sizes(builds)) == builds
    for text in ("m7 = 3", "[m7]\n'a.c' = 3", "[m7]\n'a.c' = { more = 3 }", "[m7"):
        with pytest.raises(InputError):
            parse_sizes("sizes.toml", text)
