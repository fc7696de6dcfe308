"""Command line that writes NC programs for existing machines.

>>> from camtools.skirt.part.part_file import example_part
>>> _skirt_job(example_part(), ProgramWishes(to_mm=30.0)).z_last_mm
30.0
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from camtools.base.arguments import Option, PartFile, command
from camtools.base.errors import CamtoolsError, InputError
from camtools.base.files import write_all
from camtools.base.quantities import UM_PER_MM
from camtools.lobe.part import LobePart
from camtools.ngc.full_program import full_program
from camtools.ngc.gcode_words import ProgramJob
from camtools.ngc.lobe_program import LobeJob, lobe_program
from camtools.ngc.profile_program import profile_program
from camtools.part.common import check_feed
from camtools.part.model import MIN_STEP_MM
from camtools.pipeline.load import load_able
from camtools.skirt.geometry.run_in import with_run
from camtools.skirt.geometry.skirt_geometry import make_geometry
from camtools.skirt.part.part_file import SkirtPart
from camtools.skirt.tool.nose import tip_geometry
from camtools.skirt.tool.turning import check_heel

MIN_CHORD_UM, MAX_CHORD_UM = 0.002, 1000.0
DEFAULT_CHORD_UM = 0.1


@dataclass(frozen=True)
class ProgramWishes:
    """How a part is programmed; a height that is None is the part's."""

    axes: Annotated[
        str | None,
        Option(
            "axes in the program: xz, with U left to camturn (default for pistons); cxzu, all axes "
            "point by point; cxz, X follows the lift over C, with B for a swinging tool (cams)",
            choices=("xz", "cxzu", "cxz"),
        ),
    ] = None
    from_mm: Annotated[float | None, Option("lowest height in mm (default: the part's)", "MM")] = (
        None
    )
    to_mm: Annotated[float | None, Option("highest height in mm (default: the part's)", "MM")] = (
        None
    )
    chord_um: Annotated[
        float,
        Option(
            f"largest chord error of the segments (xz) and tolerance of G64, in um, "
            f"{MIN_CHORD_UM:g} .. {MAX_CHORD_UM:g} (default: {DEFAULT_CHORD_UM})",
            "E",
        ),
    ] = DEFAULT_CHORD_UM
    diameter: Annotated[bool, Option("program X as diameter, G7 (default: radius, G8)")] = False


def _check_chord(chord_um: float) -> None:
    if not MIN_CHORD_UM <= chord_um <= MAX_CHORD_UM:
        problem = f"--chord-um {chord_um:g}: must be {MIN_CHORD_UM:g} .. {MAX_CHORD_UM:g}"
        raise CamtoolsError([f"{problem}; give micrometres"])


def _lobe_job(part: LobePart, wishes: ProgramWishes) -> LobeJob:
    for option, value in (("--from-mm", wishes.from_mm), ("--to-mm", wishes.to_mm)):
        if value is not None:
            problem = f"{option} {value:g}: has no meaning for a cam, whose lobes are cut whole"
            raise CamtoolsError([f"{problem}; leave it out"])
    _check_chord(wishes.chord_um)
    return LobeJob(part, wishes.chord_um / UM_PER_MM, wishes.diameter)


def _skirt_job(part: SkirtPart, wishes: ProgramWishes) -> ProgramJob:
    process = part.process
    played = {"process.pass": process.passes, "process.feed_law": process.feed_law}
    for key, given in (played | {"piston.land": part.piston.lands}).items():
        if given:
            problem = "is played by the controller alone: a program is one pass with one feed"
            remedy = "leave it out" if key == "piston.land" else "give depth_mm and feed_mm of it"
            raise CamtoolsError([f"{key}: {problem}; {remedy}"])
    check_feed(part)
    drawing = make_geometry(part)
    check_heel(drawing, part.tool, part.process.direction)
    geometry = with_run(drawing, *process.runs_mm)
    low, high = geometry.ends_mm
    first = low if wishes.from_mm is None else wishes.from_mm
    last = high if wishes.to_mm is None else wishes.to_mm
    for option, value in (("--from-mm", first), ("--to-mm", last)):
        if not low <= value <= high:
            problem = f"{option} {value:g}: must be a height of the part"
            raise CamtoolsError([f"{problem}; give {low:g} .. {high:g} mm"])
    if last - first < MIN_STEP_MM:
        problem = f"--to-mm {last:g}: must be at least {MIN_STEP_MM} mm above --from-mm {first:g}"
        raise CamtoolsError([f"{problem}; programs go upwards, give the lower height first"])
    _check_chord(wishes.chord_um)
    tip = tip_geometry(geometry, part.tool)
    return ProgramJob(part, tip, first, last, wishes.chord_um / UM_PER_MM, wishes.diameter)


def mkgcode(
    part: PartFile,
    output: Annotated[Path, Option("program to write, for example part.ngc", "FILE", "-o")],
    wishes: ProgramWishes,
) -> int:
    """Write an NC program for LinuxCNC that turns a part."""
    if not output.name or output.is_dir():
        problem, remedy = "is a folder", "give the name of a file, say part.ngc"
        raise InputError(str(output), "", None, problem, remedy)
    loaded = load_able("mkgcode", part)
    able = ("cxz",) if isinstance(loaded, LobePart) else ("xz", "cxzu")
    axes = wishes.axes or able[0]
    if axes not in able:
        problem = f"--axes {axes}: not for a {loaded.part.kind}; give {' or '.join(able)}"
        raise CamtoolsError([f"{part}: {problem}"])
    try:
        if isinstance(loaded, LobePart):
            pieces = lobe_program(_lobe_job(loaded, wishes))
        else:
            assert isinstance(loaded, SkirtPart)
            job = _skirt_job(loaded, wishes)
            pieces = profile_program(job) if axes == "xz" else full_program(job)
    except CamtoolsError as error:
        raise CamtoolsError([f"{part}: {line}" for line in error.lines]) from error
    write_all(output.parent, {output.name: pieces})
    return 0


main = command("mkgcode", mkgcode)

if __name__ == "__main__":
    sys.exit(main())
