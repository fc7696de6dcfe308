"""Sheets whose every answer is known in closed form, and sections of a real cut, recomputed."""

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple, cast

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.interpolate import CubicSpline

from camtools.base.quantities import Floats
from camtools.part.areas import Area, ZonedTolerances
from camtools.part.common import FormTolerances
from camtools.part.datum import Datum
from camtools.plots.style import drawing
from camtools.report.sheet import NO_TOLERANCE, Feature, Sheets, Subject, make_sheets
from camtools.report.sheet_page import out_of_tolerance, sheet_pages, sheets_json
from camtools.report.sheet_plots import draw_lines, draw_section
from camtools.report.text import verdict_of
from camtools.roundness.section import transmission
from camtools.sim.drawn_parts import WHOLE, DrawnParts
from camtools.sim.results import (
    PLACES,
    AnyCut,
    Cut,
    CutTrace,
    GaugedLine,
    GaugedSection,
    GaugedSections,
    GaugedSurface,
    sections_of,
)
from camtools.skirt.geometry.skirt_geometry import Geometry
from camtools.skirt.part.part_file import SkirtPart
from tests.tools.cases.camsim_cases import cut, refusal, while_in
from tests.tools.cases.cut_cases import made_of, written
from tests.tools.cases.part_cases import sure
from tests.tools.cases.report_cases import made_up_summary

A_MM, G_MM, PHASE_DEG = 46.0, 0.2, 12.0  # long half axis, ovality, direction of the long axis
MEAN_MM, C_MM, C_RAD = 3e-3, 1e-3, 0.9  # too large by 6 um of diameter, off centre by 1 um
FIVE_MM, FIFTY_MM = 2e-3, 1e-4  # waves on the section
OVAL_MM, OVAL_RAD = 4e-4, 0.5  # second harmonic of the deviation
PHI = 2 * np.pi * np.arange(PLACES) / PLACES
T = {order: float(transmission(order, 50)) for order in (1, 2, 5, 50)}
MADE_UP = SimpleNamespace(part=SimpleNamespace(part=SimpleNamespace(name="made-up")))
OVAL = Subject(is_oval=True, has_radius=True)


def deviation_mm(phi: Floats) -> Floats:
    """Return the deviation of the made-up part from its drawing."""
    return np.asarray(
        MEAN_MM
        + C_MM * np.cos(phi - C_RAD)
        + OVAL_MM * np.cos(2 * phi - OVAL_RAD)
        + FIVE_MM * np.cos(5 * phi)
        + FIFTY_MM * np.cos(50 * phi),
        dtype=np.float64,
    )


def drawn_mm(phi: Floats) -> Floats:
    """Return the drawing: an oval of one harmonic, turned."""
    wave = np.cos(2 * (phi - np.radians(PHASE_DEG)))
    return np.asarray(A_MM - G_MM / 4 + G_MM / 4 * wave, dtype=np.float64)


def section(
    off_mm: Floats | None = None, gaps: Sequence[tuple[float, float]] = (), number: int = 1
) -> GaugedSection:
    """Return the made-up section, or one of another deviation, without some angles [deg]."""
    off_mm = deviation_mm(PHI) if off_mm is None else off_mm
    is_there = np.ones(PLACES, dtype=np.bool_)
    for low_deg, high_deg in gaps:
        is_there &= (np.radians(low_deg) > PHI) | (np.radians(high_deg) < PHI)
    rows = np.array([PHI / (2 * np.pi), drawn_mm(PHI) + off_mm, off_mm])[:, is_there]
    return GaugedSection(number, 20.0, *rows)


def line(angle_deg: float, slope: float) -> GaugedLine:
    """Return a barrel with a leaning parabola of 1 um on it."""
    z_mm = np.linspace(0, 60, 1025)
    off_mm = slope * (z_mm - 30) + 1e-3 * ((z_mm - 30) / 30) ** 2
    return GaugedLine(angle_deg, z_mm, A_MM - 1e-4 * (z_mm - 20) ** 2 + off_mm, off_mm)


def cut_of(sections: GaugedSections, tolerance_um: float = 5.0) -> AnyCut:
    """Return a cut of which nothing but the sections is known."""
    form = {"max": 6.0, "rms": 2.0, "tolerance": tolerance_um}
    nothing = np.empty(0)
    return Cut(
        cast(Any, MADE_UP),
        made_up_summary(form_error_um=form),
        GaugedSurface(*[nothing] * 4),
        CutTrace(*[nothing] * 10),
        sections=sections,
    )


LINES = tuple(line(deg, slope) for deg, slope in ((0, 1e-5), (90, 0), (180, 3e-5), (270, -1e-5)))
GAUGED = GaugedSections((section(),), LINES)


def sheets_of(
    gauged: GaugedSections = GAUGED, tolerance_um: float = 5.0, **subject: object
) -> Sheets:
    """Make the sheets of a made-up cut of an oval, of which something else may be known."""
    return sure(make_sheets(cut_of(gauged, tolerance_um), OVAL._replace(**cast(Any, subject))))


@pytest.fixture(scope="module")
def sheets() -> Sheets:
    """Make the sheets of the made-up part."""
    return sheets_of()


def by_name(features: list[Feature]) -> dict[str, Feature]:
    """Return features by their names."""
    return {one.name: one for one in features}


def of_section(sheets: Sheets) -> dict[str, Feature]:
    """Return the features of the only section by their names."""
    return by_name(sheets.sections[0].features)


def test_size_ovality_and_phase_are_the_known_ones(sheets: Sheets) -> None:
    """The second harmonics of drawing and deviation add as arrows; odd waves leave diameters be."""
    found = of_section(sheets)
    arrow = G_MM / 4 * np.exp(2j * np.radians(PHASE_DEG))
    arrow += T[2] * OVAL_MM * np.exp(1j * OVAL_RAD)
    mean_mm = 2 * (A_MM - G_MM / 4 + MEAN_MM)
    fifty = 2 * FIFTY_MM * T[50]  # on top of the crest or the valley, somewhere
    sizes = (
        ("long axis", 2 * A_MM, mean_mm + 2 * abs(arrow), fifty),
        ("short axis", 2 * (A_MM - G_MM / 2), mean_mm - 2 * abs(arrow), fifty),
        ("mean of all diameters", 2 * A_MM - G_MM / 2, mean_mm, 1e-12),
        ("ovality: long less short axis", G_MM, 4 * abs(arrow), 2 * fifty),
        ("phase of the long axis", PHASE_DEG, np.degrees(np.angle(arrow)) / 2, 1e-9),
    )
    for name, nominal, actual, margin in sizes:
        assert found[name].nominal == pytest.approx(nominal, abs=1e-6), name
        assert found[name].actual == pytest.approx(actual, abs=margin), name
        assert found[name].deviation == pytest.approx(actual - nominal, abs=margin + 1e-6), name
    phi = np.linspace(0, np.pi, 200_001)  # a dense search; 3600 places miss a crest by 0.1 nm
    diameter = mean_mm + 2 * np.real(arrow * np.exp(-2j * phi)) + fifty * np.cos(50 * phi)
    assert found["long axis"].actual == pytest.approx(diameter.max(), abs=1e-7)
    assert found["short axis"].actual == pytest.approx(diameter.min(), abs=1e-7)


def test_roundness_of_the_deviation_is_the_known_one() -> None:
    """Five lobes alone, off centre: RONt is twice the amplitude behind the filter, LS and MZ."""
    off_mm = MEAN_MM + C_MM * np.cos(PHI - C_RAD) + FIVE_MM * np.cos(5 * PHI)
    sheets = sheets_of(GaugedSections((section(off_mm),)))
    found = of_section(sheets)
    five_um = 1e3 * FIVE_MM * T[5]
    for name, um in (
        ("roundness of the deviation RONt, LS", 2 * five_um),
        ("roundness of the deviation RONt, MZ", 2 * five_um),
        ("RONp, LS", five_um),
        ("RONv, LS", five_um),
        ("RONq, LS", five_um / np.sqrt(2)),
    ):
        assert found[name].actual == pytest.approx(um, abs=1e-4), name
    centre = sheets.sections[0].section.off.circle
    assert np.hypot(centre.x_mm, centre.y_mm) == pytest.approx(C_MM * T[1], abs=1e-9)
    assert centre.radius_mm == pytest.approx(A_MM - G_MM / 4 + MEAN_MM, abs=1e-7)


def test_harmonics_straightness_and_taper(sheets: Sheets) -> None:
    """Unfiltered waves, STRt 1 um of a parabola of 1 um, opposite slopes add to the taper."""
    known = {1: (C_MM, C_RAD), 2: (OVAL_MM, OVAL_RAD), 5: (FIVE_MM, 0), 50: (FIFTY_MM, 0)}
    for wave in sheets.sections[0].section.off_waves:
        amplitude_mm, crest_rad = known.get(wave.order, (0.0, None))
        assert wave.amplitude == pytest.approx(amplitude_mm, abs=1e-12)
        if crest_rad is not None:
            turned = np.exp(1j * (np.radians(wave.phase_deg) * wave.order - crest_rad))
            assert turned == pytest.approx(1, abs=1e-6)
    for one in sheets.lines:
        found = by_name(one.features)
        assert found["straightness of the deviation STRt, LS"].actual == pytest.approx(1, abs=1e-5)
        assert found["straightness of the deviation STRt, MZ"].actual == pytest.approx(1, abs=1e-5)
        assert found["STRq, LS"].actual == pytest.approx(2 / np.sqrt(45), rel=3e-3)
    assert [one.actual for one in sheets.tapers] == pytest.approx([2.4, -0.6], abs=1e-9)
    assert sheets.tapers[0].name == "taper 0°/180° over 60 mm, off the drawing"


def test_form_is_judged_unfiltered_and_nothing_else_without_a_tolerance(sheets: Sheets) -> None:
    """The verdict on the form turns at the tolerance; features without one say so."""
    name = "form: largest deviation, unfiltered"
    worst_um = 1e3 * float(np.abs(deviation_mm(PHI)).max())
    for tolerance_um, verdict in ((worst_um + 1e-3, "good"), (worst_um - 1e-3, "out of tolerance")):
        form = of_section(sheets_of(tolerance_um=tolerance_um))[name]
        assert form.actual == pytest.approx(worst_um, abs=1e-9)
        assert form.verdict == verdict
    features = [*sheets.sections[0].features, *sheets.tapers]
    features += [one for each in sheets.lines for one in each.features]
    for one in features:
        assert (one.verdict == NO_TOLERANCE) == (one.tolerance is None), one.name
    judged = {one.name for one in features if one.tolerance is not None}
    assert judged == {name, "profile: largest deviation"}


STATED = {
    "diameter_um": ("long axis", 1),
    "ovality_um": ("ovality: long less short axis", 1),
    "phase_deg": ("phase of the long axis", 1),
    "roundness_um": ("roundness of the deviation RONt, MZ", 0),
    "straightness_um": ("straightness of the deviation STRt, MZ", 0),
    "taper_um": ("taper 0°/180° over 60 mm, off the drawing", 0),
}


@pytest.mark.parametrize("key", STATED)
def test_stated_tolerance_decides_at_its_value(sheets: Sheets, key: str) -> None:
    """A tolerance just above what was cut is good, one just below is not; no other is judged."""
    name, has_nominal = STATED[key]

    def features(found: Sheets) -> dict[str, Feature]:
        lines = [one for each in found.lines for one in each.features]
        return by_name([*found.sections[0].features, *lines, *found.tapers])

    plain = features(sheets)
    one = plain[name]
    size = abs(sure(one.deviation if has_nominal else one.actual)) * (
        1e3 if one.unit == "mm" else 1
    )
    for share, verdict in ((1.001, "good"), (0.999, "out of tolerance")):
        stated = ZonedTolerances.model_validate({key: share * size})
        judged = features(sheets_of(tolerances=stated))
        assert judged[name].verdict == verdict
        changed = {each for each in judged if judged[each].verdict != plain[each].verdict}
        assert changed <= {name, "short axis", "taper 90°/270° over 60 mm, off the drawing"}


def test_tolerances_of_a_part_file(perkins: SkirtPart) -> None:
    """[tolerances] is taken as it is written; of polygons axes have none."""
    part = perkins.model_dump(exclude_none=True) | {"tolerances": {"ovality_um": 2.0}}
    assert SkirtPart.model_validate(part).tolerances == ZonedTolerances(ovality_um=2.0)
    with pytest.raises(ValidationError, match="ovality_um"):
        FormTolerances.model_validate({"ovality_um": 2.0})


def oval_at(phi_rad: Floats, z_mm: Floats) -> Floats:
    """Return the drawing at places of the made-up part."""
    return drawn_mm(phi_rad) + 0 * z_mm


def slot(from_deg: float, to_deg: float) -> Area:
    """Return a box around the height of the section, without a margin."""
    return Area((from_deg + to_deg) / 2, to_deg - from_deg, 10.0, 30.0, *(0.0, 0.0, 0.0))


def test_window_is_left_out_of_circles_and_axes() -> None:
    """An eccentric circle keeps its centre; diameters need both their ends; the share is stated."""
    gauged = GaugedSections((section(C_MM * np.cos(PHI - C_RAD), [(80, 100)]),))
    found = sheets_of(gauged, windows=(slot(80, 100),), drawn_mm=oval_at)
    assert found.missing == []
    names, off = of_section(found), found.sections[0].section.off
    share = names["share of the turn that was measured; axes in windows are left out"]
    assert share.actual == pytest.approx(100 * 340 / 360, abs=0.06)
    bridge_mm = C_MM * (1 - np.cos(np.radians(10)))  # between a chord of 20 degrees and its arc
    centre_mm = off.circle.x_mm + 1j * off.circle.y_mm
    assert abs(centre_mm - C_MM * np.exp(1j * C_RAD)) < bridge_mm
    assert off.total_mm < 2 * bridge_mm
    # The short axis lies at 102 degrees, beside the window; that at 90 would end in it.
    assert names["short axis"].nominal == pytest.approx(2 * (A_MM - G_MM / 2), abs=1e-9)
    assert names["short axis"].deviation == pytest.approx(0, abs=1e-4)


@pytest.mark.parametrize(
    ("windows", "gaps"),
    [
        ((), [(80, 100)]),
        ((slot(80, 95),), [(80, 100)]),
        ((slot(200, 220),), [(80, 100)]),
        ((slot(0, 180),), [(0, 180)]),
        ((slot(0, 62), slot(120, 182), slot(240, 302)), [(0, 62), (120, 182), (240, 302)]),
    ],
)
def test_gap_without_a_window_is_no_section(
    windows: tuple[Area, ...], gaps: list[tuple[float, float]]
) -> None:
    """What is not cut all round but for windows, or has no diameter, is named, not judged."""
    gauged = GaugedSections((section(0 * PHI, gaps),), LINES)
    found = sheets_of(gauged, windows=windows, drawn_mm=oval_at)
    assert (found.sections, found.missing) == ([], ["height 20 mm"])


def test_zone_states_its_own_tolerances() -> None:
    """Those of the zone where it has any, else those of the part; straightness within the zone."""
    zones = [
        {"name": "low", "from_mm": 0, "to_mm": 30, "form_error_um": 7, "straightness_um": 0.2},
        {"name": "high", "from_mm": 30, "to_mm": 60, "ovality_um": 9},
    ]
    stated = {"zone": zones, "ovality_um": 3, "roundness_um": 4}
    found = sheets_of(tolerances=ZonedTolerances.model_validate(stated))
    names = of_section(found)
    assert found.sections[0].name == "height 20 mm, zone low"
    assert names["form: largest deviation, unfiltered"].tolerance == 7
    assert names["ovality: long less short axis"].tolerance == 3
    assert names["roundness of the deviation RONt, MZ"].tolerance == 4
    # The lower half of a parabola of 1 um over 60 mm is a quarter of it over 30 mm.
    straight = by_name(found.lines[0].features)["straightness of the deviation STRt, MZ, zone low"]
    assert straight.actual == pytest.approx(0.25, abs=0.002)
    assert (straight.tolerance, straight.verdict) == (0.2, "out of tolerance")


def test_run_out_is_seen_from_the_datum() -> None:
    """A perfect section 3 and 4 um beside the axis runs out by 2 x 5 um; the phase by the bore."""
    datum = Datum(offset_um=[3, 2], tilt_um_per_mm=[0, 0.1], bore_off_deg=1)
    gauged = GaugedSections((section(0 * PHI),))
    for most_um, verdict in ((10.01, "good"), (9.99, "out of tolerance")):
        stated = ZonedTolerances(runout_um=most_um)
        names = of_section(sheets_of(gauged, datum=datum, tolerances=stated))
        assert names["run-out to the datum axis"].actual == pytest.approx(10, abs=1e-4)
        assert names["run-out to the datum axis"].verdict == verdict
        phase = names["phase of the long axis"]
        assert (phase.actual, phase.deviation) == pytest.approx((PHASE_DEG - 1, -1), abs=1e-6)


@pytest.mark.usefixtures("undrawn")
def test_sections_without_roundness() -> None:
    """A part of a turn is named, not judged; a lobe has no axes; along the normal."""
    found = sheets_of(GaugedSections((section(), section(None, [(300, 360)], 2))))
    assert [one.name for one in found.sections] == found.missing == ["height 20 mm"]
    assert make_sheets(cut_of(GaugedSections()), OVAL) is None
    lobe = Subject(False, False, "long and short axis: a lobe is no oval", ("lobe 0",))
    alone = GaugedSections((section(),))
    found = sheets_of(alone, **lobe._asdict())
    assert found.sections[0].name == "lobe 0"
    names = of_section(found)
    assert not any("axis" in name or "as it is" in name for name in names)
    assert {one.quantity for one in names.values()} == {"along the normal"}
    assert sure(sheet_pages(cut_of(alone), lobe)).left_out == lobe.left_out


@pytest.mark.parametrize("is_fastest_told", [False, True])
def test_too_few_ticks_call_no_roundness_good(is_fastest_told: bool) -> None:
    """The fastest turn counts; waves between its ticks are missing, so only what is out is sure."""
    name = "roundness of the deviation RONt, MZ"
    for tolerance_um, verdict in ((900.0, "not judged: too few points"), (0.1, "out of tolerance")):
        cut = cut_of(GAUGED)
        if is_fastest_told:
            cut.summary["feasibility"]["spindle_rpm"] = {"needed": 6000.0}
        else:
            cut.summary["cut"]["spindle_rpm"] = 6000.0
        stated = ZonedTolerances(roundness_um=tolerance_um)
        found = sure(make_sheets(cut, OVAL._replace(tolerances=stated)))
        assert of_section(found)[name].verdict == verdict
        points = {row.name: row.value for row in found.head}["points"]
        few = "from 200 ticks per turn; fewer than 7 ticks per wave at 50 UPR"
        assert is_fastest_told or few in points  # at 20 kHz and 6000 r/min


@pytest.mark.usefixtures("undrawn")
def test_what_is_out_is_told_by_the_verdict_of_the_part() -> None:
    """The form error is good, a stated tolerance is not: the part is out, and its data say why."""
    cut = cut_of(GAUGED, 9.0)
    oval = OVAL._replace(tolerances=ZonedTolerances(ovality_um=0.1))
    pages = sure(sheet_pages(cut, oval))
    assert pages.out == ["height 20 mm: ovality: long less short axis"]
    assert out_of_tolerance(pages.files["sheets.json"]) == pages.out
    assert out_of_tolerance(None) == []
    verdict = verdict_of(cut, pages.out)
    assert (verdict_of(cut).kind, verdict.kind) == ("good", "poor")
    assert verdict.title == "out of tolerance"
    assert pages.out[0] in verdict.sentence


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(
    ("room_um", "whole_um", "section_um", "verdict", "of_part"),
    [
        (0.4, 0.3, 0.3, "pass", "pass"),
        (0.4, 0.3, 0.5, "not decided", "not decided"),
        (0.4, 0.5, 0.3, "pass", "not decided"),
        (0.4, 0.3, None, "not decided", "not decided"),
        (-0.4, 0.5, 0.5, "not decided", "not decided"),
        (-0.4, 0.5, 0.3, "fail", "fail"),
    ],
)
def test_uncertainty_of_a_forecast_decides(
    room_um: float, whole_um: float, section_um: float | None, verdict: str, of_part: str
) -> None:
    """All parts of the forecast are off this one by U, half of them to either side."""
    largest_um = 1e3 * float(np.abs(deviation_mm(PHI)).max())
    cut = cut_of(GaugedSections((section(),)), largest_um + room_um)
    cut.summary["form_error_um"]["max"] = largest_um
    name, signs = "form: largest deviation, unfiltered", np.resize([1.0, -1.0], 100)
    off = {WHOLE: whole_um, f"height 20 mm: {name} [µm]": section_um}
    values = {key: largest_um + um * signs for key, um in off.items() if um is not None}
    cut = replace(cut, drawn=DrawnParts(values, "there"))
    sheets, pages = sure(make_sheets(cut, OVAL)), sure(sheet_pages(cut, OVAL))
    assert pages.is_certified
    found = of_section(sheets)[name]
    assert found.expanded == (None if section_um is None else pytest.approx(section_um))
    assert found.verdict == verdict
    row = next(row for row in pages.views[0].rows if row[0] == name)
    kind = {"pass": "good", "fail": "poor"}.get(verdict, "none")
    assert row[6:] == (verdict, kind, "" if section_um is None else f"{section_um:.4f} µm")
    assert out_of_tolerance(pages.files["sheets.json"], "not_decided") == pages.undecided
    told = verdict_of(cut, pages.out, pages.undecided)
    assert (told.title, told.kind) == (of_part, "good" if of_part == "pass" else "poor")
    assert {row.name: row.value for row in pages.head}["conformity"].endswith("drawn in there")


def test_data_and_page_have_the_same_numbers(sheets: Sheets) -> None:
    """sheets.json has each feature in full, the page its digits; both name radius or diameter."""
    document = json.loads(sheets_json(sheets))
    pages = sure(sheet_pages(cut_of(GAUGED), OVAL))
    assert pages.files["sheets.json"] == sheets_json(sheets)
    told = document["sections"][0]["features"]
    assert [one["actual"] for one in told] == [one.actual for one in sheets.sections[0].features]
    for one, row in zip(told, pages.views[0].rows, strict=True):
        assert one["quantity"] in ("radius", "diameter", "distance", "angle")
        assert row[:2] == (one["name"], f"{one['quantity']}, {one['unit']}")
        assert float(row[3].replace(" ", "")) == pytest.approx(one["actual"], abs=5.1e-5)
    waves = [cell for row in pages.views[0].waves for cell in row]
    assert sorted(int(cell[0]) for cell in waves) == list(range(1, 51))


def test_bars_begin_at_the_floor_that_is_named(sheets: Sheets) -> None:
    """No bar reaches below the axis, small waves have none, and the label tells the floor."""
    with drawing():
        figure = draw_section(sheets.sections[0], sheets)
        axes = figure.axes[-1]
        low = axes.get_ylim()[0]
        bars = axes.patches
        assert len(bars) == 50
        assert all(bar.get_y() == pytest.approx(low) for bar in bars)  # type: ignore[attr-defined]
        tall = [i + 1 for i, bar in enumerate(bars) if bar.get_height() > 0]  # type: ignore[attr-defined]
        assert tall == [1, 2, 5, 50]
        assert f"floor of {low:g} µm" in axes.get_xlabel()
        assert len(draw_lines(sheets).axes) == 5


HEIGHTS_MM = (0.8, 2.4)
TURNS = 32


class RealCut(NamedTuple):
    """A short cut of the Perkins skirt on the default machine."""

    table: Path
    gauged: GaugedSections
    turn: Floats  # of every tick of cutting
    z_mm: Floats
    error_mm: Floats


@pytest.fixture(scope="module")
def real(tmp_path_factory: pytest.TempPathFactory) -> RealCut:
    """Cut the first turns of the skirt, traced."""
    table = written(made_of("perkins240"), tmp_path_factory.mktemp("sections"))
    words = ("--sections-mm", ",".join(map(str, HEIGHTS_MM)), "--turns-limit", TURNS)
    found = cut(table, *words, "--no-learning", tables=["sections", "trace"])
    ticks = while_in(found.trace, "cutting")
    turn, z_mm, error_nm = (ticks[name] for name in ("true_turn", "true_z_mm", "error_nm"))
    return RealCut(table, sections_of(found.sections), turn, z_mm, error_nm * 1e-6)


def of_trace(real: RealCut, z_mm: float) -> Floats:
    """Return the deviation all round at a height: one spline along all turns, then the height."""
    first, last = int(np.ceil(real.turn[0])), int(np.floor(real.turn[-1])) - 1
    turns = np.arange(first, last)[:, None] + PHI / (2 * np.pi)
    rows = (CubicSpline(real.turn, values)(turns).T for values in (real.z_mm, real.error_mm))
    return np.array([np.interp(z_mm, *places) for places in zip(*rows, strict=True)])


def test_sections_are_those_of_the_trace(real: RealCut) -> None:
    """All 3600 places within 0.05 nm of a spline along the ticks, at both heights."""
    assert [one.is_whole for one in real.gauged.sections] == [True, True]
    for one in real.gauged.sections:
        off_mm = one.deviation_mm - of_trace(real, one.z_mm)
        assert np.abs(off_mm).max() < 5e-8
        assert np.ptp(one.deviation_mm) > 2e-5  # there is something to be found
        assert one.turn == pytest.approx(PHI / (2 * np.pi), abs=1e-8)


def test_radius_is_that_of_the_drawing_and_the_deviation(real: RealCut, geometry: Geometry) -> None:
    """The radius less the deviation is the ellipse of the generator at that height."""
    for one in real.gauged.sections:
        drawn_mm = geometry.radius_mm(one.z_mm) - geometry.delta(PHI, one.z_mm).delta
        assert one.radius_mm - one.deviation_mm == pytest.approx(drawn_mm, abs=5e-9)
    for line in real.gauged.lines:
        at = np.full(line.z_mm.size, np.radians(line.angle_deg))
        drawn_mm = geometry.radius_mm(line.z_mm) - geometry.delta(at, line.z_mm).delta
        assert line.radius_mm - line.deviation_mm == pytest.approx(drawn_mm, abs=5e-9)


def test_lines_are_those_of_the_trace(real: RealCut) -> None:
    """Along the height at four angles, within 0.05 nm; engaging turns are not in them."""
    assert [one.angle_deg for one in real.gauged.lines] == [0.0, 90.0, 180.0, 270.0]
    error, height = CubicSpline(real.turn, real.error_mm), CubicSpline(real.turn, real.z_mm)
    for line in real.gauged.lines:
        turns = np.arange(np.ceil(real.turn[0]), real.turn[-1] - 1)
        turns += line.angle_deg / 360
        turns = turns[turns > real.turn[1]]
        inside = (line.z_mm > height(turns[0])) & (line.z_mm < height(turns[-1]))
        assert inside.sum() > 0.9 * line.z_mm.size
        expected = np.interp(line.z_mm[inside], height(turns), error(turns))
        assert line.deviation_mm[inside] == pytest.approx(expected, abs=5e-8)
        assert real.z_mm[0] <= line.z_mm[0] and line.z_mm[-1] <= real.z_mm[-1]


def test_without_heights_there_are_five(real: RealCut) -> None:
    """They are spread over the part."""
    rows = cut(real.table, "--feed", 1, "--no-learning", tables=["sections"]).sections
    found = sections_of(rows)
    assert [one.z_mm for one in found.sections] == pytest.approx([6.2, 18.6, 31, 43.4, 55.8])
    assert all(one.is_whole for one in found.sections)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--sections-mm", "5"), "no file for them"),
        (("--sections", "s.csv", "--sections-mm", "5,4"), "no rising heights"),
        (("--sections", "s.csv", "--sections-mm", "5,x"), "no rising heights"),
        (("--sections", "s.csv", "--sections-mm", "5,"), "no rising heights"),
        (("--sections", "s.csv", "--sections-mm", "99"), "beyond the part"),
        (("--sections", "s.csv", "--sections-mm", ",".join(map(str, range(17)))), "1 .. 16"),
    ],
)
def test_wrong_heights_are_refused(real: RealCut, words: tuple[str, ...], told: str) -> None:
    """Heights without a file, not rising, no numbers, beyond the part, or too many."""
    assert told in refusal(real.table, *words)
