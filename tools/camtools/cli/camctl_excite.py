# SPDX-License-Identifier: Apache-2.0
r"""Commands of camctl about the excitation of U and learned values.

>>> wave_of(b"force_mn\n3\n-4\n", "w.csv")
(array([ 3, -4]), 'mN')
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
import numpy.typing as npt

from camtools.base.arguments import Option, Word, whole
from camtools.base.errors import CamtoolsError
from camtools.base.input_file import read_limited
from camtools.base.output import write_all
from camtools.cli.camctl_control import Control
from camtools.cli.camctl_files import DEFAULT_SIGNALS, Signals, count, names_of, write_raw
from camtools.link import excitation
from camtools.link.learned_file import (
    get_learned,
    learned_text,
    learned_values,
    learning_report,
    set_learned,
)

_MOST_BYTES = 16 * 1024 * 1024
_UNITS = {heading: unit for unit, heading in excitation.HEADINGS.items()}


def _read(path: Path) -> bytes:
    try:
        return read_limited(path, _MOST_BYTES)
    except OSError as error:
        raise CamtoolsError([f"{path}: {error.strerror}; check the path"]) from error


def wave_of(data: bytes, name: str) -> tuple[npt.NDArray[np.int64], excitation.Unit]:
    """Return the samples of a wave file, and their unit by its heading.

    Raises
    ------
    CamtoolsError
        It is none; the line says where.
    """
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
            text = f"{name}: line {number}: {line[:40]}: give a whole number of {unit}"
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
    samples, unit = wave_of(_read(wave), str(wave))
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
        for line in learning_report(link.listen()):
            control.say(line)
    elif action == "save":
        text = learned_text(get_learned(link), link.listen().table_name)
        write_all(file.parent, {file.name: text.encode()})
        control.say(f"{file}: saved")
    else:
        set_learned(link, learned_values(_read(file), str(file)))
        control.say(f"{file}: in force")
