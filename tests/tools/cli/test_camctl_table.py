"""Tables over the bus by tools/camctl: downloaded, selected, refused, repeated."""

import struct
from pathlib import Path

import can
import pytest

from camtools.link.controller import BLOCK_ID
from camtools.link.download import BLOCK_BYTES
from tests.tools.cases.camctl_bench import Bench, Refusal, named
from tests.tools.cases.part_cases import TableOf


@pytest.fixture
def other(table_of: TableOf, tmp_path: Path) -> Path:
    """Return the table of a real part, of more than one block."""
    file = tmp_path / "other.camtab"
    file.write_bytes(named(table_of("weichai3a").read_bytes(), "other part"))
    assert file.stat().st_size > BLOCK_BYTES
    return file


def test_a_table_is_downloaded_and_selected(bench: Bench, other: Path) -> None:
    """Progress is told; the old table stays in use until select."""
    crc = struct.unpack_from("<I", other.read_bytes(), 20)[0]
    before = bench.do("table", "info")
    assert "short skirt" in before
    assert "generation 1" in before
    text = bench.do("table", "download", other)
    assert f"{other.stat().st_size} of {other.stat().st_size} bytes, 100 %" in text
    assert "short skirt" in bench.do("table", "info")
    selected = bench.do("select")
    assert "other part" in selected
    assert f"CRC-32 {crc:08x}, generation 2" in selected
    assert "other part" in bench.do("table", "info")


@pytest.mark.long
def test_neighbours_on_one_bus_do_not_hear_one_another(bench: Bench, other: Path) -> None:
    """Each is commanded and gets its table by its own number; the next numbers are the hardest."""
    after, before = Bench(bench.channel, 65), Bench(bench.channel, 63)
    try:
        assert "other part" in bench.do("table", "download", other, "--select")
        for one in (after, before):
            assert "short skirt" in one.do("table", "info")
        assert after.do("home") == "home: ready\n"
        for one in (bench, before):
            assert "state             off" in one.do("status")
        assert "other part" in before.do("table", "download", other, "--select")
    finally:
        after.close()
        before.close()


def test_lost_frames_are_repeated(bench: Bench, other: Path) -> None:
    """A first frame and one in the middle of a block get lost: the download goes on."""
    seen = 0

    def drop(frame: can.Message) -> bool:
        nonlocal seen
        seen += frame.arbitration_id == BLOCK_ID
        return frame.arbitration_id == BLOCK_ID and seen in (1, 1000)

    bench.drop = drop
    assert "other part" in bench.do("table", "download", other, "--select")


def test_a_download_that_cannot_go_on_leaves_the_old_table(
    bench: Bench, other: Path, refusal: Refusal, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The line says that nothing is lost; a damaged table is refused by the controller."""
    monkeypatch.setattr("camtools.link.download.MOST_REPEATS", 1)
    bench.drop = lambda frame: frame.arbitration_id == BLOCK_ID
    assert "old table stays in force" in refusal(bench, 1, f"table download {other}")
    bench.drop = lambda frame: False
    bad = other.with_name("bad.camtab")
    bad.write_bytes(other.read_bytes()[:-1] + b"\x55")
    assert "image crc" in refusal(bench, 1, f"table download {bad}")
    assert "short skirt" in bench.do("select")
    bench.do("home")
    bench.do("set", "engage_turns", "100")
    with bench.cutting():
        assert "begin download: refused: state" in refusal(bench, 1, f"table download {other}")


def test_what_is_no_table_is_bad_input(bench: Bench, tmp_path: Path, refusal: Refusal) -> None:
    """Neither a missing file nor a text is sent."""
    assert "check the path" in refusal(bench, 2, f"table download {tmp_path / 'none'}")
    text = tmp_path / "text"
    text.write_text("no table" * 100)
    assert "not a cam table" in refusal(bench, 2, f"table download {text}")
    assert "check the path" in refusal(bench, 2, f"record {tmp_path / 'none' / 'x.csv'}")
