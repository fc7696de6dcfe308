"""Commands of camctl about the recorder: scope and blackbox.

>>> numbered(Path("run.csv"), 2, 12), numbered(Path("run.csv"), 1, 1)
(PosixPath('run-02.csv'), PosixPath('run.csv'))
"""

from __future__ import annotations

import contextlib
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np

from camtools.base.arguments import Option, Word, not_negative, positive
from camtools.base.errors import CamtoolsError
from camtools.base.signals import Interrupted
from camtools.cli import camctl_files
from camtools.cli.camctl_control import Control
from camtools.cli.camctl_files import Say, count
from camtools.link import scope as recorder
from camtools.link.controller import Link
from camtools.link.messages import FAULT_TEXTS, NUMBERS, Refused
from camtools.link.signals import BITS, GRAMMAR, arm, faults_in, physical, state_name, trigger_of
from camtools.link.status_text import sparkline

_PATIENCE_S = 3600.0
_BARS = 60
_TENTH = 10  # per cent of what is read, between two lines of progress
_OF_ANGLE = "angle_q32"
_PAUSED = (
    "the black box is paused until --again reads the recording, for 10 minutes at most; "
    "camctl blackbox --clear ends that"
)


def numbered(path: Path, number: int, n_files: int) -> Path:
    """Return the name of one of several files; that of a single one stays."""
    if n_files == 1:
        return path
    return path.with_stem(f"{path.stem}-{number:0{len(str(n_files))}d}")


@dataclass(frozen=True)
class Pictures:
    """How a recording is written and drawn."""

    raw: Annotated[bool, Option("write the controller's integers instead of physical units")] = (
        False
    )
    plot: Annotated[Path | None, Option("plot the signals over time into this file", "PNG")] = None
    over_angle: Annotated[
        Path | None, Option("plot the signals over the spindle angle into this file", "PNG")
    ] = None
    keep: Annotated[bool, Option("keep the recording in the controller's memory")] = False


@dataclass(frozen=True)
class Recording:
    """What is recorded."""

    signals: camctl_files.Signals = camctl_files.DEFAULT_SIGNALS
    trigger: Annotated[str, Option(f"start of the recording: {GRAMMAR} (default: now)")] = "now"
    before: Annotated[
        float, Option("seconds kept before the trigger (default: 0)", read=not_negative)
    ] = 0.0
    seconds: Annotated[
        float | None, Option("length in all (default: until memory is full)", read=positive)
    ] = None
    every: Annotated[int, Option("record one tick of N (default: 1)", "N", read=count)] = 1
    from_state: Annotated[
        str | None,
        Option("record only in this state (default: in any)", choices=tuple(NUMBERS["state"])),
    ] = None
    repeat: Annotated[
        int, Option("number of recordings, into numbered files (default: 1)", "N", read=count)
    ] = 1
    again: Annotated[bool, Option("read the recording already in memory")] = False


# What is drawn and said of a recording


def _pictures(wanted: Pictures, recording: recorder.Recording) -> dict[Path, bytes]:
    if not (wanted.plot or wanted.over_angle):
        return {}
    from camtools.plots.recording import angle_picture, time_picture  # takes a second to load

    columns = physical(recording)
    made = {}
    if wanted.plot:
        states = {int(n): state_name(int(n)) for n in np.unique(columns.get("state", []))}
        names = faults_in(recording.faults)
        made[wanted.plot] = time_picture(recording.t_s, columns, states, ", ".join(names), BITS)
    if wanted.over_angle:
        if _OF_ANGLE not in recording.signals:
            problem = f"--over-angle: {_OF_ANGLE} was not recorded"
            raise CamtoolsError([f"{problem}; add it to --signals"])
        made[wanted.over_angle] = angle_picture(columns)
    return made


def _lines(recording: recorder.Recording) -> list[str]:
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


def _read(link: Link, say: Say) -> recorder.Recording:
    """Read the recording that is there, with a line at every tenth."""
    last = 0

    def progress(there: int, in_all: int) -> None:
        nonlocal last
        percent = there * 100 // in_all
        if percent // _TENTH > last // _TENTH and in_all > 1 << 16:
            say(f"{there} of {in_all} bytes read, {percent} %")
        last = percent

    return recorder.read(link, progress)


def _finish(
    control: Control, recording: recorder.Recording, path: Path, wanted: Pictures, number: str = ""
) -> None:
    """Write what was read, pictures with a number; give the memory back to the black box."""
    say = control.say
    made = _pictures(wanted, recording)
    pictures = {picture.with_stem(picture.stem + number): data for picture, data in made.items()}
    camctl_files.write(path, recording, pictures, say, is_raw=wanted.raw)
    control.say(*_lines(recording))
    if not wanted.keep:
        recorder.release(control.link)


# scope


def _configure(link: Link, wanted: Recording, *, has_angle: bool) -> None:
    tick_hz = recorder.get(link, "tick_hz")
    trigger = trigger_of(wanted.trigger, tick_hz)
    per_s = tick_hz / wanted.every
    rows = max(1, round(wanted.seconds * per_s)) if wanted.seconds else 0
    before = round(wanted.before * per_s)
    if max(rows, before) >= 2**31:
        name = "seconds" if rows > before else "before"
        value = getattr(wanted, name)
        raise CamtoolsError([f"--{name} {value:g}: give less than {2**31 / per_s:.0f} s"])
    if rows and before >= rows:
        text = f"--before {wanted.before:g}: give less than --seconds {wanted.seconds:g}"
        raise CamtoolsError([text])
    names = camctl_files.names_of(wanted.signals)
    signals = names if not has_angle or _OF_ANGLE in names else [*names, _OF_ANGLE]
    recorder.configure(link, signals, wanted.every, rows)
    arm(link, trigger, before)
    state = wanted.from_state
    recorder.put(link, "from_state", -1 if state is None else NUMBERS["state"][state])


def _record(link: Link, say: Say) -> bool:
    """Record once; return whether it ended by itself."""
    recorder.start(link)
    try:
        recorder.wait(link, _PATIENCE_S)
    except Interrupted:
        say("interrupted: reading what was recorded so far")
        return False
    finally:
        with contextlib.suppress(Refused):
            recorder.stop(link)
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


def scope(
    control: Control,
    file: Annotated[Path, Word("file to write, .csv or .parquet")],
    wanted: Recording,
    pictures: Pictures,
) -> None:
    """Record signals tick by tick, write and plot them.

    Interrupted, it writes what is there by then. With `again` it reads the recording that is there.
    """
    link, say = control.link, control.say
    camctl_files.check_name(file)
    if not wanted.again:
        _configure(link, wanted, has_angle=pictures.over_angle is not None)
    for number in range(1, wanted.repeat + 1):
        is_whole = wanted.again or _record(link, say)
        path = numbered(file, number, wanted.repeat)
        try:
            recording = _read(link, say)
        except Refused as error:
            raise Refused(f"{error}; {_PAUSED}") from error
        if not recording.is_whole and not pictures.keep:
            recorder.release(link)
        link.rights.release()  # to write and draw takes longer than command lasts without a word
        if not recording.is_whole:
            raise Refused(
                f"{path}: not written: {recording.n_lost} ticks were lost after row "
                f"{len(recording.rows)}; record fewer signals"
            )
        if is_whole and wanted.seconds and not (wanted.again or wanted.from_state):
            n_rows, per_s = len(recording.rows), recording.tick_hz / recording.every
            if line := shorter(wanted.seconds, n_rows, per_s):
                say(line)
        _finish(control, recording, path, pictures, path.stem.removeprefix(file.stem))
        if not is_whole:
            return


# blackbox


def _is_unread(link: Link) -> bool:
    return recorder.USES[recorder.get(link, "use")] == "box" and recorder.phase(link) == "done"


def _tell(link: Link, say: Say) -> None:
    """Say which fault the box is of, or why there is none."""
    use = recorder.USES[recorder.get(link, "use")]
    if not _is_unread(link):
        texts = {
            "box": "recording; no fault since it was last read",
            "user": "paused: the memory holds a recording; camctl scope FILE --again reads it",
            "nobody": "off: the port has no memory for it",
        }
        say(f"black box         {texts[use]}")
        return
    names = faults_in(recorder.get(link, "faults"))
    tick, every = recorder.get(link, "trigger_tick"), recorder.get(link, "every")
    hz, n, before = (recorder.get(link, name) for name in ("tick_hz", "n_rows", "n_before"))
    say(f"black box         unread: {', '.join(names)} in tick {tick}")
    for name in names:
        say(f"                  {FAULT_TEXTS[name]}")
    seconds = (before * every / hz, (n - before) * every / hz)
    say(f"                  {seconds[0]:.3f} s before it and {seconds[1]:.3f} s after it")


def blackbox(
    control: Control,
    pictures: Pictures,
    file: Annotated[
        Path | None, Word("file to write, .csv or .parquet (default: only show what is held)")
    ] = None,
    *,
    clear: Annotated[bool, Option("discard the recorded fault and record again")] = False,
) -> None:
    """Show or read the recording from before the last fault."""
    link = control.link
    if file is not None:
        camctl_files.check_name(file)
    _tell(link, control.say)
    if clear:
        recorder.release(link)
        control.say("black box         cleared; recording")
        return
    if file is None:
        return
    if not _is_unread(link):
        raise Refused(f"{file}: not written: the black box holds no fault")
    _finish(control, _read(link, control.say), file, pictures)
