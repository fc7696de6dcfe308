"""Options of the commands that correct a table by a gauged part, and what they ask for.

>>> Correcting().measured is None
True
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated

from camtools.base.arguments import Option, option_of
from camtools.base.errors import CamtoolsError
from camtools.cut.correction import Correction
from camtools.measured.correction_round import DEFAULT_GAIN, Request, next_round
from camtools.measured.text import cautions
from camtools.pipeline.load import Loaded


@dataclass(frozen=True)
class Correcting:
    """How the surface of a gauged part corrects the next table.

    Raises
    ------
    CamtoolsError
        An option that says how to correct, without the surface.
    """

    measured: Annotated[
        Path | None,
        Option(
            "correct the table by the measured surface of a part, from camsim or as angle, height "
            "and deviation (tools/docs/MEASURED.md)",
            "SURFACE.csv",
        ),
    ] = None
    previous: Annotated[
        Path | None,
        Option(
            "summary of the table that cut that part (default: next to the surface)", "NAME.json"
        ),
    ] = None
    gain: Annotated[
        float | None, Option(f"share of the deviation to correct (default: {DEFAULT_GAIN})", "G")
    ] = None
    keep_harmonics: Annotated[
        int | None, Option("highest harmonic to correct, in waves per turn (default: 16)", "N")
    ] = None
    centred: Annotated[
        bool, Option("do not correct mean and centre, which the instrument has removed")
    ] = False

    def __post_init__(self) -> None:
        for one in fields(self) if self.measured is None else ():
            if getattr(self, one.name) not in (None, False):
                problem = f"{option_of(one.name)}: has no effect without --measured"
                raise CamtoolsError([f"{problem}; add --measured SURFACE.csv"])

    def correction(self, loaded: Loaded, output: Path | None) -> Correction | None:
        """Return the correction that is asked for, nothing without --measured.

        Cautions go to standard error.

        Parameters
        ----------
        output : Path or None
            Folder of the new table; None: not known to be that of the old one.

        Raises
        ------
        CamtoolsError
            See `next_round`; or the new table would take the place of the one that cut the part,
            of which the next round must know.
        """
        if self.measured is None:
            return None
        kind, part = loaded
        name = part.part.name
        gain = DEFAULT_GAIN if self.gain is None else self.gain
        request = Request(self.measured, self.previous, gain, self.keep_harmonics, self.centred)
        found = next_round(request, name, kind.drawing(part))
        path = found.previous.path
        if output is not None and (output / f"{name}.json").resolve() == path.resolve():
            problem = f"has the {name}.json of the table that cut the measured part"
            raise CamtoolsError([f"-o {output}: {problem}; give another folder for each round"])
        for line in cautions(part.process, getattr(part, "tool", None), found.previous.report):
            sys.stderr.write(f"{line.strip()}\n")
        return found.correction
