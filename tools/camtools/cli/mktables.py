"""Command line of the table generator.

>>> main(["part.toml", "-o", "out", "--tolerance-nm", "0"])
2
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from camtools.base.command import Parser, run_command
from camtools.base.output import write_all
from camtools.pipeline.load import load
from camtools.pipeline.make import make
from camtools.table.header import check_tolerance


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = Parser(prog="mktables", description="Make the cam table of a part.")
    parser.add_argument("part", type=Path, metavar="PART.toml", help="part file")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="DIR", help="folder")
    parser.add_argument(
        "--tolerance-nm",
        type=float,
        metavar="T",
        help="largest error of u and x, default 1 (u of a refitted section 5, of a cam 10)",
    )
    parser.add_argument("--plot", action="store_true", help="draw PNG plots too")
    return parser.parse_args(argv)


def _run(arguments: argparse.Namespace) -> int:
    if arguments.tolerance_nm is not None:
        check_tolerance(arguments.tolerance_nm)
    made = make(load(arguments.part), arguments.part, tolerance_nm=arguments.tolerance_nm)
    write_all(arguments.output, made.files(with_plots=arguments.plot))
    sys.stdout.write(made.text())
    return 0


def main(argv: list[str] | None = None) -> int:
    """Run the command; return its exit status: 0 done, 2 bad input, 128 + n on signal n."""
    return run_command("mktables", lambda: _run(_arguments(argv)))


if __name__ == "__main__":
    sys.exit(main())
