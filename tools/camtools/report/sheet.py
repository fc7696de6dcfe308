"""Sheets of a gauged part: what a roundness instrument would print, from the gauged sections.

>>> verdict_of(0.1, 0.2), verdict_of(-0.3, 0.2), verdict_of(0.1, None)
('good', 'out of tolerance', 'no tolerance given')
"""

from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from camtools.base.quantities import UM_PER_MM, Bools, Floats
from camtools.part.areas import LINES_DEG, Area, ZonedTolerances, in_any
from camtools.part.common import SectionTolerances
from camtools.part.datum import Datum
from camtools.report.text import ReportRow, origin_rows
from camtools.roundness.section import (
    POINTS_PER_WAVE,
    SectionFigures,
    Straightness,
    axes_of,
    section_of,
    straightness,
)
from camtools.sim.drawn_parts import CONFIDENCE, FAIL, NOT_DECIDED, SHARE, DrawnParts, decision
from camtools.sim.results import PLACES, AnyCut, GaugedLine, GaugedSection

GOOD, OUT, NO_TOLERANCE = "good", "out of tolerance", "no tolerance given"
TOO_COARSE = "not judged: too few points"
_RADIUS, _SIZE = ("radius", "µm"), ("diameter", "mm")
_LEAST_POINTS = 3  # of a line
_LEAST_SHARE = 0.25  # of a section, that must be material
_WIDEST = 0.45  # gap of a turn; beyond, the centre of a circle is free
_LOST_TICKS = 4  # beside a window, where the gauge has no cubic
_ROUNDNESS_MZ = "roundness of the deviation RONt, MZ"
_STRAIGHTNESS_MZ = "straightness of the deviation STRt, MZ"
_SEEN_UM = 0.1  # by which an axis may lie beside what was measured
_OVAL_UM = 1.0  # ovality below which a long axis has no direction


class Subject(NamedTuple):
    """What of a sheet applies to a kind of part."""

    is_oval: bool  # it has a long and a short axis
    has_radius: bool  # the deviation is along the radius, else along the normal of the profile
    left_out: str = ""  # what does not apply and why
    names: tuple[str, ...] = ()  # of the sections by number, else they are named by height
    tolerances: ZonedTolerances = ZonedTolerances()  # that the drawing states
    note: str = ""  # what the reader must know of the drawing
    windows: tuple[Area, ...] = ()  # without material
    datum: Datum = Datum()  # of run-out and phase
    drawn_mm: Callable[[Floats, Floats], Floats] | None = None  # radius at angles [rad] and heights


class Feature(NamedTuple):
    """A line of the table of a sheet; lengths in mm or um as `unit` says."""

    name: str
    quantity: str  # diameter, radius, distance, angle
    unit: str
    nominal: float | None
    actual: float
    deviation: float | None
    tolerance: float | None  # the largest size of the deviation that is good; of mm in um
    verdict: str
    is_width: bool = False  # of a zone: never below 0
    expanded: float | None = None  # uncertainty U with k = 2, as the tolerance; none: not known

    @property
    def size(self) -> float:
        """Return what is compared with the tolerance, in its unit: the deviation, if there is."""
        value = abs(self.actual) if self.deviation is None else self.deviation
        return value * (UM_PER_MM if self.unit == "mm" else 1)


class SectionSheet(NamedTuple):
    """A section: its name, its figures, its table."""

    name: str
    z_mm: float
    section: SectionFigures
    features: list[Feature]


class LineSheet(NamedTuple):
    """A profile along the axis: the deviation from the drawing, and the radius as it is."""

    angle_deg: float
    z_mm: Floats
    radius_mm: Floats
    deviation_mm: Floats
    off: Straightness  # of the deviation
    whole: Straightness  # of the radius
    features: list[Feature]


class Sheets(NamedTuple):
    """All sheets of a part."""

    head: list[ReportRow]
    subject: Subject
    upr: int
    sections: list[SectionSheet]
    lines: list[LineSheet]
    tapers: list[Feature]
    missing: list[str]  # sections that were not cut all round
    is_certified: bool = False  # verdicts take the uncertainty of the machine into account

    def tables(self) -> Iterator[tuple[str, list[Feature]]]:
        """Yield each table with what its features are named by besides."""
        yield from ((f"{sheet.name}: ", sheet.features) for sheet in self.sections)
        yield from ((f"profile {line.angle_deg:g}°: ", line.features) for line in self.lines)
        yield "", self.tapers

    def named(self, *verdicts: str) -> list[str]:
        """Return the features of some verdicts, by sheet and feature."""
        return [
            f"{at}{entry.name}"
            for at, table in self.tables()
            for entry in table
            if entry.verdict in verdicts
        ]

    @property
    def out(self) -> list[str]:
        """Return what is out of tolerance, by sheet and feature."""
        return self.named(OUT, FAIL)

    @property
    def undecided(self) -> list[str]:
        """Return what the uncertainty, or too few points, leave open, by sheet and feature."""
        return self.named(NOT_DECIDED, TOO_COARSE) + self.missing if self.is_certified else []


def verdict_of(deviation: float, tolerance: float | None) -> str:
    """Return whether a deviation is within a tolerance, where there is one."""
    if tolerance is None:
        return NO_TOLERANCE
    return GOOD if abs(deviation) <= tolerance else OUT


def feature(
    name: str,
    kind: tuple[str, str],
    actual: float,
    tolerance: float | None = None,
    nominal: float | None = None,
) -> Feature:
    """Return a line of a table of a length [mm], its tolerance in um, or of an angle.

    Without a nominal value it is a deviation.
    """
    actual *= UM_PER_MM if kind[1] == "µm" else 1
    deviation = None if nominal is None else actual - nominal
    entry = Feature(name, *kind, nominal, actual, deviation, tolerance, NO_TOLERANCE)
    return entry._replace(verdict=verdict_of(entry.size, tolerance))


def _width(
    name: str, width_mm: float, tolerance_um: float | None, kind: tuple[str, str] = _RADIUS
) -> Feature:
    """Return the line of a zone."""
    return feature(name, kind, width_mm, tolerance_um)._replace(is_width=True)


def _axes_features(
    section: SectionFigures, stated: SectionTolerances, bore_off_deg: float
) -> list[Feature]:
    """Return sizes and phase of an oval; axes that end in a window are left out."""
    drawn, cut, whole = section.drawn_axes, section.cut_axes, axes_of(section.drawn_mm)
    axes = (
        ("long axis", cut.long_mm, drawn.long_mm, whole.long_mm),
        ("short axis", cut.short_mm, drawn.short_mm, whole.short_mm),
    )
    found = [
        feature(name, _SIZE, cut_mm, stated.diameter_um, drawn_mm)
        for name, cut_mm, drawn_mm, whole_mm in axes
        if abs(whole_mm - drawn_mm) * UM_PER_MM < _SEEN_UM
    ]
    has_both = len(found) == len(axes)
    found.append(feature("mean of all diameters", _SIZE, cut.mean_mm, None, drawn.mean_mm))
    if drawn.ovality_mm * UM_PER_MM < _OVAL_UM:
        return found
    if has_both:
        oval = (cut.ovality_mm, stated.ovality_um, drawn.ovality_mm)
        found.append(feature("ovality: long less short axis", _SIZE, *oval))
    turned_deg = (cut.phase_deg - bore_off_deg - drawn.phase_deg + 90) % 180 - 90
    phase = (drawn.phase_deg + turned_deg, stated.phase_deg, drawn.phase_deg)
    return [*found, feature("phase of the long axis", ("angle", "°"), *phase)]


def _form_features(
    section: SectionFigures, subject: Subject, tolerance_um: float | None, stated: SectionTolerances
) -> list[Feature]:
    um = _RADIUS if subject.has_radius else ("along the normal", "µm")
    off = section.off
    return [
        feature("form: largest deviation, unfiltered", um, section.largest_mm, tolerance_um),
        feature("roundness of the deviation RONt, LS", um, off.total_mm),
        feature("RONp, LS", um, off.peak_mm),
        feature("RONv, LS", um, off.valley_mm),
        feature("RONq, LS", um, off.q_mm),
        _width(_ROUNDNESS_MZ, section.off_zone.width_mm, stated.roundness_um, um),
    ]


def _whole_features(section: SectionFigures) -> list[Feature]:
    centre, apart = section.whole.circle, ("distance", "µm")
    return [
        feature("RONt of the section as it is, LS", _RADIUS, section.whole.total_mm),
        feature("RONt of the section as it is, MZ", _RADIUS, section.whole_zone.width_mm),
        feature("least-squares circle", _SIZE, 2 * centre.radius_mm),
        feature("smallest circle around it", _SIZE, 2 * section.circumscribed.radius_mm),
        feature("largest circle within it", _SIZE, 2 * section.inscribed.radius_mm),
        feature("centre of the LS circle, towards 0°", apart, centre.x_mm),
        feature("centre of the LS circle, towards 90°", apart, centre.y_mm),
    ]


def _zone_features(line: GaugedLine, stated: ZonedTolerances) -> Iterator[Feature]:
    """Yield the straightness within each zone that has one of its own."""
    for zone in stated.zones:
        is_in = (line.z_mm >= zone.from_mm) & (line.z_mm <= zone.to_mm)
        is_here = zone.has_line(line.angle_deg) and np.count_nonzero(is_in) >= _LEAST_POINTS
        if zone.straightness_um is not None and is_here:
            found = straightness(line.z_mm[is_in], line.deviation_mm[is_in])
            name = f"{_STRAIGHTNESS_MZ}, zone {zone.name}"
            yield _width(name, found.zone_mm, zone.straightness_um)


def _line_sheet(line: GaugedLine, tolerance_um: float, stated: ZonedTolerances) -> LineSheet:
    off, whole = (straightness(line.z_mm, values) for values in (line.deviation_mm, line.radius_mm))
    has_own = any(zone.straightness_um is not None for zone in stated.zones)
    straight_um = None if has_own else stated.straightness_um
    worst_mm = float(line.deviation_mm[np.abs(line.deviation_mm).argmax()])
    form_um = None if stated.zones else tolerance_um
    features = [
        feature("profile: largest deviation", _RADIUS, worst_mm, form_um),
        feature("straightness of the deviation STRt, LS", _RADIUS, off.total_mm),
        _width(_STRAIGHTNESS_MZ, off.zone_mm, straight_um),
        feature("STRq, LS", _RADIUS, off.q_mm),
        feature("straightness as it is STRt, LS", _RADIUS, whole.total_mm),
        *_zone_features(line, stated),
    ]
    return LineSheet(*line, off, whole, features)


def _tapers(lines: list[LineSheet], tolerance_um: float | None) -> Iterator[Feature]:
    """Yield how the diameter through two lines grows off the drawing, MATHS.md (206)."""
    by_angle = {line.angle_deg: line for line in lines}
    for deg in (0.0, 90.0):
        if {deg, deg + 180.0} <= by_angle.keys():
            side, opposite = by_angle[deg], by_angle[deg + 180.0]
            span_mm = min(float(np.ptp(line.z_mm)) for line in (side, opposite))
            grown_mm = (side.off.slope + opposite.off.slope) * span_mm
            over = f"{deg:g}°/{deg + 180.0:g}° over {span_mm:.4g} mm"
            name = f"taper {over}, off the drawing"
            yield feature(name, ("diameter", "µm"), grown_mm, tolerance_um)


def ticks_per_turn(outcome: AnyCut) -> float:
    """Return how many ticks a turn has at the highest speed that the cut needs."""
    summary = outcome.summary
    needed_rpm = summary["feasibility"]["spindle_rpm"]["needed"]
    fastest_rpm = max(summary["cut"]["spindle_rpm"], needed_rpm)
    return float(summary["tick_hz"] * 60 / fastest_rpm)


def _not_too_coarse(entry: Feature) -> Feature:
    """Return a feature, but no good roundness: the waves between ticks are missing."""
    is_good = (entry.name, entry.verdict) == (_ROUNDNESS_MZ, GOOD)
    return entry._replace(verdict=TOO_COARSE) if is_good else entry


def _head(outcome: AnyCut, upr: int) -> list[ReportRow]:
    per_turn, enough = ticks_per_turn(outcome), ""
    if per_turn < POINTS_PER_WAVE * upr:
        enough = (
            f"; fewer than {POINTS_PER_WAVE} ticks per wave at {upr} UPR, so waves above "
            f"{per_turn / POINTS_PER_WAVE:.0f} per turn are smoothed and "
            "no roundness is accepted as good"
        )
    return [
        ReportRow("part", outcome.name),
        *origin_rows(outcome),
        ReportRow(
            "instrument",
            "simulated: a roundness instrument with a rotary table and a point stylus without "
            "force or radius, centred on the axis of the drawing; true surface, no noise",
        ),
        ReportRow(
            "filter",
            f"Gauss, ISO 16610-21, 1\N{EN DASH}{upr} UPR (50 % at {upr}), on the "
            "deviation from the drawing; form and harmonics unfiltered",
        ),
        ReportRow("points", f"{PLACES} per turn from {per_turn:.0f} ticks per turn{enough}"),
        ReportRow("references", "LS: least squares, MZ: minimum zone (ISO 12181-1, ISO 12780-1)"),
        ReportRow(
            "conformity",
            "good: the unrounded value does not exceed the tolerance; no guard band, since the "
            "simulated instrument has no uncertainty; a dash: no tolerance given",
        ),
    ]


class _Around(NamedTuple):
    """A section at all places of a turn; NaN where it was not measured."""

    drawn_mm: Floats
    deviation_mm: Floats
    is_measured: Bools


def _is_enough(is_measured: Bools) -> bool:
    """Return whether a section has opposite points, and no gap near half a turn."""
    has_diameter = bool((is_measured & np.roll(is_measured, PLACES // 2)).any())
    there = np.flatnonzero(is_measured)
    widest = int(np.diff(there, append=there[0] + PLACES).max())
    return has_diameter and widest < _WIDEST * PLACES


def _around(measured: GaugedSection, subject: Subject, lost: float) -> _Around | None:
    """Return a section that was cut all round but for windows and `lost` [turn] beside them."""
    if measured.is_whole:
        whole = np.ones(PLACES, dtype=np.bool_)
        return _Around(measured.radius_mm - measured.deviation_mm, measured.deviation_mm, whole)
    if subject.drawn_mm is None or measured.turn.size < _LEAST_SHARE * PLACES:
        return None
    turn, z_mm = np.arange(PLACES) / PLACES, np.full(PLACES, measured.z_mm)
    drawn_mm, deviation_mm = subject.drawn_mm(2 * np.pi * turn, z_mm), np.full(PLACES, np.nan)
    places = np.round(measured.turn * PLACES).astype(np.int64) % PLACES
    deviation_mm[places] = measured.deviation_mm
    lost_mm = 2 * np.pi * lost * float(drawn_mm.max())
    beside = [area._replace(margin_mm=area.margin_mm + lost_mm) for area in subject.windows]
    is_measured = np.isfinite(deviation_mm)
    if not _is_enough(is_measured):
        return None
    is_known = is_measured | in_any(beside, turn, z_mm, drawn_mm)
    return _Around(drawn_mm, deviation_mm, is_measured) if is_known.all() else None


def _run_out(
    section: SectionFigures, centre_mm: tuple[float, float], tolerance_um: float | None
) -> Feature:
    """Return the range of the deviation, seen from an axis beside that of the skirt."""
    n = section.filtered_mm.size
    phi = 2 * np.pi * np.arange(n) / n
    seen_mm = section.filtered_mm - centre_mm[0] * np.cos(phi) - centre_mm[1] * np.sin(phi)
    range_mm = float(np.ptp(seen_mm[section.is_measured]))
    return _width("run-out to the datum axis", range_mm, tolerance_um)


def _share(section: SectionFigures) -> Feature:
    percent = 100 * float(section.is_measured.mean())
    name = "share of the turn that was measured"
    name += "" if section.is_measured.all() else "; axes in windows are left out"
    return feature(name, ("angle", "%"), percent)


def _name_of(measured: GaugedSection, subject: Subject) -> str:
    named = measured.number <= len(subject.names)
    name = subject.names[measured.number - 1] if named else f"height {measured.z_mm:g} mm"
    zone = subject.tolerances.zone_at(measured.z_mm)
    return name if zone is None else f"{name}, zone {zone.name}"


def _section_features(
    section: SectionFigures, z_mm: float, subject: Subject, tolerance_um: float
) -> list[Feature]:
    """Return the table of a section, by what holds at its height."""
    stated, datum = subject.tolerances.stated_at(z_mm), subject.datum
    form_um = subject.tolerances.form_error_at(z_mm, tolerance_um)
    features = _form_features(section, subject, form_um, stated)
    if not subject.is_oval:
        return features
    axes = _axes_features(section, stated, datum.bore_off_deg)
    whole = _whole_features(section) if section.is_measured.all() else []
    return [*axes, *features, *whole, _run_out(section, datum.centre_mm(z_mm), stated.runout_um)]


def make_sheets(outcome: AnyCut, subject: Subject) -> Sheets | None:
    """Return the sheets of a cut; nothing when no section was gauged."""
    gauged, upr, stated = outcome.sections, outcome.cutoff_upr, subject.tolerances
    if not gauged.sections and not gauged.lines:
        return None
    tolerance_um = float(outcome.summary["form_error_um"]["tolerance"])
    per_turn = ticks_per_turn(outcome)
    is_coarse, lost = per_turn < POINTS_PER_WAVE * upr, _LOST_TICKS / per_turn
    sections, missing = [], []
    for measured in gauged.sections:
        name, found = _name_of(measured, subject), _around(measured, subject, lost)
        if found is None:
            missing.append(name)
            continue
        section = section_of(*found, upr)
        features = _section_features(section, measured.z_mm, subject, tolerance_um)
        features = list(map(_not_too_coarse, features)) if is_coarse else features
        features += [_share(section)] if subject.windows else []
        sections.append(SectionSheet(name, measured.z_mm, section, features))
    judged = [line for line in gauged.lines if line.z_mm.size >= _LEAST_POINTS]
    if subject.windows and gauged.lines:
        found_deg = {line.angle_deg for line in judged}
        missing += [f"profile {deg:g}°" for deg in LINES_DEG if deg not in found_deg]
    lines = [_line_sheet(line, tolerance_um, stated) for line in judged]
    head = _head(outcome, upr)
    head += [ReportRow("smoothing", subject.note)] if subject.note else []
    tapers = list(_tapers(lines, stated.taper_um))
    sheets = Sheets(head, subject, upr, sections, lines, tapers, missing)
    return sheets if outcome.drawn is None else _certified(sheets, outcome.drawn)


def _key(place: str, entry: Feature) -> str:
    return f"{place}{entry.name} [{'°' if entry.unit == '°' else 'µm'}]"


def sizes_of(outcome: AnyCut, subject: Subject) -> dict[str, float]:
    """Return the sizes of all features that a tolerance judges; nothing without a section."""
    sheets = make_sheets(outcome, subject)
    return {
        _key(place, entry): entry.size
        for place, features in (sheets.tables() if sheets is not None else ())
        for entry in features
        if entry.tolerance is not None
    }


def _decided(place: str, entry: Feature, drawn: DrawnParts) -> Feature:
    """Return a feature with U and the verdict that allows for it."""
    if entry.tolerance is None:
        return entry
    expanded = drawn.expanded(_key(place, entry), entry.size)
    verdict = decision(abs(entry.size), expanded, entry.tolerance)
    is_judged = entry.verdict in (GOOD, OUT)
    return entry._replace(expanded=expanded, verdict=verdict if is_judged else entry.verdict)


def _certified(sheets: Sheets, drawn: DrawnParts) -> Sheets:
    """Return sheets whose verdicts allow for the uncertainty of the machine."""
    for place, features in sheets.tables():
        features[:] = [_decided(place, entry, drawn) for entry in features]
    rule = (
        "pass: the size with U added does not exceed the tolerance; fail: with U taken off it "
        f"does; else not decided (ISO 14253-1). {100 * SHARE:.0f} % of all parts, the level of "
        f"k = 2, are within ±U, at {100 * CONFIDENCE:.0f} % confidence, by {drawn.n_parts} parts "
        f"on machines drawn in {drawn.folder}"
    )
    head = [row._replace(value=rule) if row.name == "conformity" else row for row in sheets.head]
    return sheets._replace(head=head, is_certified=True)


def shown_number(value: float | None, unit: str) -> str:
    """Return a number with the decimals that its unit deserves: nanometres, a thousandth degree.

    >>> shown_number(92.00001234, "mm"), shown_number(-0.01234, "µm"), shown_number(-1e-9, "°")
    ('92.000 012', '-0.0123', '0.0000')
    """
    if value is None:
        return ""
    if unit == "mm":
        digits = f"{value:.6f}"
        return f"{digits[:-3]} {digits[-3:]}"
    return f"{round(value, 4) + 0.0:.4f}"  # no minus before a zero
