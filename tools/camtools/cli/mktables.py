"""Command line of the table generator.

>>> sorted(products(generate(example_part()), with_plots=False))
['example.camtab', 'example.json', 'example_table.c', 'example_table.h']
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from camtools.base.command import Parser, run_command
from camtools.base.errors import CamtoolsError
from camtools.base.output import write_all
from camtools.lobe.generate import GeneratedCam, generate_cam
from camtools.lobe.part import CamPart
from camtools.lobe.summary import emit_cam_text, make_cam_summary
from camtools.part.file import load_any
from camtools.skirt.generate import Generated, check_tolerance, generate
from camtools.skirt.part import Part, example_part
from camtools.skirt.summary import Json, emit_json, make_summary
from camtools.skirt.summary_text import emit_text
from camtools.table.csource import emit_header, emit_source
from camtools.table.image import Table, pack

__all__ = ["example_part", "main", "products"]


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


def _of_table(table: Table, summary: Json) -> dict[str, bytes]:
    """Return the files that every part has, by name."""
    name, image = table.part_name, pack(table)
    return {
        f"{name}.camtab": image,
        f"{name}_table.h": emit_header(name, len(image)).encode("ascii"),
        f"{name}_table.c": emit_source(name, image).encode("ascii"),
        f"{name}.json": emit_json(summary).encode("ascii"),
    }


def products(result: Generated, *, with_plots: bool) -> dict[str, bytes]:
    """Return the content of every file that mktables writes for a piston, by file name."""
    name, files = result.table.part_name, _of_table(result.table, make_summary(result))
    if with_plots:
        from camtools.skirt.plots import (
            draw_all,  # matplotlib takes longer to load than all the rest
        )

        files |= {f"{name}_{topic}.png": png for topic, png in draw_all(result).items()}
    return files


def cam_products(result: GeneratedCam, *, with_plots: bool) -> dict[str, bytes]:
    """Return the content of every file that mktables writes for a cam, by file name."""
    name, files = result.table.part_name, _of_table(result.table, make_cam_summary(result))
    if with_plots:
        from camtools.lobe.plots import draw_cam  # as above

        files |= {f"{name}_{topic}.png": png for topic, png in draw_cam(result).items()}
    return files


def _made(part: Part | CamPart, arguments: argparse.Namespace) -> tuple[dict[str, bytes], str]:
    """Return files and text of a part of either kind."""
    if isinstance(part, CamPart):
        cam = generate_cam(part, arguments.tolerance_nm)
        files = cam_products(cam, with_plots=arguments.plot)
        return files, emit_cam_text(make_cam_summary(cam))
    result = generate(part, arguments.tolerance_nm)
    return products(result, with_plots=arguments.plot), emit_text(make_summary(result))


def _run(arguments: argparse.Namespace) -> int:
    if arguments.tolerance_nm is not None:
        check_tolerance(arguments.tolerance_nm)
    part = load_any(arguments.part)
    try:
        files, text = _made(part, arguments)
    except CamtoolsError as error:
        raise CamtoolsError([f"{arguments.part}: {line}" for line in error.lines]) from error
    write_all(arguments.output, files)
    sys.stdout.write(text)
    return 0


def main(argv: list[str] | None = None) -> int:
    """Run the command; return its exit status: 0 done, 2 bad input, 128 + n on signal n."""
    return run_command("mktables", lambda: _run(_arguments(argv)))


if __name__ == "__main__":
    sys.exit(main())
