"""Command line of the comparison of paths on the simulated surface.

>>> main(["no.toml", "-o", "out"])
2
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

from camtools.base.arguments import Folder, Option, Word, command
from camtools.base.errors import CamtoolsError
from camtools.base.files import write_all
from camtools.papers.path_drawings import draw_scallop
from camtools.papers.paths import cut_paths, cuts_csv, cuts_text
from camtools.pipeline.load import load_for
from camtools.plots.style import pictures
from camtools.skirt.part.part_file import SkirtPart

_NOSE_MM = (0.01, 100.0)
_RPM = (1.0, 60_000.0)


def _check(option: str, value: float, limits: tuple[float, float]) -> None:
    low, high = limits
    if not low <= value <= high:
        raise CamtoolsError([f"{option} {value}: out of range; give {low:g} .. {high:g}"])


def scallop(
    part: Annotated[Path, Word("part file; its process.path is ignored", "PART.toml")],
    output: Folder,
    *,
    nose_mm: Annotated[
        float, Option("nose radius of the tool in mm, 0.01 .. 100 (default: 0.8)", "R")
    ] = 0.8,
    rpm: Annotated[
        float | None, Option("spindle speed in r/min, 1 .. 60000 (default: the part's)", "N")
    ] = None,
) -> int:
    """Cut a part on the simulator along a ring-helix and along helices with a round-nosed tool.

    Compares surface and time with theory.
    """
    skirt = load_for("scallop", SkirtPart, part)
    speed_rpm = skirt.process.spindle_rpm if rpm is None else rpm
    _check("--rpm", speed_rpm, _RPM)
    _check("--nose-mm", nose_mm, _NOSE_MM)
    process = skirt.process.model_copy(update={"spindle_rpm": speed_rpm})
    skirt = skirt.model_copy(update={"process": process})
    try:
        study, cuts = cut_paths(skirt, nose_mm)
    except CamtoolsError as error:
        raise CamtoolsError([f"{part}: {line}" for line in error.lines]) from error
    drawn = pictures({"scallop.png": lambda: draw_scallop(skirt.part.name, study, cuts)})
    write_all(output, {"scallop.csv": cuts_csv(cuts).encode("utf-8")} | drawn)
    sys.stdout.write(cuts_text(cuts))
    return 0


main = command("tools/scallop", scallop)

if __name__ == "__main__":
    sys.exit(main())
