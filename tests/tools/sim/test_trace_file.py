# SPDX-License-Identifier: Apache-2.0
"""The trace as Parquet: the numbers of the text to the last bit, in a tenth of it."""

import io
import os
import threading
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from camtools.link.messages import NAMES
from camtools.sim import trace_file
from camtools.sim.results import STATES, read_swing, read_trace
from camtools.sim.trace_file import TOLD_TWICE, column_names, pack_trace, read_columns
from tests.tools.cases.camsim_cases import cut


@pytest.fixture(scope="module")
def text(tmp_path_factory: pytest.TempPathFactory, table: Path) -> Path:
    """Return the trace of a few turns of cutting, as camsim writes it."""
    folder = tmp_path_factory.mktemp("trace")
    cut(table, folder, "--turns-limit", "15", "--trace", folder / "trace.csv")
    return folder / "trace.csv"


@pytest.fixture(scope="module")
def packed(text: Path) -> Path:
    """Return the same as Parquet."""
    path = text.with_suffix(".parquet")
    with text.open("rb") as stream:
        assert pack_trace(stream, path) == len(text.read_bytes().splitlines()) - 1
    return path


def test_every_number_is_that_of_the_text(text: Path, packed: Path) -> None:
    """Read by Python's own float, not by the reader of pyarrow that packed it; every 7th row."""
    header, *lines = text.read_text("ascii").splitlines()
    names, rows = header.split(","), [line.split(",") for line in lines[::7]]
    cells = dict(zip(names, zip(*rows, strict=True), strict=True))
    kept = column_names(packed)
    assert {*kept, *TOLD_TWICE} == {*names}
    found = read_columns(packed, kept)
    for name in kept:
        ours, theirs = found[name][::7], cells[name]
        if name == "state":
            assert ours.tolist() == list(theirs)
        elif name == "faults":
            assert ours.tolist() == [int(cell, 16) for cell in theirs]
        else:
            assert np.array_equal(ours, np.array(theirs, dtype=float)), name


def test_what_is_told_once_gives_the_other_column_back(text: Path, packed: Path) -> None:
    """In whole numbers."""
    header, *lines = text.read_text("ascii").splitlines()
    names, rows = header.split(","), [line.split(",") for line in lines[::7]]
    for name, (other, n) in TOLD_TWICE.items():
        (kept,) = read_columns(packed, [other]).values()
        told = [int(row[names.index(name)]) for row in rows]
        assert np.rint(kept[::7] * n).astype(int).tolist() == told, name


def test_readers_take_both(text: Path, packed: Path) -> None:
    """The report sees no difference."""
    for ours, theirs in zip(read_trace(packed), read_trace(text), strict=True):
        assert np.array_equal(ours, theirs)
    assert read_swing(packed) is None and read_swing(text) is None


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


def test_bytes_do_not_depend_on_how_the_text_came(
    text: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All at once, or through a pipe in small pieces; rows come in many groups here."""
    monkeypatch.setattr(trace_file, "_GROUP_ROWS", 1000)
    monkeypatch.setattr(trace_file, "_BLOCK_BYTES", 1 << 16)
    whole, piped = tmp_path / "whole", tmp_path / "piped"
    content = text.read_bytes()
    pack_trace(io.BytesIO(content), whole)
    ours, theirs = os.pipe()

    def speak() -> None:
        with os.fdopen(theirs, "wb", buffering=0) as pipe:
            for at in range(0, len(content), 7777):
                pipe.write(content[at : at + 7777])

    thread = threading.Thread(target=speak)
    thread.start()
    with os.fdopen(ours, "rb") as stream:
        pack_trace(stream, piped)
    thread.join()
    assert whole.read_bytes() == piped.read_bytes()
    assert pq.ParquetFile(whole).num_row_groups > 5


def test_it_takes_a_tenth_of_the_text(text: Path, packed: Path) -> None:
    """The whole Perkins cut has 97 MB of text, of which at most 10 MB are left."""
    assert packed.stat().st_size < 0.1 * text.stat().st_size


@pytest.mark.parametrize(("content", "rows"), [(b"", None), (b"tick,t_s,state\n", 0)])
def test_a_text_without_rows_is_no_error(content: bytes, rows: int | None, tmp_path: Path) -> None:
    """Nothing at all is no file."""
    path = tmp_path / "trace.parquet"
    assert pack_trace(io.BytesIO(content), path) == 0
    assert path.exists() == (rows is not None)
    if rows is not None:
        assert pq.read_table(path).num_rows == rows
