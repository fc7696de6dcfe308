"""Command line that writes NC programs for existing machines.

>>> from camtools.skirt.part import example_part
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
from camtools.ngc.full import full_program
from camtools.ngc.profile import profile_program
from camtools.ngc.words import ProgramJob
from camtools.part.common import check_feed
from camtools.part.model import MIN_STEP_MM
from camtools.pipeline.load import load_for
from camtools.skirt.geometry import make_geometry
from camtools.skirt.part import SkirtPart
from camtools.skirt.run_in import with_run

MIN_CHORD_UM, MAX_CHORD_UM = 0.002, 1000.0
DEFAULT_CHORD_UM = 0.1
_UM_PER_MM = 1000.0


class ProgramWishes(NamedTuple):
    """Options of the command."""

    axes: str  # "xz" or "cxzu"
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
        choices=("xz", "cxzu"),
        default="xz",
        help="xz: camturn carries U (default); cxzu: all axes point by point",
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


def make_job(part: SkirtPart, wishes: ProgramWishes) -> ProgramJob:
    """Return what a program is made of.

    Raises
    ------
    CamtoolsError
        Heights beyond the part or not rising, a feed beyond its height, a chord error out of range,
        an impossible part.
    """
    check_feed(part)
    geometry = with_run(make_geometry(part), part.process.run_in_mm, part.process.run_out_mm)
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
    if not MIN_CHORD_UM <= wishes.chord_um <= MAX_CHORD_UM:
        problem = f"--chord-um {wishes.chord_um:g}: must be {MIN_CHORD_UM:g} .. {MAX_CHORD_UM:g}"
        raise CamtoolsError([f"{problem}; give micrometres"])
    return ProgramJob(part, geometry, first, last, wishes.chord_um / _UM_PER_MM, wishes.is_diameter)


def program(job: ProgramJob, axes: str) -> Iterator[bytes]:
    """Return the program in pieces; see `profile_program` and `full_program`."""
    return profile_program(job) if axes == "xz" else full_program(job)


def _run(arguments: argparse.Namespace) -> int:
    output: Path = arguments.output
    if not output.name or output.is_dir():
        problem, remedy = "is a folder", "give the name of a file, say part.ngc"
        raise InputError(str(output), "", None, problem, remedy)
    part = load_for("mkgcode", SkirtPart, arguments.part)
    wishes = ProgramWishes(
        arguments.axes,
        arguments.from_mm,
        arguments.to_mm,
        arguments.chord_um,
        arguments.diameter,
    )
    try:
        pieces = program(make_job(part, wishes), wishes.axes)
    except CamtoolsError as error:
        raise CamtoolsError([f"{arguments.part}: {line}" for line in error.lines]) from error
    write_all(output.parent, {output.name: pieces})
    return 0


def main(argv: list[str] | None = None) -> int:
    """Run the command; return its exit status: 0 done, 2 bad input, 128 + n on signal n."""
    return run_command("mkgcode", lambda: _run(_arguments(argv)))


if __name__ == "__main__":
    sys.exit(main())
