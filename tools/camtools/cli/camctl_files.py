"""Files of recordings: CSV and Parquet, in the controller's own numbers or in units of people.

>>> names_of("state,u_actual_nm")
['state', 'u_actual_nm']
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated, Any

import pyarrow as pa

from camtools.base.arguments import Option, whole_within
from camtools.base.errors import CamtoolsError
from camtools.base.files import write_all
from camtools.base.parquet import parquet_bytes
from camtools.link import scope
from camtools.link.signals import faults_in, physical

Say = Callable[[str], None]
DEFAULT_SIGNALS = ",".join(scope.DEFAULT_SIGNALS)
Signals = Annotated[
    str,
    Option("signals to record; tools/docs/SCOPE.md lists them (default: %(default)s)", "A,B,.."),
]
count = whole_within(1, 1_000_000)
_SUFFIXES = (".csv", ".parquet")
ABOUT = "camturn.recording"
_ABOUT = ("tick_hz", "every", "first_tick", "trigger_tick", "n_before", "end")


def names_of(text: str) -> list[str]:
    """Return the signals of a list; an unknown one is an error."""
    names = text.split(",")
    scope.mask_of(names)
    return names


def check_name(path: Path) -> None:
    """Refuse a file whose suffix names no format."""
    if path.suffix not in _SUFFIXES:
        raise CamtoolsError([f"{path}: give a name that ends in {' or '.join(_SUFFIXES)}"])


def _raw_csv(recording: scope.Recording) -> Iterator[bytes]:
    """Return the lines of a recording, as camsim identify writes them."""
    yield (",".join(("tick", "t_s", *recording.signals)) + "\n").encode()
    for i, (tick, row) in enumerate(zip(recording.tick, recording.rows, strict=True)):
        t_s = i * recording.every / recording.tick_hz
        yield (f"{tick},{t_s:.9f}," + ",".join(map(str, row)) + "\n").encode()


def write_raw(path: Path, recording: scope.Recording, say: Say) -> None:
    """Write a recording as CSV, in the controller's numbers."""
    write_all(path.parent, {path.name: _raw_csv(recording)})
    _report(path, recording, say)


def _report(path: Path, recording: scope.Recording, say: Say) -> None:
    n = len(recording.rows)
    say(f"{path}: {n} rows of {len(recording.signals)} signals at {recording.tick_hz} Hz")


def file_bytes(path: Path, recording: scope.Recording, *, is_raw: bool) -> bytes:
    """Return a recording in the format of its file's suffix.

    The first column is the time from the trigger on; every column is a number, because PlotJuggler
    before 3.14 opens no Parquet file with text in it.
    """
    raw = {name: recording[name] for name in recording.signals}
    signals = raw if is_raw else physical(recording)
    columns: dict[str, Any] = {"t_s": recording.t_s, "tick": recording.tick} | signals
    if path.suffix == ".csv":
        rows = zip(*(column.tolist() for column in columns.values()), strict=True)
        lines = [",".join(columns), *(",".join(f"{value:.12g}" for value in row) for row in rows)]
        return ("\n".join(lines) + "\n").encode()
    whole, broken = pa.int64(), pa.float64()
    kinds = [(name, whole if c.dtype.kind == "i" else broken) for name, c in columns.items()]
    about = {name: getattr(recording, name) for name in _ABOUT}
    about["faults"] = faults_in(recording.faults)
    return parquet_bytes(columns, pa.schema(kinds), {ABOUT: json.dumps(about)})


def write(
    path: Path, recording: scope.Recording, pictures: dict[Path, bytes], say: Say, *, is_raw: bool
) -> None:
    """Write a recording and its pictures; each folder gets all of its files or none."""
    files = {path: file_bytes(path, recording, is_raw=is_raw), **pictures}
    for folder in {file.parent for file in files}:
        here = {file.name: data for file, data in files.items() if file.parent == folder}
        write_all(folder, here)
    _report(path, recording, say)
    for picture in pictures:
        say(f"{picture}: drawn")
