"""Command line of the analysis: areas, equal parts, speed law, forces, refit; motion of lobes.

>>> from camtools.skirt.part.part_file import example_part
>>> sorted(skirt_products(example_part(), AnalysisWishes(), with_pictures=False)[1])[:3]
['analysis.json', 'axes_equal_volume.csv', 'axes_uniform.csv']
"""

from __future__ import annotations

import sys
from dataclasses import fields

import numpy as np

from camtools.base.arguments import Folder, PartFile, command, option_of
from camtools.base.errors import CamtoolsError
from camtools.base.files import write_all
from camtools.base.text import csv_text, emit_json
from camtools.lobe.part import LobePart
from camtools.papers import figures, lobe, paths, refit, section
from camtools.papers.lobe import LobeWishes
from camtools.papers.section import Analysis, AnalysisWishes, make_analysis
from camtools.pipeline.load import load_able
from camtools.plots.style import Drawers, pictures
from camtools.skirt.part.part_file import SkirtPart

_DRAWN_DEG = 0.25  # step of the curves of a cam


def _files(found: Analysis, nose_mm: float, *, with_pictures: bool) -> dict[str, bytes]:
    texts = section.table_files(found) | {"notes.md": section.notes(found)}
    texts["analysis.json"] = emit_json(section.figures(found))
    ends = found.geometry.ends_mm
    limits = found.part.machine.limits
    study = paths.make_study(*ends, found.feed_mm, found.rpm, nose_mm, limits)
    slope = np.abs(found.geometry.radius_mm(np.linspace(*ends, 2001), 1)).max()
    texts["paths.csv"] = paths.study_csv(study, float(slope))
    drawers = {**figures.section_drawers(found), **paths.drawers(found.name, study)}
    if found.geometry.corner is not None:
        joint = found.geometry.corner.joint(found.height_mm)
        corner = refit.study(joint, found.height_mm, found.rpm)
        texts |= {f"{key}.csv": csv_text(table) for key, table in refit.tables(corner).items()}
        texts["refit_notes.md"] = refit.notes(corner)
        drawers |= figures.refit_drawers(corner)
    files = {name: text.encode("utf-8") for name, text in texts.items()}
    return files | (_drawn(drawers) if with_pictures else {})


def _drawn(drawers: Drawers) -> dict[str, bytes]:
    return {f"{topic}.png": png for topic, png in pictures(drawers).items()}


def lobe_products(
    part: LobePart, wishes: LobeWishes, *, with_pictures: bool = True
) -> tuple[str, dict[str, bytes]]:
    """Return what is printed of a cam, and the content of every file by its name."""
    studies = lobe.study_lobes(part, wishes)
    extremes = lobe.lobe_figures(part, studies)
    files = {
        f"lobe_{study.number}.csv": csv_text(lobe.lobe_columns(study)).encode() for study in studies
    }
    files["analysis.json"] = emit_json(extremes).encode()
    if with_pictures:
        fine = lobe.study_lobes(part, wishes._replace(step_deg=_DRAWN_DEG))
        files |= _drawn(figures.lobe_drawers(part.part.name, fine))
    return lobe.lobe_text(extremes), files


def _lobe_wishes(given: AnalysisWishes) -> LobeWishes:
    """Return the wishes for a cam; refuse options that it has no use for."""
    for field in fields(given):
        name, value = field.name, getattr(given, field.name)
        if name not in LobeWishes._fields and value != field.default:
            problem = f"{option_of(name)} {value}: has no meaning for a cam"
            raise CamtoolsError([f"{problem}; leave it out"])
    return LobeWishes(given.step_deg, given.rpm)


def skirt_products(
    part: SkirtPart, wishes: AnalysisWishes, *, with_pictures: bool = True
) -> tuple[str, dict[str, bytes]]:
    """Return what is printed of a skirt, and the content of every file by its name."""
    found = make_analysis(part, wishes)
    files = _files(found, wishes.nose_mm, with_pictures=with_pictures)
    text = section.summary(found)
    if "refit_notes.md" in files:
        text += "\n" + files["refit_notes.md"].decode("utf-8")
    return text, files


def analyse(part: PartFile, output: Folder, wishes: AnalysisWishes) -> int:
    """Analyse one section of a piston, or a cam.

    Of a piston: areas, equal parts, speed law, forces and, for a section with a corner, its refit.
    Of a cam: motion of the tool or wheel, speed, contact and curvature; a cam takes only --step-deg
    and --rpm.
    """
    loaded = load_able("analyse", part)
    try:
        if isinstance(loaded, LobePart):
            text, files = lobe_products(loaded, _lobe_wishes(wishes))
        else:
            assert isinstance(loaded, SkirtPart)
            if loaded.piston.lands:
                problem = "is not analysed: it is not one helix from end to end"
                raise CamtoolsError([f"piston.land: {problem}; leave the lands out"])
            text, files = skirt_products(loaded, wishes)
    except CamtoolsError as error:
        raise CamtoolsError([f"{part}: {line}" for line in error.lines]) from error
    write_all(output, files)
    sys.stdout.write(text)
    return 0


main = command("tools/analyse", analyse)

if __name__ == "__main__":
    sys.exit(main())
