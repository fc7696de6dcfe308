"""Command line that writes NC programs for existing machines.

>>> from camtools.skirt.part.part_file import example_part
>>> job = make_job(example_part(), ProgramWishes("xz", None, None, 0.1, False))
>>> b"".join(program(job, "xz")).splitlines()[-1]
b'M2'
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from math import isfinite
from pathlib import Path
from typing import NamedTuple

from camtools.base.command import Parser, run_command
from camtools.base.errors import CamtoolsError, InputError
from camtools.base.output import write_all
from camtools.lobe.part import LobePart
from camtools.ngc.full_program import full_program
from camtools.ngc.gcode_words import ProgramJob
from camtools.ngc.lobe_program import LobeJob, lobe_program
from camtools.ngc.profile_program import profile_program
from camtools.part.common import PartFile, check_feed
from camtools.part.model import MIN_STEP_MM
from camtools.pipeline.load import load_able
from camtools.skirt.geometry.run_in import with_run
from camtools.skirt.geometry.skirt_geometry import make_geometry
from camtools.skirt.part.part_file import SkirtPart
from camtools.skirt.tool.heel import check_heel
from camtools.skirt.tool.nose import tip_geometry

MIN_CHORD_UM, MAX_CHORD_UM = 0.002, 1000.0
DEFAULT_CHORD_UM = 0.1
_UM_PER_MM = 1000.0


class ProgramWishes(NamedTuple):
    """Options of the command."""

    axes: str  # "xz", "cxzu" or "cxz"
    first_mm: float | None  # None: of the part
    last_mm: float | None
    chord_um: float
    is_diameter: bool


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = Parser(
        prog="mkgcode",
        description="Write an NC program (LinuxCNC) that turns a part.",
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("part", type=Path, metavar="PART.toml", help="part file")
    add("-o", "--output", type=Path, required=True, metavar="FILE", help="program, say part.ngc")
    add(
        "--axes",
        choices=("xz", "cxzu", "cxz"),
        help="xz: camturn carries U (default of pistons); cxzu: all axes point by point; cxz: X "
        "follows the lift over C (cams), with B for a tool that swings",
    )
    add("--from-mm", type=float, metavar="MM", help="height where it begins, default the part's")
    add("--to-mm", type=float, metavar="MM", help="height where it ends, default the part's")
    add(
        "--chord-um",
        type=float,
        default=DEFAULT_CHORD_UM,
        metavar="E",
        help=f"largest distance of segments from the profile (xz), tolerance of G64 (both), "
        f"default {DEFAULT_CHORD_UM}",
    )
    add("--diameter", action="store_true", help="X is a diameter (G7), not a radius (G8)")
    return parser.parse_args(argv)


def _check_chord(chord_um: float) -> None:
    if not MIN_CHORD_UM <= chord_um <= MAX_CHORD_UM:
        problem = f"--chord-um {chord_um:g}: must be {MIN_CHORD_UM:g} .. {MAX_CHORD_UM:g}"
        raise CamtoolsError([f"{problem}; give micrometres"])


def make_lobe_job(part: LobePart, wishes: ProgramWishes) -> LobeJob:
    """Return what a program of a cam is made of.

    Raises
    ------
    CamtoolsError
        A chord error out of range, or heights, which a cam does not take.
    """
    for option, value in (("--from-mm", wishes.first_mm), ("--to-mm", wishes.last_mm)):
        if value is not None:
            problem = f"{option} {value:g}: has no meaning for a cam, whose lobes are cut whole"
            raise CamtoolsError([f"{problem}; leave it out"])
    _check_chord(wishes.chord_um)
    return LobeJob(part, wishes.chord_um / _UM_PER_MM, wishes.is_diameter)


def _refuse_passes(part: SkirtPart) -> None:
    """Refuse what a program of one pass with one feed cannot do."""
    for key, given in (("pass", part.process.passes), ("feed_law", part.process.feed_law)):
        if given:
            problem = "is played by the controller alone: a program is one pass with one feed"
            raise CamtoolsError([f"process.{key}: {problem}; give depth_mm and feed_mm of it"])


def make_job(part: SkirtPart, wishes: ProgramWishes) -> ProgramJob:
    """Return what a program is made of.

    Raises
    ------
    CamtoolsError
        Heights beyond the part or not rising, a feed beyond its height, a chord error out of range,
        an impossible part.
    """
    _refuse_passes(part)
    check_feed(part)
    drawing = make_geometry(part)
    check_heel(drawing, part.tool, part.process.direction)
    geometry = with_run(drawing, part.process.run_in_mm, part.process.run_out_mm)
    low, high = geometry.z_first_mm, geometry.z_last_mm
    first = low if wishes.first_mm is None else wishes.first_mm
    last = high if wishes.last_mm is None else wishes.last_mm
    for option, value in (("--from-mm", first), ("--to-mm", last)):
        if not (isfinite(value) and low <= value <= high):
            problem = f"{option} {value:g}: must be a height of the part"
            raise CamtoolsError([f"{problem}; give {low:g} .. {high:g} mm"])
    if last - first < MIN_STEP_MM:
        problem = f"--to-mm {last:g}: must be at least {MIN_STEP_MM} mm above --from-mm {first:g}"
        raise CamtoolsError([f"{problem}; programs go upwards, give the lower height first"])
    _check_chord(wishes.chord_um)
    tip = tip_geometry(geometry, part.tool)
    return ProgramJob(part, tip, first, last, wishes.chord_um / _UM_PER_MM, wishes.is_diameter)


def program(job: ProgramJob, axes: str) -> Iterator[bytes]:
    """Return the program in pieces; see `profile_program` and `full_program`."""
    return profile_program(job) if axes == "xz" else full_program(job)


def _program(part: PartFile, wishes: ProgramWishes) -> Iterator[bytes]:
    if isinstance(part, LobePart):
        return lobe_program(make_lobe_job(part, wishes))
    assert isinstance(part, SkirtPart)
    return program(make_job(part, wishes), wishes.axes)


def _run(arguments: argparse.Namespace) -> int:
    output: Path = arguments.output
    if not output.name or output.is_dir():
        problem, remedy = "is a folder", "give the name of a file, say part.ngc"
        raise InputError(str(output), "", None, problem, remedy)
    part = load_able("mkgcode", arguments.part)
    able = ("cxz",) if isinstance(part, LobePart) else ("xz", "cxzu")
    axes = arguments.axes or able[0]
    if axes not in able:
        problem = f"--axes {axes}: not for a {part.part.kind}; give {' or '.join(able)}"
        raise CamtoolsError([f"{arguments.part}: {problem}"])
    wishes = ProgramWishes(
        axes, arguments.from_mm, arguments.to_mm, arguments.chord_um, arguments.diameter
    )
    try:
        pieces = _program(part, wishes)
    except CamtoolsError as error:
        raise CamtoolsError([f"{arguments.part}: {line}" for line in error.lines]) from error
    write_all(output.parent, {output.name: pieces})
    return 0


def main(argv: list[str] | None = None) -> int:
    """Run the command; return its exit status: 0 done, 2 bad input, 128 + n on signal n."""
    return run_command("mkgcode", lambda: _run(_arguments(argv)))


if __name__ == "__main__":
    sys.exit(main())
