"""Command line of the table generator.

>>> main(["part.toml", "-o", "out", "--tolerance-nm", "0"])
2
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from camtools.base.command import Parser, run_command
from camtools.base.errors import CamtoolsError
from camtools.base.output import write_all
from camtools.pipeline.correct_options import add_measured, correction_for
from camtools.pipeline.load import load
from camtools.pipeline.make_table import make
from camtools.pipeline.registry import schemas
from camtools.table.export import FORMS, Export, export_files
from camtools.table.header import check_tolerance
from camtools.table.image import Table

MIN_POINTS, MAX_POINTS = 4, 100_000


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = Parser(prog="mktables", description="Make the cam table of a part.")
    parser.add_argument("part", type=Path, nargs="?", metavar="PART.toml", help="part file")
    parser.add_argument(
        "-o", "--output", type=Path, required=True, metavar="DIR", help="folder for the results"
    )
    parser.add_argument(
        "--tolerance-nm",
        type=float,
        metavar="T",
        help="largest error of u and x in nm (default: 1; u of a refitted section 5, of a cam 10, "
        "of a polygon 1, 3 or 10)",
    )
    parser.add_argument(
        "--schema",
        action="store_true",
        help="write the JSON schemas of part and machine files into DIR, for editors, and no table",
    )
    add_measured(parser)
    parser.add_argument("--plot", action="store_true", help="also draw PNG plots")
    parser.add_argument(
        "--export",
        choices=FORMS,
        help="also write the table as text: points with velocity and acceleration, or values only",
    )
    parser.add_argument(
        "--export-height",
        type=float,
        action="append",
        default=[],
        metavar="MM",
        help="height to export in mm, into its own file; repeatable (default: all, in one file)",
    )
    parser.add_argument(
        "--export-points",
        type=int,
        metavar="N",
        help=f"points per turn, {MIN_POINTS} .. {MAX_POINTS} (default: the knots for xyva, 360 for "
        "text)",
    )
    arguments = parser.parse_args(argv)
    if arguments.part is None and not arguments.schema:
        parser.error("the following arguments are required: PART.toml")
    return arguments


def _exported(arguments: argparse.Namespace, table: Table) -> dict[str, bytes]:
    """Return the files of --export.

    Raises
    ------
    CamtoolsError
        Options without a format, or out of range.
    """
    heights_mm, n_points = tuple(arguments.export_height), arguments.export_points
    if arguments.export is None:
        if heights_mm or n_points is not None:
            option = "--export-height" if heights_mm else "--export-points"
            problem = f"{option}: has no effect without --export"
            raise CamtoolsError([f"{problem}; add --export {' or --export '.join(FORMS)}"])
        return {}
    if n_points is not None and not MIN_POINTS <= n_points <= MAX_POINTS:
        problem = f"--export-points {n_points}: must be {MIN_POINTS} .. {MAX_POINTS}"
        raise CamtoolsError([f"{problem}; give points per turn"])
    return export_files(table, Export(arguments.export, heights_mm, n_points))


def _run(arguments: argparse.Namespace) -> int:
    if arguments.schema:
        write_all(arguments.output, {name: text.encode() for name, text in schemas().items()})
        return 0
    if arguments.tolerance_nm is not None:
        check_tolerance(arguments.tolerance_nm)
    loaded = load(arguments.part)
    correction = correction_for(arguments, loaded, arguments.output)
    made = make(loaded, arguments.part, tolerance_nm=arguments.tolerance_nm, correction=correction)
    exported = _exported(arguments, made.table.table)
    files = made.files(with_plots=arguments.plot) | exported
    write_all(arguments.output, files)
    sys.stdout.write(made.text())
    return 0


def main(argv: list[str] | None = None) -> int:
    """Run the command; return its exit status: 0 done, 2 bad input, 128 + n on signal n."""
    return run_command("mktables", lambda: _run(_arguments(argv)))


if __name__ == "__main__":
    sys.exit(main())
