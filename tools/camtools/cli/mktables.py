"""Command line of the table generator.

>>> main(["part.toml", "-o", "out", "--tolerance-nm", "0"])
2
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

from camtools.base.arguments import Folder, Option, UsageError, Word, command
from camtools.base.errors import CamtoolsError
from camtools.base.files import write_all
from camtools.pipeline.job import Correcting
from camtools.pipeline.load import load, make, schemas
from camtools.table.export import FORMS, Export, export_files
from camtools.table.header import check_tolerance
from camtools.table.image import Table

MIN_POINTS, MAX_POINTS = 4, 100_000


def mktables(
    output: Folder,
    correcting: Correcting,
    part: Annotated[Path | None, Word("part file", "PART.toml")] = None,
    *,
    schema: Annotated[
        bool,
        Option(
            "write the JSON schemas of part and machine files into DIR, for editors, and no table"
        ),
    ] = False,
    propose_feed: Annotated[
        bool,
        Option(
            "print a feed law with the largest feed that scallop_um and roughness_um accept, and "
            "make no table"
        ),
    ] = False,
    tolerance_nm: Annotated[
        float | None,
        Option(
            "largest error of u and x in nm (default: 1; u of a refitted section 5, of a cam 10, "
            "of a polygon 1, 3 or 10)",
            "T",
        ),
    ] = None,
    plot: Annotated[bool, Option("also draw PNG plots")] = False,
    export: Annotated[
        str | None,
        Option(
            "also write the table as text: points with velocity and acceleration, values only, or "
            "these in the form of SEW or Kollmorgen",
            choices=FORMS,
        ),
    ] = None,
    export_height: Annotated[
        tuple[float, ...],
        Option(
            "height to export in mm, into its own file; repeatable (default: all, in one file)",
            "MM",
        ),
    ] = (),
    export_points: Annotated[
        int | None,
        Option(
            f"points per turn, {MIN_POINTS} .. {MAX_POINTS} (default: the knots for xyva, else "
            "360)",
            "N",
        ),
    ] = None,
) -> int:
    """Make the cam table of a part."""
    if schema:
        write_all(output, {name: text.encode() for name, text in schemas().items()})
        return 0
    if part is None:
        raise UsageError("the following arguments are required: PART.toml")
    if tolerance_nm is not None:
        check_tolerance(tolerance_nm)
    loaded = load(part)
    if propose_feed:
        sys.stdout.write(loaded.kind.proposed_feed(loaded.part))
        return 0
    correction = correcting.correction(loaded, output)
    made = make(loaded, part, tolerance_nm=tolerance_nm, correction=correction)
    exported = _exported(made.table.table, export, export_height, export_points)
    write_all(output, made.files(with_plots=plot) | exported)
    sys.stdout.write(made.text())
    return 0


def _exported(
    table: Table, form: str | None, heights_mm: tuple[float, ...], n_points: int | None
) -> dict[str, bytes]:
    if form is None:
        if heights_mm or n_points is not None:
            option = "--export-height" if heights_mm else "--export-points"
            problem = f"{option}: has no effect without --export"
            raise CamtoolsError([f"{problem}; add --export {' or --export '.join(FORMS)}"])
        return {}
    if n_points is not None and not MIN_POINTS <= n_points <= MAX_POINTS:
        problem = f"--export-points {n_points}: must be {MIN_POINTS} .. {MAX_POINTS}"
        raise CamtoolsError([f"{problem}; give points per turn"])
    return export_files(table, Export(form, heights_mm, n_points))


main = command("mktables", mktables, allow_abbrev=True)

if __name__ == "__main__":
    sys.exit(main())
