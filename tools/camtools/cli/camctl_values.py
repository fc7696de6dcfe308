r"""Commands of camctl about parameters, learned values and the excitation of U.

>>> wave_of(b"force_mn\n3\n-4\n", "w.csv")
(array([ 3, -4]), 'mN')

>>> print(*table({"lead_ns": (50000, 60000)}, ("file", "controller")), sep="\n")
parameter           file  controller
lead_ns            50000       60000
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated

import numpy as np
import numpy.typing as npt

from camtools.base.arguments import Commands, Option, Word, whole
from camtools.base.errors import CamtoolsError
from camtools.base.files import path_errors, read_limited, write_all
from camtools.cli.camctl_control import Control
from camtools.cli.camctl_files import (
    DEFAULT_SIGNALS,
    Say,
    Signals,
    count,
    names_of,
    write_raw,
)
from camtools.link import excitation, kept_values
from camtools.link.messages import Refused

_MOST_WAVE_BYTES = 16 * 1024 * 1024
_UNITS = {heading: unit for unit, heading in excitation.HEADINGS.items()}


def _read_wave(path: Path) -> bytes:
    with path_errors(path):
        return read_limited(path, _MOST_WAVE_BYTES)


def wave_of(data: bytes, name: str) -> tuple[npt.NDArray[np.int64], excitation.Unit]:
    """Return the samples of a wave file, and their unit by its heading; an error names the line."""
    lines = data.decode("utf-8", "replace").split("\n")
    unit = _UNITS.get(lines[0].strip())
    if unit is None:
        text = f"{name}: line 1: no heading u_nm or force_mn; begin the file with it"
        raise CamtoolsError([text])
    samples = []
    for number, line in enumerate(lines[1:], start=2):
        if not line and number == len(lines):
            continue
        try:
            samples.append(int(line))
            if abs(samples[-1]) >= 2**31:
                raise ValueError
        except ValueError as error:
            text = f"{name}: line {number}: no whole number of {unit}, below 2^31; write one"
            raise CamtoolsError([text]) from error
    if not samples:
        raise CamtoolsError([f"{name}: no samples; give one per line after {lines[0].strip()}"])
    return np.array(samples, np.int64), unit


def excite(
    control: Control,
    wave: Annotated[
        Path,
        Word("CSV with the heading u_nm, then one position in nm per tick; or force_mn and forces"),
    ],
    file: Annotated[Path, Word("CSV file to write")],
    *,
    periods: Annotated[int, Option("periods at full amplitude (default: 5)", "N", read=count)] = 5,
    fade_ticks: Annotated[
        int, Option("ticks of fading in and out (default: 2000)", "N", read=count)
    ] = 2000,
    place_nm: Annotated[int, Option("mean position of U in nm (default: 0)", "NM", read=whole)] = 0,
    signals: Signals = DEFAULT_SIGNALS,
) -> None:
    """In ready: move U along a wave and record it."""
    samples, unit = wave_of(_read_wave(wave), str(wave))
    recording = excitation.excite(
        *(control.link, samples, periods),
        unit=unit,
        fade_ticks=fade_ticks,
        place_nm=place_nm,
        signals=names_of(signals),
    )
    write_raw(file, recording.played(), control.say)


def learned(
    control: Control,
    action: Annotated[str | None, Word("default: print", choices=("save", "load"))] = None,
    file: Annotated[Path | None, Word("TOML file, with save and load")] = None,
) -> None:
    """Print, save or load the learned correction."""
    link = control.link
    if (action is None) != (file is None):
        raise CamtoolsError(["learned: give save FILE or load FILE, or neither"])
    if file is None:
        control.say(*kept_values.learning_report(link.listen()))
    elif action == "save":
        text = kept_values.learned_text(kept_values.get_learned(link), link.listen().table_name)
        write_all(file.parent, {file.name: text.encode()})
        control.say(f"{file}: saved")
    else:
        kept_values.set_learned(link, kept_values.learned_values(_read_wave(file), str(file)))
        control.say(f"{file}: in force")


_MOST_BYTES = 1024 * 1024
TomlFile = Annotated[Path, Word("TOML file")]


def table(pairs: Mapping[str, tuple[int, int]], heads: tuple[str, str]) -> list[str]:
    """Return a line for each parameter with two values, below a line of heads if there are any."""
    if not pairs:
        return []
    width = max(map(len, pairs))
    rows = [("parameter", *heads), *((name, *map(str, two)) for name, two in pairs.items())]
    return [f"{name:<{max(width, 12)}}{a:>12}{b:>12}" for name, a, b in rows]


def _read(path: Path, say: Say) -> dict[str, int]:
    with path_errors(path):
        return kept_values.parse(read_limited(path, _MOST_BYTES), str(path), say)


def save(control: Control, file: TomlFile) -> None:
    """Save all parameters to a TOML file."""
    link, path, say = control.link, file, control.say
    values = kept_values.get_all(link)
    s = link.listen().signals
    checksum = f"{kept_values.checksum(values):08x}"
    if (there := f"{int(s['params_checksum']):08x}") != checksum:
        raise Refused(
            f"{path}: not written: the checksum of the controller, {there}, does not match its "
            f"parameters, {checksum}; is its version different, or is somebody setting parameters?"
        )
    origin = f"version {s['params_version']:.0f}, checksum {checksum}"
    write_all(path.parent, {path.name: kept_values.text_of(values, origin).encode()})
    say(f"{path}: {len(values)} parameters, {origin}")


def load(
    control: Control,
    file: TomlFile,
    *,
    keep: Annotated[bool, Option("also store them in the controller, for its next start")] = False,
) -> None:
    """Set the parameters of a file, all or none."""
    link, path, say = control.link, file, control.say
    values = _read(path, say)
    try:
        changes = kept_values.set_all(link, values)
    except Refused as refused:
        raise Refused(f"{path}: nothing is changed: {refused}") from refused
    say(*table(changes, ("before", "now")))
    say(f"{path}: {len(changes)} of {len(values)} parameters changed")
    if keep:
        say(kept_values.change_kept(link, "keep"))


def diff(control: Control, file: TomlFile) -> None:
    """Compare a file with the controller; status 1 where they differ."""
    link, path, say = control.link, file, control.say
    values = _read(path, say)
    is_whole = len(values) == len(kept_values.INFOS)
    if is_whole and int(link.listen().signals["params_checksum"]) == kept_values.checksum(values):
        say(f"{path}: equal, checksum {kept_values.checksum(values):08x}")
        return
    there = kept_values.get_all(link)
    pairs = {name: (values[name], there[name]) for name in values if values[name] != there[name]}
    say(*table(pairs, ("file", "controller")))
    if pairs:
        raise Refused(f"{path}: {len(pairs)} of {len(values)} parameters differ")
    say(f"{path}: equal; {len(kept_values.INFOS) - len(values)} parameters are not in the file")


def _memory(action: str, text: str) -> Callable[[Control], None]:
    def carry_out(control: Control) -> None:
        control.say(kept_values.change_kept(control.link, action))

    carry_out.__doc__ = text
    return carry_out


COMMANDS: Commands = {
    "save": save,
    "load": load,
    "diff": diff,
    **{name: _memory(name, text) for name, (_, text) in kept_values.MEMORY.items()},
}
