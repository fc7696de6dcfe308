"""Command line of the comparison of paths on the simulated surface.

>>> _arguments(["part.toml", "-o", "out"]).nose_mm
0.8
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from camtools.base.command import Parser, run_command
from camtools.base.errors import CamtoolsError
from camtools.base.output import write_all
from camtools.papers.paths import cut_paths, cuts_csv, cuts_text, draw_scallop
from camtools.pipeline.load import load_for
from camtools.plots.panels import pictures
from camtools.skirt.part.part_file import SkirtPart

_NOSE_MM = (0.01, 100.0)
_RPM = (1.0, 60_000.0)


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = Parser(
        prog="tools/scallop",
        description="Cut a part on the simulator along a ring-helix and along helices with a "
        "round-nosed tool; compare surface and time with theory.",
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("part", type=Path, metavar="PART.toml", help="part file; its process.path is ignored")
    add("-o", "--output", type=Path, required=True, metavar="DIR", help="folder for the results")
    add(
        "--nose-mm",
        type=float,
        default=0.8,
        metavar="R",
        help="nose radius of the tool in mm, 0.01 .. 100 (default: 0.8)",
    )
    add(
        "--rpm",
        type=float,
        metavar="N",
        help="spindle speed in r/min, 1 .. 60000 (default: the part's)",
    )
    return parser.parse_args(argv)


def _check(option: str, value: float, limits: tuple[float, float]) -> None:
    low, high = limits
    if not low <= value <= high:
        raise CamtoolsError([f"{option} {value}: out of range; give {low:g} .. {high:g}"])


def _part(arguments: argparse.Namespace) -> SkirtPart:
    """Return the part at the speed asked for."""
    part = load_for("scallop", SkirtPart, arguments.part)
    rpm = part.process.spindle_rpm if arguments.rpm is None else arguments.rpm
    _check("--rpm", rpm, _RPM)
    _check("--nose-mm", arguments.nose_mm, _NOSE_MM)
    process = part.process.model_copy(update={"spindle_rpm": rpm})
    return part.model_copy(update={"process": process})


def _run(arguments: argparse.Namespace) -> int:
    part = _part(arguments)
    try:
        study, cuts = cut_paths(part, arguments.nose_mm)
    except CamtoolsError as error:
        raise CamtoolsError([f"{arguments.part}: {line}" for line in error.lines]) from error
    drawn = pictures({"scallop.png": lambda: draw_scallop(part.part.name, study, cuts)})
    files = {"scallop.csv": cuts_csv(cuts).encode("utf-8")} | drawn
    write_all(arguments.output, files)
    sys.stdout.write(cuts_text(cuts))
    return 0


def main(argv: list[str] | None = None) -> int:
    """Run the command; return its exit status: 0 done, 2 bad input, 128 + n on signal n."""
    return run_command("scallop", lambda: _run(_arguments(argv)))


if __name__ == "__main__":
    sys.exit(main())
