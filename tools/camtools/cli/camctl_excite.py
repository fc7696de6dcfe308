# SPDX-License-Identifier: Apache-2.0
r"""Subcommands of camctl about the excitation of U and learned values.

>>> wave_of(b"force_mn\n3\n-4\n", "w.csv")
(array([ 3, -4]), 'mN')
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import numpy.typing as npt

from camtools.base.errors import CamtoolsError
from camtools.base.input_file import read_limited
from camtools.base.output import write_all
from camtools.cli.camctl_files import Say, names_of, write_raw
from camtools.link import excitation
from camtools.link.controller import Link
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


def excite(link: Link, arguments: argparse.Namespace, say: Say) -> None:
    """Let U play the wave of a file, and write what was recorded until its amplitude falls."""
    samples, unit = wave_of(_read(arguments.wave), str(arguments.wave))
    recording = excitation.excite(
        link,
        samples,
        arguments.periods,
        unit=unit,
        fade_ticks=arguments.fade_ticks,
        place_nm=arguments.place_nm,
        signals=names_of(arguments.signals),
    )
    write_raw(arguments.file, recording.played(), say)


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
