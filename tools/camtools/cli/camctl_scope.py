# SPDX-License-Identifier: Apache-2.0
r"""Subcommands of camctl about the recorder, the excitation of U, and learned values.

>>> wave_of(b"u_nm\n3\n-4\n", "w.csv").tolist()
[3, -4]
"""

from __future__ import annotations

import argparse
import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import numpy.typing as npt

from camtools.base.command import Interrupted
from camtools.base.errors import CamtoolsError
from camtools.base.input_file import read_limited
from camtools.base.output import write_all
from camtools.link import scope
from camtools.link.controller import NUMBERS, Link, Refused
from camtools.link.learned import (
    get_learned,
    learned_text,
    learned_values,
    learning_report,
    set_learned,
)

_MOST_BYTES = 16 * 1024 * 1024
_PATIENCE_S = 3600.0
Say = Callable[[str], None]


def _read(path: Path) -> bytes:
    try:
        return read_limited(path, _MOST_BYTES)
    except OSError as error:
        raise CamtoolsError([f"{path}: {error.strerror}; check the path"]) from error


def wave_of(data: bytes, name: str) -> npt.NDArray[np.int64]:
    """Return the samples of a wave file.

    Raises
    ------
    CamtoolsError
        It is none; the line says where.
    """
    lines = data.decode("utf-8", "replace").split("\n")
    if lines[0].strip() != "u_nm":
        raise CamtoolsError([f"{name}: line 1: no u_nm; begin with the column's name"])
    samples = []
    for number, line in enumerate(lines[1:], start=2):
        if not line and number == len(lines):
            continue
        try:
            samples.append(int(line))
            if abs(samples[-1]) >= 2**31:
                raise ValueError
        except ValueError as error:
            text = f"{name}: line {number}: {line[:40]}: give a whole number of nm"
            raise CamtoolsError([text]) from error
    if not samples:
        raise CamtoolsError([f"{name}: no samples; give one in each line behind u_nm"])
    return np.array(samples, np.int64)


def _csv(recording: scope.Recording) -> Iterator[bytes]:
    """Return the lines of a recording, as camsim identify writes them."""
    yield (",".join(("tick", "t_s", *recording.signals)) + "\n").encode()
    for i, (tick, row) in enumerate(zip(recording.tick, recording.rows, strict=True)):
        t_s = i * recording.every / recording.tick_hz
        yield (f"{tick},{t_s:.9f}," + ",".join(map(str, row)) + "\n").encode()


def _write(path: Path, recording: scope.Recording, say: Say) -> None:
    write_all(path.parent, {path.name: _csv(recording)})
    n = len(recording.rows)
    say(f"{path}: {n} rows of {len(recording.signals)} signals at {recording.tick_hz} Hz")


def _names(text: str) -> list[str]:
    names = text.split(",")
    scope.mask_of(names)
    return names


def _rows_of(link: Link, seconds: float | None, every: int) -> int:
    """Return the rows of that time; 0: as many as fit."""
    if seconds is None:
        return 0
    return max(1, round(seconds * scope.get(link, "tick_hz") / every))


def _record(link: Link, arguments: argparse.Namespace) -> None:
    rows = _rows_of(link, arguments.seconds, arguments.every)
    scope.configure(link, _names(arguments.signals), arguments.every, rows)
    state = arguments.from_state
    scope.put(link, "from_state", -1 if state is None else NUMBERS["state"][state])
    scope.start(link)
    with contextlib.suppress(Interrupted):
        scope.wait(link, _PATIENCE_S)
    scope.stop(link)


def record_ticks(link: Link, arguments: argparse.Namespace, say: Say) -> None:
    """Record signals of ticks in the controller's memory, and write them into a CSV file.

    Interrupted, it writes what is there by then. With `again` it reads the recording that is there.

    Raises
    ------
    Refused
        The controller refuses, or ticks were lost; then their rows are not written.
    """
    if not arguments.again:
        _record(link, arguments)
    recording = scope.read(link)
    if not recording.is_whole:
        raise Refused(
            f"{arguments.file}: not written: {recording.n_lost} ticks were lost behind row "
            f"{len(recording.rows)}; record fewer signals"
        )
    _write(arguments.file, recording, say)


def excite(link: Link, arguments: argparse.Namespace, say: Say) -> None:
    """Let U play the wave of a file, and write what was recorded until its amplitude falls."""
    recording = scope.excite(
        link,
        wave_of(_read(arguments.wave), str(arguments.wave)),
        arguments.periods,
        fade_ticks=arguments.fade_ticks,
        place_nm=arguments.place_nm,
        signals=_names(arguments.signals),
    )
    _write(arguments.file, recording.played(), say)


def learned(link: Link, arguments: argparse.Namespace, say: Say) -> None:
    """Print what learning does, save what was learned, or bring it back."""
    if (arguments.action is None) != (arguments.file is None):
        raise CamtoolsError(["learned: give save FILE or load FILE, or neither"])
    path: Path = arguments.file
    if arguments.action == "save":
        text = learned_text(get_learned(link), link.listen().table_name)
        write_all(path.parent, {path.name: text.encode()})
        say(f"{path}: saved")
    elif arguments.action == "load":
        set_learned(link, learned_values(_read(path), str(path)))
        say(f"{path}: in force")
    else:
        for line in learning_report(link.listen()):
            say(line)
