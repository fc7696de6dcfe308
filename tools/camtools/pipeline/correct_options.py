"""Options of the commands that correct a table by a gauged part, and what they ask for.

>>> parser = argparse.ArgumentParser()
>>> add_measured(parser)
>>> parser.parse_args(["--measured", "surface.csv"]).gain is None
True
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from camtools.base.errors import CamtoolsError
from camtools.cut.correction import Correction
from camtools.measured.correction_round import DEFAULT_GAIN, Request, next_round
from camtools.measured.text import cautions
from camtools.pipeline.load import Loaded

_NEEDS = {
    "previous": "--previous",
    "gain": "--gain",
    "keep_harmonics": "--keep-harmonics",
    "centred": "--centred",
}


def add_measured(parser: argparse.ArgumentParser) -> None:
    """Add the options to a command."""
    parser.add_argument(
        "--measured",
        type=Path,
        metavar="SURFACE.csv",
        help="correct the table by the measured surface of a part, from camsim or as angle, height "
        "and deviation (tools/docs/MEASURED.md)",
    )
    parser.add_argument(
        "--previous",
        type=Path,
        metavar="NAME.json",
        help="summary of the table that cut that part (default: next to the surface)",
    )
    parser.add_argument(
        "--gain",
        type=float,
        metavar="G",
        help=f"share of the deviation to correct (default: {DEFAULT_GAIN})",
    )
    parser.add_argument(
        "--keep-harmonics",
        type=int,
        metavar="N",
        help="highest harmonic to correct, in waves per turn (default: 16)",
    )
    parser.add_argument(
        "--centred",
        action="store_true",
        help="do not correct mean and centre, which the instrument has removed",
    )


def request_of(arguments: argparse.Namespace) -> Request | None:
    """Return what the options ask for, nothing without --measured.

    Raises
    ------
    CamtoolsError
        An option that says how to correct, without the surface.
    """
    if arguments.measured is None:
        for key, option in _NEEDS.items():
            if getattr(arguments, key) not in (None, False):
                raise CamtoolsError(
                    [f"{option}: has no effect without --measured; add --measured SURFACE.csv"]
                )
        return None
    gain = DEFAULT_GAIN if arguments.gain is None else arguments.gain
    return Request(
        arguments.measured, arguments.previous, gain, arguments.keep_harmonics, arguments.centred
    )


def correction_for(
    arguments: argparse.Namespace, loaded: Loaded, output: Path | None
) -> Correction | None:
    """Return the correction that the options ask for, nothing without --measured.

    Cautions go to standard error.

    Parameters
    ----------
    output : Path or None
        Folder of the new table; None: not known to be that of the old one.

    Raises
    ------
    CamtoolsError
        See `next_round`; or the new table would take the place of the one that cut the part, of
        which the next round must know.
    """
    request = request_of(arguments)
    if request is None:
        return None
    kind, part = loaded
    name = part.part.name
    found = next_round(request, name, kind.drawing(part))
    path = found.previous.path
    if output is not None and (output / f"{name}.json").resolve() == path.resolve():
        problem = f"has the {name}.json of the table that cut the measured part"
        raise CamtoolsError([f"-o {output}: {problem}; give another folder for each round"])
    for line in cautions(part.process, getattr(part, "tool", None), found.previous.report):
        sys.stderr.write(f"{line.strip()}\n")
    return found.correction
