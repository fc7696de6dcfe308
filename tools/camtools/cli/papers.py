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
from camtools.papers import corner, helix, lobes, removal
from camtools.papers.rows import Chapter, page

PAGE = "papers.md"


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


def chapters() -> list[Chapter]:
    """Return all papers."""
    return [removal.chapter(), corner.chapter(), helix.chapter(), lobes.chapter()]


def _run(arguments: argparse.Namespace) -> int:
    found = chapters()
    files = {name: make() for chapter in found for name, make in chapter.files.items()}
    write_all(arguments.output, files | {PAGE: page(found).encode("utf-8")})
    n = sum(len(chapter.rows) for chapter in found)
    sys.stdout.write(f"{n} figures and tables, {len(files)} files; {PAGE} compares them\n")
    return 0


def main(argv: list[str] | None = None) -> int:
    """Run the command; return its exit status: 0 done, 2 bad input, 128 + n on signal n."""
    return run_command("papers", lambda: _run(_arguments(argv)))


if __name__ == "__main__":
    sys.exit(main())
