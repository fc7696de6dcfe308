r"""Sheets as the page shows them, as pictures, and as data in sheets.json.

>>> axis = Feature("long axis", "diameter", "mm", 92.0, 91.9999, -1e-4, None, "no tolerance given")
>>> _row(axis)[3:6]
('91.999 900', '-0.1000 µm', '')
"""

import json
from typing import NamedTuple

from camtools.base.quantities import UM_PER_MM
from camtools.base.text import Json, emit_json
from camtools.plots.style import png_of
from camtools.report.sheet import (
    GOOD,
    NO_TOLERANCE,
    OUT,
    Feature,
    LineSheet,
    SectionSheet,
    Sheets,
    Subject,
    make_sheets,
    shown_number,
)
from camtools.report.sheet_plots import draw_lines, draw_section
from camtools.report.text import ReportRow
from camtools.roundness.section import Circle, Roundness, RoundWave
from camtools.sim.drawn_parts import FAIL, PASS
from camtools.sim.results import AnyCut

SHEETS = "sheets.json"
_COLUMNS = 5  # of the table of harmonics
_CLASSES = {GOOD: "good", OUT: "poor", PASS: "good", FAIL: "poor"}

Row = tuple[str, str, str, str, str, str, str, str, str]  # at last the class of the verdict and U


class SheetView(NamedTuple):
    """A sheet: picture and tables, all text."""

    title: str
    png: bytes
    rows: list[Row]
    waves: list[list[tuple[str, str, str]]]  # rows of order, amplitude and phase
    wave_title: str


class SheetPages(NamedTuple):
    """All sheets of a page, and their files by name."""

    head: list[ReportRow]
    left_out: str
    missing: list[str]
    views: list[SheetView]
    files: dict[str, bytes]
    out: list[str]  # what is out of tolerance
    undecided: list[str]
    is_certified: bool


def _row(feature: Feature) -> Row:
    """Return a line of a table: deviations of millimetres in micrometres."""
    unit, small = ("°", "°") if feature.unit == "°" else (f" {feature.unit}", " µm")
    deviation = shown_number(feature.deviation, feature.unit)
    if feature.unit == "mm" and feature.deviation is not None:
        deviation = f"{feature.deviation * UM_PER_MM:.4f} µm"
    elif deviation:
        deviation += unit
    sign = "" if feature.is_width else "±"
    return (
        feature.name,
        f"{feature.quantity}, {feature.unit}",
        shown_number(feature.nominal, feature.unit),
        shown_number(feature.actual, feature.unit),
        deviation,
        "" if feature.tolerance is None else f"{sign}{feature.tolerance:g}{small}",
        "\N{EN DASH}" if feature.verdict == NO_TOLERANCE else feature.verdict,
        _CLASSES.get(feature.verdict, "none"),
        "" if feature.expanded is None else shown_number(feature.expanded, small) + small,
    )


def _wave_rows(sheet: SectionSheet) -> list[list[tuple[str, str, str]]]:
    """Return the harmonics of the deviation, running down the columns."""
    cells = [
        (f"{wave.order}", f"{wave.amplitude * UM_PER_MM * 1000:.3f}", f"{wave.phase_deg:.1f}°")
        for wave in sheet.section.off_waves
    ]
    n_rows = -(-len(cells) // _COLUMNS)
    return [cells[i::n_rows] for i in range(n_rows)]


def _views(sheets: Sheets) -> tuple[list[SheetView], dict[str, bytes]]:
    views, files = [], {}
    along = "radius" if sheets.subject.has_radius else "along the normal"
    wave_title = f"Harmonics of the deviation: amplitude in nm ({along}), angle of the first crest"
    for number, sheet in enumerate(sheets.sections, 1):
        png = png_of(draw_section(sheet, sheets))
        files[f"cut_sheet{number}.png"] = png
        rows = [_row(feature) for feature in sheet.features]
        title = f"Section {number}: {sheet.name}"
        views.append(SheetView(title, png, rows, _wave_rows(sheet), wave_title))
    if sheets.lines:
        png = png_of(draw_lines(sheets))
        files["cut_profiles.png"] = png
        rows = [
            _row(feature._replace(name=f"{line.angle_deg:g}°: {feature.name}"))
            for line in sheets.lines
            for feature in line.features
        ]
        rows += [_row(feature) for feature in sheets.tapers]
        views.append(SheetView("Profiles along the axis", png, rows, [], ""))
    return views, files


def _circle(circle: Circle) -> Json:
    return {"diameter_mm": 2 * circle.radius_mm, "x_mm": circle.x_mm, "y_mm": circle.y_mm}


def _roundness(roundness: Roundness, zone_mm: float) -> Json:
    names = ("RONt_LS_um", "RONp_LS_um", "RONv_LS_um", "RONq_LS_um", "RONt_MZ_um")
    values_mm = (*roundness[1:], zone_mm)
    return {name: mm * UM_PER_MM for name, mm in zip(names, values_mm, strict=True)}


def _waves(waves: list[RoundWave]) -> list[Json]:
    return [{"order": n, "amplitude_um": mm * UM_PER_MM, "phase_deg": deg} for n, mm, deg in waves]


def _section(sheet: SectionSheet, *, is_oval: bool) -> Json:
    found, more = sheet.section, {}
    if is_oval:
        more = {
            "section": _roundness(found.whole, found.whole_zone.width_mm),
            "LS_circle": _circle(found.whole.circle),
            "MC_circle": _circle(found.circumscribed),
            "MI_circle": _circle(found.inscribed),
            "harmonics_of_section": _waves(found.whole_waves),
        }
    return more | {
        "name": sheet.name,
        "z_mm": sheet.z_mm,
        "features": [feature._asdict() for feature in sheet.features],
        "deviation": _roundness(found.off, found.off_zone.width_mm),
        "largest_deviation_um": found.largest_mm * UM_PER_MM,
        "largest_deviation_deg": found.largest_deg,
        "harmonics_of_deviation": _waves(found.off_waves),
    }


def _line(line: LineSheet) -> Json:
    return {
        "angle_deg": line.angle_deg,
        "from_mm": float(line.z_mm[0]),
        "to_mm": float(line.z_mm[-1]),
        "points": int(line.z_mm.size),
        "features": [feature._asdict() for feature in line.features],
    }


def out_of_tolerance(document: bytes | None, key: str = "out_of_tolerance") -> list[str]:
    """Return what the sheets found out of tolerance, or "not_decided", from sheets.json."""
    return [] if document is None else list(json.loads(document)[key])


def sheets_json(sheets: Sheets) -> bytes:
    """Return all sheets as JSON text; lengths of harmonics and RON are along the radius."""
    document = {
        "head": {row.name: row.value for row in sheets.head},
        "cutoff_upr": sheets.upr,
        "left_out": sheets.subject.left_out,
        "not_cut": sheets.missing,
        "out_of_tolerance": sheets.out,
        "not_decided": sheets.undecided,
        "sections": [_section(sheet, is_oval=sheets.subject.is_oval) for sheet in sheets.sections],
        "profiles": [_line(line) for line in sheets.lines],
        "tapers": [taper._asdict() for taper in sheets.tapers],
    }
    return emit_json(document).encode("ascii")


def sheet_pages(outcome: AnyCut, subject: Subject) -> SheetPages | None:
    """Return the sheets of a cut, drawn; nothing when no section was gauged."""
    sheets = make_sheets(outcome, subject)
    if sheets is None:
        return None
    views, files = _views(sheets)
    files[SHEETS] = sheets_json(sheets)
    verdicts = (sheets.out, sheets.undecided, sheets.is_certified)
    return SheetPages(sheets.head, subject.left_out, sheets.missing, views, files, *verdicts)
