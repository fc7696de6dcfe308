# SPDX-License-Identifier: Apache-2.0
"""Subcommands of camctl about the recorder: scope and blackbox.

>>> numbered(Path("run.csv"), 2, 12), numbered(Path("run.csv"), 1, 1)
(PosixPath('run-02.csv'), PosixPath('run.csv'))
"""

from __future__ import annotations

import argparse
import contextlib
from pathlib import Path

import numpy as np

from camtools.base.command import Interrupted
from camtools.base.errors import CamtoolsError
from camtools.cli.camctl_files import Say, check_name, names_of, write
from camtools.link import scope
from camtools.link.controller import Link
from camtools.link.messages import FAULT_TEXTS, NUMBERS, Refused
from camtools.link.signals import BITS, faults_in, physical, state_name
from camtools.link.status_text import sparkline
from camtools.link.trigger import arm, trigger_of

_PATIENCE_S = 3600.0
_BARS = 60
_TENTH = 10  # per cent of what is read, between two lines of progress
_OF_ANGLE = "angle_q32"


def numbered(path: Path, number: int, of: int) -> Path:
    """Return the name of one of several files; that of a single one stays."""
    if of == 1:
        return path
    return path.with_stem(f"{path.stem}-{number:0{len(str(of))}d}")


# What is drawn and said of a recording


def _pictures(arguments: argparse.Namespace, recording: scope.Recording) -> dict[str, bytes]:
    """Return the pictures that were asked for, by their option."""
    if not (arguments.plot or arguments.over_angle):
        return {}
    from camtools.plots.recording import angle_picture, time_picture  # takes a second to load

    columns = physical(recording)
    made = {}
    if arguments.plot:
        states = {int(n): state_name(int(n)) for n in np.unique(columns.get("state", []))}
        names = faults_in(recording.faults)
        made["plot"] = time_picture(recording.t_s, columns, states, ", ".join(names), BITS)
    if arguments.over_angle:
        if _OF_ANGLE not in recording.signals:
            raise CamtoolsError(
                [f"--over-angle: {_OF_ANGLE} was not recorded; add it to --signals"]
            )
        made["over_angle"] = angle_picture(columns)
    return made


def _lines(recording: scope.Recording) -> list[str]:
    """Return a line for each signal: its range, and its course as bars."""
    lines = []
    for name, values in physical(recording).items():
        if len(values) == 0:
            continue
        parts = np.array_split(values, min(_BARS, len(values)))
        low, high = values.min(), values.max()
        bars = sparkline([part.mean() - low for part in parts], high - low)
        lines.append(f"{name:<18}{low:14.6g} .. {high:<14.6g}|{bars}|")
    return lines


def _read(link: Link, say: Say) -> scope.Recording:
    """Read the recording that is there, with a line at every tenth."""
    last = 0

    def progress(there: int, in_all: int) -> None:
        nonlocal last
        percent = there * 100 // in_all
        if percent // _TENTH > last // _TENTH and in_all > 1 << 16:
            say(f"{there} of {in_all} bytes read, {percent} %")
        last = percent

    return scope.read(link, progress)


def _finish(
    link: Link, arguments: argparse.Namespace, recording: scope.Recording, path: Path, say: Say
) -> None:
    """Write what was read and give the memory back to the black box."""
    options = ("plot", "over_angle")
    made = _pictures(arguments, recording)
    names = {name: getattr(arguments, name) for name in options if name in made}
    stem = path.stem.removeprefix(arguments.file.stem)  # the number, of several
    pictures = {one.with_stem(one.stem + stem): made[name] for name, one in names.items()}
    write(path, recording, pictures, say, is_raw=arguments.raw)
    for line in _lines(recording):
        say(line)
    if not arguments.keep:
        scope.release(link)


# scope


def _read_or_pause(link: Link, say: Say) -> scope.Recording:
    """Read the recording that is there; a failure names what that means for the black box."""
    try:
        return _read(link, say)
    except Refused as error:
        paused = (
            "the black box is paused until --again reads the recording, for 10 minutes at most; "
            "camctl blackbox --clear ends that"
        )
        raise Refused(f"{error}; {paused}") from error


def _configure(link: Link, arguments: argparse.Namespace) -> None:
    """Set what the recordings are to be."""
    tick_hz = scope.get(link, "tick_hz")
    trigger = trigger_of(arguments.trigger, tick_hz)
    per_s = tick_hz / arguments.every
    rows = max(1, round(arguments.seconds * per_s)) if arguments.seconds else 0
    before = round(arguments.before * per_s)
    if max(rows, before) >= 2**31:
        name = "seconds" if rows > before else "before"
        value = getattr(arguments, name)
        raise CamtoolsError([f"--{name} {value:g}: give less than {2**31 / per_s:.0f} s"])
    if rows and before >= rows:
        text = f"--before {arguments.before:g}: give less than --seconds {arguments.seconds:g}"
        raise CamtoolsError([text])
    names = names_of(arguments.signals)
    signals = names if not arguments.over_angle or _OF_ANGLE in names else [*names, _OF_ANGLE]
    scope.configure(link, signals, arguments.every, rows)
    arm(link, trigger, before)
    state = arguments.from_state
    scope.put(link, "from_state", -1 if state is None else NUMBERS["state"][state])


def _record(link: Link, say: Say) -> bool:
    """Record once; return whether it ended by itself."""
    scope.start(link)
    try:
        scope.wait(link, _PATIENCE_S)
    except Interrupted:
        say("interrupted: reading what was recorded so far")
        return False
    finally:
        with contextlib.suppress(Refused):
            scope.stop(link)
    return True


def shorter(asked_s: float, n_rows: int, rows_per_s: float) -> str:
    """Return the line for a recording that is shorter than was asked for; "" for one that is not.

    >>> shorter(0.5, 9000, 20_000)
    '--seconds 0.5: the memory held 0.450 s; record fewer signals, or give a larger --every'
    >>> shorter(0.45, 9000, 20_000)
    ''
    """
    if n_rows >= round(asked_s * rows_per_s):
        return ""
    there = f"--seconds {asked_s:g}: the memory held {n_rows / rows_per_s:.3f} s"
    return f"{there}; record fewer signals, or give a larger --every"


def scope_ticks(link: Link, arguments: argparse.Namespace, say: Say) -> None:
    """Record signals of ticks in the controller's memory, and write, draw and tell them.

    Interrupted, it writes what is there by then. With `again` it reads the recording that is there.

    Raises
    ------
    Refused
        The controller refuses, or ticks were lost; then their rows are not written.
    """
    check_name(arguments.file)
    if not arguments.again:
        _configure(link, arguments)
    for number in range(1, arguments.repeat + 1):
        is_whole = arguments.again or _record(link, say)
        path = numbered(arguments.file, number, arguments.repeat)
        recording = _read_or_pause(link, say)
        if not recording.is_whole and not arguments.keep:
            scope.release(link)
        link.rights.release()  # to write and draw takes longer than command lasts without a word
        if not recording.is_whole:
            raise Refused(
                f"{path}: not written: {recording.n_lost} ticks were lost after row "
                f"{len(recording.rows)}; record fewer signals"
            )
        if is_whole and arguments.seconds and not (arguments.again or arguments.from_state):
            n_rows, per_s = len(recording.rows), recording.tick_hz / recording.every
            if line := shorter(arguments.seconds, n_rows, per_s):
                say(line)
        _finish(link, arguments, recording, path, say)
        if not is_whole:
            return


# blackbox


def _is_unread(link: Link) -> bool:
    return scope.USES[scope.get(link, "use")] == "box" and scope.phase(link) == "done"


def _tell(link: Link, say: Say) -> None:
    """Say which fault the box is of, or why there is none."""
    use = scope.USES[scope.get(link, "use")]
    if not _is_unread(link):
        texts = {
            "box": "recording; no fault since it was last read",
            "user": "paused: the memory holds a recording; camctl scope FILE --again reads it",
            "nobody": "off: the port has no memory for it",
        }
        say(f"black box         {texts[use]}")
        return
    names = faults_in(scope.get(link, "faults"))
    tick, every = scope.get(link, "trigger_tick"), scope.get(link, "every")
    hz, n, before = (scope.get(link, name) for name in ("tick_hz", "n_rows", "n_before"))
    say(f"black box         unread: {', '.join(names)} in tick {tick}")
    for name in names:
        say(f"                  {FAULT_TEXTS[name]}")
    seconds = (before * every / hz, (n - before) * every / hz)
    say(f"                  {seconds[0]:.3f} s before it and {seconds[1]:.3f} s after it")


def blackbox(link: Link, arguments: argparse.Namespace, say: Say) -> None:
    """Tell what the black box holds, read it into a file, or clear it.

    Raises
    ------
    Refused
        There is no fault to be read.
    """
    if arguments.file is not None:
        check_name(arguments.file)
    _tell(link, say)
    if arguments.clear:
        scope.release(link)
        say("black box         cleared; recording")
        return
    if arguments.file is None:
        return
    if not _is_unread(link):
        raise Refused(f"{arguments.file}: not written: the black box holds no fault")
    _finish(link, arguments, _read(link, say), arguments.file, say)
