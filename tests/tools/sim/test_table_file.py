"""Files of a cut in this process: text as the program writes it, Parquet with its numbers."""

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from camtools.link.messages import NAMES
from camtools.sim import simulate
from camtools.sim.binding import Column
from camtools.sim.results import STATES, read_swing
from camtools.sim.table_file import DUPLICATES, ParquetFile, column_names, read_columns
from tests.tools.cases.camsim_cases import camsim, first_difference

CUT = ("--turns-limit", "15", "--nose-mm", "0.8", "--sections-mm", "0.05,0.1")
TABLES = ("surface.csv", "removal.csv", "scallop.csv", "sections.csv")


@pytest.fixture(scope="module")
def text(tmp_path_factory: pytest.TempPathFactory, table: Path) -> Path:
    """Return the trace of a few turns of cutting, as camsim writes it, beside other tables."""
    folder = tmp_path_factory.mktemp("text")
    names = ("trace.csv", *TABLES)
    words = (word for name in names for word in (f"--{name[:-4]}", folder / name))
    assert camsim("run", table, *CUT, *words).returncode == 0
    return folder / "trace.csv"


@pytest.fixture(scope="module")
def packed(tmp_path_factory: pytest.TempPathFactory, table: Path) -> Path:
    """Return the same as Parquet, written in groups in this process, beside the same tables."""
    folder = tmp_path_factory.mktemp("packed")
    names = ("trace.parquet", "trace.csv", *TABLES)
    files = {str(folder / name): name.partition(".")[0] for name in names}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(simulate, "TICKS_AT_A_TIME", 700)
        patch.setattr(simulate, "GROUP_ROWS", 3000)
        simulate.cut([str(table), *CUT], files=files)
    return folder / "trace.parquet"


@pytest.mark.parametrize("name", ["trace.csv", *TABLES])
def test_text_is_that_of_the_program(name: str, text: Path, packed: Path) -> None:
    """Byte by byte; the program formats in C."""
    assert text.with_name(name).stat().st_size > 10_000
    assert first_difference(text.with_name(name), packed.with_name(name)) == ""


def test_every_number_is_that_of_the_text(text: Path, packed: Path) -> None:
    """Read by Python's own float; every 7th row."""
    header, *lines = text.read_text("ascii").splitlines()
    names, rows = header.split(","), [line.split(",") for line in lines[::7]]
    cells = dict(zip(names, zip(*rows, strict=True), strict=True))
    kept = column_names(packed)
    assert {*kept, *DUPLICATES} == {*names}
    assert pq.ParquetFile(packed).num_row_groups > 5
    found = read_columns(packed, kept)
    for name in kept:
        ours, theirs = found[name][::7], cells[name]
        if name == "state":
            assert [STATES[number] for number in ours] == list(theirs)
        elif name == "faults":
            assert ours.tolist() == [int(cell, 16) for cell in theirs]
        else:
            assert np.array_equal(ours, np.array(theirs, dtype=float)), name
    for name, (other, n) in DUPLICATES.items():  # a column kept once gives the other back
        whole = np.rint(found[other][::7] * n).astype(int)
        assert whole.tolist() == [int(cell) for cell in cells[name]], name
    assert read_swing(packed) is None


def test_states_are_those_of_the_firmware() -> None:
    """By their numbers, as the bus has them."""
    assert dict(enumerate(STATES)) == NAMES["state"]


def test_other_tools_read_plain_numbers_within_a_quarter_of_a_digit(packed: Path) -> None:
    """Doubles and integers, and words; no decimals, which many do not know."""
    table = pq.read_table(packed, columns=["t_s", "radius_mm", "in_counts", "state"])
    kinds = [pa.float64(), pa.float64(), pa.int64(), pa.dictionary(pa.int32(), pa.string())]
    assert table.schema.types == kinds
    exact = read_columns(packed, ["radius_mm"])["radius_mm"]
    assert np.abs(table["radius_mm"].to_numpy() - exact).max() <= 0.25e-9


def test_it_takes_a_tenth_of_the_text(text: Path, packed: Path) -> None:
    """The whole Perkins cut has 97 MB of text, of which at most 10 MB are left."""
    assert packed.stat().st_size < 0.1 * text.stat().st_size


def test_a_table_without_rows_is_a_file_without_rows(tmp_path: Path) -> None:
    """As of a cut that ended before its first tick."""
    columns = (Column("tick", "0"), Column("t_s", "9"), Column("state", "s"))
    with ParquetFile(tmp_path / "trace.parquet", columns) as file:
        file.write(np.empty((0, 3), dtype=np.int64))
    found = read_columns(tmp_path / "trace.parquet", ("tick", "t_s", "state"))
    assert [len(values) for values in found.values()] == [0, 0, 0]
