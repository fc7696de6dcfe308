"""Command line that makes every figure and table of the papers anew.

>>> _arguments(["-o", "made"]).output.name
'made'
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from camtools.base.command import Parser, run_command
from camtools.base.output import write_all
from camtools.papers import corner, helix, lobe, removal
from camtools.papers.comparison import filled, page

PAGE = "papers.md"
MODULES = (removal, corner, helix, lobe)


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = Parser(
        prog="tools/papers",
        description="Reproduce every figure and table of the papers, and write a page that "
        "compares them with the printed values.",
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("-o", "--output", type=Path, required=True, metavar="DIR", help="folder for the results")
    return parser.parse_args(argv)


def _run(arguments: argparse.Namespace) -> int:
    papers = [filled(one.KEY, one.quantities()) for one in MODULES]
    files = {name: make() for one in MODULES for name, make in one.files().items()}
    write_all(arguments.output, files | {PAGE: page(papers).encode("utf-8")})
    n = sum(len(paper.rows) for paper in papers)
    sys.stdout.write(f"{n} figures and tables, {len(files)} files; {PAGE} compares them\n")
    return 0


def main(argv: list[str] | None = None) -> int:
    """Run the command; return its exit status: 0 done, 2 bad input, 128 + n on signal n."""
    return run_command("papers", lambda: _run(_arguments(argv)))


if __name__ == "__main__":
    sys.exit(main())
