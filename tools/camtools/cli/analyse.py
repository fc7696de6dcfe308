"""Command line of the analysis: areas, equal parts, speed law, forces, refit; motion of lobes.

>>> from camtools.skirt.part.part_file import example_part
>>> sorted(skirt_products(example_part(), AnalysisWishes(), with_pictures=False)[1])[:3]
['analysis.json', 'axes_equal_volume.csv', 'axes_uniform.csv']
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

import numpy as np

from camtools.base.command import Parser, run_command
from camtools.base.csv_text import csv_text
from camtools.base.errors import CamtoolsError
from camtools.base.json_text import emit_json
from camtools.base.output import write_all
from camtools.lobe.part import LobePart
from camtools.papers import lobe, paths, refit, section
from camtools.papers.lobe import LobeWishes
from camtools.papers.section import Analysis, AnalysisWishes, make_analysis
from camtools.pipeline.load import load_able
from camtools.plots.panels import Drawers, pictures
from camtools.skirt.part.part_file import SkirtPart

_DRAWN_DEG = 0.25  # step of the curves of a cam


def _arguments(argv: list[str] | None) -> argparse.Namespace:
    parser = Parser(
        prog="tools/analyse",
        description="Analyse one section of a piston: areas, equal parts, speed law, forces "
        "and, for a section with a corner, its refit. Analyse a cam: motion of the tool or wheel, "
        "speed, contact and curvature. A cam takes only --step-deg and --rpm.",
        allow_abbrev=False,
    )
    add = parser.add_argument
    add("part", type=Path, metavar="PART.toml", help="part file")
    add("-o", "--output", type=Path, required=True, metavar="DIR", help="folder for the results")
    add(
        "--height",
        type=float,
        metavar="MM",
        help="height of the section in mm (default: of the largest diameter)",
    )
    add(
        "--step-deg",
        type=float,
        default=3.0,
        metavar="D",
        help="step of Table 1 in degrees (default: 3)",
    )
    add(
        "--parts", type=int, metavar="N", help="equal parts of a quarter turn (default: the part's)"
    )
    add(
        "--turns",
        type=int,
        default=1,
        metavar="N",
        help="turns in the tables of axis positions (default: 1)",
    )
    add(
        "--slice-volume-mm3",
        type=float,
        default=0.04,
        metavar="V",
        help="largest volume of a slice in mm3 (default: 0.04)",
    )
    add(
        "--cycle-us",
        type=float,
        default=50.0,
        metavar="T",
        help="controller cycle in us (default: 50)",
    )
    add(
        "--kc-n-mm2",
        type=float,
        default=700.0,
        metavar="K",
        help="specific cutting force in N/mm2 (default: 700)",
    )
    add(
        "--kc-exponent",
        type=float,
        default=0.0,
        metavar="M",
        help="exponent of its size effect (default: 0, none)",
    )
    add(
        "--nose-mm",
        type=float,
        default=0.8,
        metavar="R",
        help="nose radius of the tool in mm (default: 0.8)",
    )
    add("--rpm", type=float, metavar="N", help="mean spindle speed in r/min (default: the part's)")
    return parser.parse_args(argv)


def _wishes(arguments: argparse.Namespace) -> AnalysisWishes:
    return AnalysisWishes(
        height_mm=arguments.height,
        step_deg=arguments.step_deg,
        parts=arguments.parts,
        slice_volume_mm3=arguments.slice_volume_mm3,
        cycle_us=arguments.cycle_us,
        kc_n_mm2=arguments.kc_n_mm2,
        kc_exponent=arguments.kc_exponent,
        rpm=arguments.rpm,
        turns=arguments.turns,
        nose_mm=arguments.nose_mm,
    )


def _files(found: Analysis, nose_mm: float, *, with_pictures: bool) -> dict[str, bytes]:
    texts = section.table_files(found) | {"notes.md": section.notes(found)}
    texts["analysis.json"] = emit_json(section.figures(found))
    ends = found.geometry.z_first_mm, found.geometry.z_last_mm
    limits = found.part.machine.limits
    study = paths.make_study(*ends, found.feed_mm, found.rpm, nose_mm, limits)
    slope = np.abs(found.geometry.radius_mm(np.linspace(*ends, 2001), 1)).max()
    texts["paths.csv"] = paths.study_csv(study, float(slope))
    drawers = section.drawers(found) | paths.drawers(found.name, study)
    if found.geometry.corner is not None:
        joint = found.geometry.corner.joint(found.height_mm)
        corner = refit.study(joint, found.height_mm, found.rpm)
        texts |= {f"{key}.csv": csv_text(table) for key, table in refit.tables(corner).items()}
        texts["refit_notes.md"] = refit.notes(corner)
        drawers |= refit.drawers(corner)
    files = {name: text.encode("utf-8") for name, text in texts.items()}
    return files | (_drawn(drawers) if with_pictures else {})


def _drawn(drawers: Drawers) -> dict[str, bytes]:
    return {f"{topic}.png": png for topic, png in pictures(drawers).items()}


def lobe_products(
    part: LobePart, wishes: LobeWishes, *, with_pictures: bool = True
) -> tuple[str, dict[str, bytes]]:
    """Return what is printed of a cam, and the content of every file by its name.

    Raises
    ------
    CamtoolsError
        A wish is out of range, or the part impossible.
    """
    studies = lobe.study_lobes(part, wishes)
    figures = lobe.lobe_figures(part, studies)
    files = {f"lobe_{one.number}.csv": csv_text(lobe.lobe_columns(one)).encode() for one in studies}
    files["analysis.json"] = emit_json(figures).encode()
    if with_pictures:
        fine = lobe.study_lobes(part, wishes._replace(step_deg=_DRAWN_DEG))
        files |= _drawn(lobe.drawers(part.part.name, fine))
    return lobe.lobe_text(figures), files


def _lobe_wishes(arguments: argparse.Namespace) -> LobeWishes:
    """Return the wishes for a cam; refuse options that it has no use for."""
    given, plain = vars(arguments), vars(_arguments([str(arguments.part), "-o", "x"]))
    for name, value in given.items():
        if name not in ("part", "output", "step_deg", "rpm") and value != plain[name]:
            option = f"--{name.replace('_', '-')}"
            problem = f"{option} {value}: has no meaning for a cam"
            raise CamtoolsError([f"{problem}; leave it out"])
    return LobeWishes(arguments.step_deg, arguments.rpm)


def skirt_products(
    part: SkirtPart, wishes: AnalysisWishes, *, with_pictures: bool = True
) -> tuple[str, dict[str, bytes]]:
    """Return what is printed of a skirt, and the content of every file by its name.

    Raises
    ------
    CamtoolsError
        A wish is out of range, or the part impossible.
    """
    found = make_analysis(part, wishes)
    files = _files(found, wishes.nose_mm, with_pictures=with_pictures)
    told = section.summary(found)
    if "refit_notes.md" in files:
        told += "\n" + files["refit_notes.md"].decode("utf-8")
    return told, files


def _run(arguments: argparse.Namespace) -> int:
    part = load_able("analyse", arguments.part)
    try:
        if isinstance(part, LobePart):
            told, files = lobe_products(part, _lobe_wishes(arguments))
        else:
            assert isinstance(part, SkirtPart)
            told, files = skirt_products(part, _wishes(arguments))
    except CamtoolsError as error:
        raise CamtoolsError([f"{arguments.part}: {line}" for line in error.lines]) from error
    write_all(arguments.output, files)
    sys.stdout.write(told)
    return 0


def main(argv: list[str] | None = None) -> int:
    """Run the command; return its exit status: 0 done, 2 bad input, 128 + n on signal n."""
    return run_command("analyse", lambda: _run(_arguments(argv)))


if __name__ == "__main__":
    sys.exit(main())
