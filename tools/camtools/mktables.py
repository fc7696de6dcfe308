"""Command line of the table generator.

>>> sorted(products(generate(example_part()), with_plots=False))
['example.camtab', 'example.json', 'example_table.c', 'example_table.h']
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from camtools.command import Parser, run_command
from camtools.csource import emit_header, emit_source
from camtools.errors import CamtoolsError
from camtools.generate import Generated, check_tolerance, generate
from camtools.image import pack
from camtools.output import write_all
from camtools.part import example_part, load_part
from camtools.summary import emit_json, make_summary
from camtools.summary_text import emit_text

__all__ = ["example_part", "main", "products"]


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = Parser(prog="mktables", description="Make the cam table of a part.")
    parser.add_argument("part", type=Path, metavar="PART.toml", help="part file")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="DIR", help="folder")
    parser.add_argument(
        "--tolerance-nm",
        type=float,
        metavar="T",
        help="largest error of u and x, default 1 (u of a refitted section 5)",
    )
    parser.add_argument("--plot", action="store_true", help="draw PNG plots too")
    return parser.parse_args(argv)


def products(result: Generated, *, with_plots: bool) -> dict[str, bytes]:
    """Return the content of every file that mktables writes, by file name."""
    name, image = result.table.part_name, pack(result.table)
    files = {
        f"{name}.camtab": image,
        f"{name}_table.h": emit_header(name, len(image)).encode("ascii"),
        f"{name}_table.c": emit_source(name, image).encode("ascii"),
        f"{name}.json": emit_json(make_summary(result)).encode("ascii"),
    }
    if with_plots:
        from camtools.plots import draw_all  # matplotlib takes longer to load than all the rest

        files |= {f"{name}_{topic}.png": png for topic, png in draw_all(result).items()}
    return files


def _run(arguments: argparse.Namespace) -> int:
    if arguments.tolerance_nm is not None:
        check_tolerance(arguments.tolerance_nm)
    part = load_part(arguments.part)
    try:
        result = generate(part, arguments.tolerance_nm)
    except CamtoolsError as error:
        raise CamtoolsError([f"{arguments.part}: {line}" for line in error.lines]) from error
    write_all(arguments.output, products(result, with_plots=arguments.plot))
    sys.stdout.write(emit_text(make_summary(result)))
    return 0


def main(argv: list[str] | None = None) -> int:
    """Run the command; return its exit status: 0 done, 2 bad input, 128 + n on signal n."""
    return run_command("mktables", lambda: _run(_arguments(argv)))


if __name__ == "__main__":
    sys.exit(main())
