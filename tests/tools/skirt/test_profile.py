"""Profile and ovality: points, segments, formulas, smoothing of rounded points."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from camtools.base.errors import GeometryError
from camtools.base.quantities import Floats
from camtools.cli.run import main as run
from camtools.ngc.profile_program import segments
from camtools.part.areas import ZonedTolerances
from camtools.skirt.geometry.profile import (
    noise_facts,
    notable_overshoots,
    ovality_spline,
    pieces_of,
    profile_spline,
    smoothing_facts,
    smoothing_takes_um,
    smoothing_texts,
    tolerances_left,
)
from camtools.skirt.geometry.skirt_geometry import make_geometry
from camtools.skirt.kind import KIND
from camtools.skirt.part.curves import LAW_ERROR_MM
from camtools.skirt.part.keys import Ovality, Profile
from camtools.skirt.part.part_file import SkirtPart, example_part
from camtools.skirt.report.summary import emit_text, make_summary
from camtools.skirt.table.accuracy import UnreachableError
from camtools.skirt.table.generate import generate
from tests.tools.cases.camsim_cases import cut
from tests.tools.cases.cut_cases import made_skirt, written
from tests.tools.cases.part_cases import PERKINS, ROOT, changed, load_part, parse_part, refused

# the conical end of a drawing
HEIGHTS = [0.0, 2, 10, 20, 30, 40, 50, 62]
DIAMETERS = [91.0, 91.95, 91.985, 92, 91.985, 91.94, 91.866, 91.737]
CONE = {"to_mm": 2, "diameter_mm": 91.95}
BARREL = {"to_mm": 62, "diameter_mm": 91.737, "kind": "arc", "radius_mm": 3300}
START = {"interpolation": "segments", "height_mm": [0], "diameter_mm": [91]}


def part_of(profile: dict[str, Any], **piston: object) -> SkirtPart:
    """Return the example with another profile."""
    tables = {"profile": profile} | piston
    return changed(example_part(), {f"piston.{name}": keys for name, keys in tables.items()})


def drawn(**keys: object) -> dict[str, Any]:
    """Return the profile of the conical end."""
    return {"height_mm": HEIGHTS, "diameter_mm": DIAMETERS} | keys


def test_splines_that_overshoot() -> None:
    """Refused by profile and ovality with a remedy that works; what was allowed is reported."""
    assert refused(lambda: make_geometry(part_of(drawn())), GeometryError) == (
        "piston.profile.interpolation: between the points at 2 and 10 mm the diameter goes "
        '421.4 um beyond both, at height 5.14965 mm; set interpolation = "pchip", or give more '
        "points there, or allow it: overshoot_um = 430"
    )
    part = part_of(drawn(overshoot_um=900))
    told = "between the points at 2 and 10 mm the diameter goes 421.4 um beyond both"
    assert told in emit_text(make_summary(generate(part)))
    assert notable_overshoots(part.piston)[0].startswith(told)
    assert notable_overshoots(part_of(drawn(interpolation="pchip")).piston) == []
    make_geometry(part_of(drawn(overshoot_um=430)))
    for interpolation in ("pchip", "akima", "linear"):
        make_geometry(part_of(drawn(interpolation=interpolation)))
    ovality = {"height_mm": [0, 20, 25, 62], "ovality_mm": [0.2, 0.2, 0.3, 0.3]}
    profile, key = drawn(interpolation="pchip"), "interpolation"
    with pytest.raises(GeometryError, match=r"piston\.ovality\.interpolation: between the points"):
        make_geometry(part_of(profile, ovality=ovality | {key: "spline"}))
    make_geometry(part_of(profile, ovality=ovality | {key: "pchip"}))


def test_ovality_at_any_heights_is_followed_as_well_as_possible() -> None:
    """A step of curvature between two slices leaves 2 nm; who asks for 1 nm is told so."""
    heights = [0, 3.137, 11.713, 29.371, 41.93, 53.77, 62]
    ovality = {"height_mm": heights, "ovality_mm": [0.1, 0.25, 0.5, 0.2, 0.45, 0.3, 0.6]}
    flat = {"height_mm": [0, 62], "diameter_mm": [92, 91.9], "interpolation": "linear"}
    part = part_of(flat, ovality=ovality | {"interpolation": "pchip"})
    table = generate(part)
    assert 1 < table.accuracy_u.value_nm < 3
    assert "the ovality has corners or steps of curvature" in emit_text(make_summary(table))
    with pytest.raises(UnreachableError, match="unreachable for u, best achievable is 2"):
        generate(part, tolerance_nm=1.0)


@given(
    drops=st.lists(st.floats(0, 0.4), min_size=3, max_size=7),
    steps=st.lists(st.floats(0.5, 30), min_size=6, max_size=6),
)
@settings(max_examples=30)
def test_pchip_never_leaves_its_points(drops: list[float], steps: list[float]) -> None:
    """Between any two points every value lies between theirs, and it is theirs at the points."""
    z = np.concatenate([[0.0], np.cumsum(steps)])[: len(drops)].tolist()
    z[-1] = max(z[-1], 1.5)
    profile = Profile(height_mm=z, diameter_mm=[90 - d for d in drops], interpolation="pchip")
    curve = profile_spline(profile)
    for i in range(len(drops) - 1):
        ends = sorted((45 - drops[i] / 2, 45 - drops[i + 1] / 2))
        between = curve(np.linspace(z[i], z[i + 1], 201))
        assert ends[0] - 1e-12 <= between.min()
        assert between.max() <= ends[1] + 1e-12


def off_circle_nm(profile: Profile, index: int) -> float:
    """Return how far cubics are from the circle through the ends of an arc, extended precision.

    The circle is that of the drawing: two points and a radius.
    """
    z0, z1 = (np.longdouble(profile.height_mm[index + k]) for k in (0, 1))
    r0, r1 = (np.longdouble(profile.diameter_mm[index + k]) / 2 for k in (0, 1))
    radius = np.longdouble(pieces_of(profile)[index].radius_mm)
    half2 = ((z1 - z0) ** 2 + (r1 - r0) ** 2) / 4
    away = np.sqrt(radius**2 - half2) / np.sqrt(4 * half2) * np.sign(radius)
    centre = (z0 + z1) / 2 + (r1 - r0) * away, (r0 + r1) / 2 - (z1 - z0) * away
    z = np.linspace(profile.height_mm[index], profile.height_mm[index + 1], 4001)
    exact = centre[1] + np.sign(radius) * np.sqrt(radius**2 - (z - centre[0]) ** 2)
    return float(np.abs(profile_spline(profile)(z) - exact).max() * 1e6)


def test_arcs_are_circles_to_a_ten_thousandth_of_a_nanometre() -> None:
    """Barrel of 3.3 m, and a rounding of 1 mm on which the slope reaches 0.7."""
    barrel = Profile.model_validate(START | {"segment": [CONE, BARREL]})
    assert off_circle_nm(barrel, 1) < 1e-4
    small = {"to_mm": 1.414, "diameter_mm": 91, "kind": "arc", "radius_mm": 1.0}
    assert off_circle_nm(Profile.model_validate(START | {"segment": [small]}), 0) < 1e-4


@given(
    radius_mm=st.floats(30, 1e5),
    width_mm=st.floats(1, 40),
    rise_mm=st.floats(-1, 1),
    is_hollow=st.booleans(),
)
@settings(max_examples=30)
def test_random_arcs_are_circles(
    radius_mm: float, width_mm: float, rise_mm: float, *, is_hollow: bool
) -> None:
    """Any radius that spans its chord: on the circle, in extended precision."""
    arc = {
        "to_mm": width_mm,
        "diameter_mm": 91 + rise_mm,
        "kind": "arc",
        "radius_mm": -radius_mm if is_hollow else radius_mm,
    }
    assert off_circle_nm(Profile.model_validate(START | {"segment": [arc]}), 0) < 1e-4


def test_tangent_arc_has_the_radius_of_the_drawing() -> None:
    """A barrel of 4000 mm told by its tangent: the radius comes out, and the slope is continuous.

    The drawing's numbers are made from the circle's equation about height 20.
    """
    radius = 4000.0
    diameter = {z: 92 - 2 * (radius - np.sqrt(radius**2 - (z - 20.0) ** 2)) for z in (0, 10, 62)}
    slope = 10.0 / np.sqrt(radius**2 - 100)  # at height 10
    line = {"to_mm": 10, "diameter_mm": diameter[10]}
    arc = {"to_mm": 62, "diameter_mm": diameter[62], "kind": "arc", "tangent": True}
    start = START | {"diameter_mm": [diameter[10] - 20 * slope]}
    profile = Profile.model_validate(start | {"segment": [line, arc]})
    piece = pieces_of(profile)[1]
    assert piece.radius_mm == pytest.approx(radius, rel=1e-9)
    assert piece.kink_deg == pytest.approx(0, abs=1e-9)
    assert off_circle_nm(profile, 1) < 1e-4
    stated = Profile.model_validate(start | {"segment": [line, arc | {"radius_mm": 4000}]})
    assert pieces_of(stated)[1].kink_deg == pytest.approx(0, abs=1e-9)


def test_ends_follow_from_tangents() -> None:
    """An arc of given radius and a line go on in the direction of what is before them."""
    arc = {"to_mm": 30, "kind": "arc", "radius_mm": 2000, "tangent": True}
    line = {"to_mm": 62, "tangent": True}
    flat = {"to_mm": 10, "diameter_mm": 91}
    profile = Profile.model_validate(START | {"segment": [flat, arc, line]})
    drop = 2000 - np.sqrt(2000**2 - 20**2)
    slope = 20 / np.sqrt(2000**2 - 20**2)
    assert profile.diameter_mm[2] == pytest.approx(91 - 2 * drop, abs=1e-10)
    assert profile.diameter_mm[3] == pytest.approx(91 - 2 * (drop + 32 * slope), abs=1e-10)
    again = Profile.model_validate(profile.model_dump())
    assert again.diameter_mm == profile.diameter_mm


BAD_SEGMENTS = [
    ([CONE | {"tangent": True}], "no segment before it"),
    ([CONE | {"radius_mm": 5}], "a line has no radius_mm"),
    ([{"to_mm": 9, "kind": "arc", "diameter_mm": 91}], "an arc needs radius_mm"),
    ([{"to_mm": 9}], "needs diameter_mm"),
    ([CONE, BARREL | {"to_mm": 1.5}], "must increase"),
    ([CONE, BARREL | {"radius_mm": 29}], "cannot span its chord"),
    ([CONE, BARREL | {"diameter_mm": 2, "radius_mm": 44}], "turn back over height"),
    ([CONE, BARREL | {"tangent": True}], "turns by -12.94"),
    (
        [CONE, {"to_mm": 62, "kind": "arc", "radius_mm": 20, "tangent": True}],
        "reaches 26.62.* mm of height only",
    ),
]


@pytest.mark.parametrize(("segments", "problem"), BAD_SEGMENTS)
def test_segments_that_cannot_be_drawn_are_refused(
    segments: list[dict[str, Any]], problem: str
) -> None:
    """Each names what is wrong."""
    with pytest.raises(ValidationError, match=problem):
        Profile.model_validate(START | {"segment": segments})


def test_bulging_tangent_arc_wants_its_radius() -> None:
    """A derived arc far beyond both its ends is refused until the radius is stated, then told."""
    line = {"to_mm": 10, "diameter_mm": 91.5}
    arc = {"to_mm": 62, "diameter_mm": 91.5, "kind": "arc", "tangent": True}
    with pytest.raises(GeometryError, match=r"segment\.1\.tangent.*radius 1040.32 mm.*give its"):
        make_geometry(part_of(START | {"segment": [line, arc]}))
    stated = arc | {"radius_mm": 1040.325, "tangent": True}
    summary = KIND.summary(KIND.make(part_of(START | {"segment": [line, stated]})))
    told = summary["segments"]["profile"]
    assert told[0]["radius_mm"] is None
    assert told[1]["radius_mm"] == pytest.approx(26 / np.sin(np.arctan(0.025)), rel=1e-6)
    assert told[1]["kink_deg"] == pytest.approx(0, abs=1e-4)
    text = "profile: line to 10 mm, 91.5 mm; arc of 1040.33 mm to 62 mm, 91.5 mm"
    assert text in KIND.text(summary)


@pytest.mark.long
def test_cone_and_barrel_are_cut_on_their_circle(tmp_path: Path) -> None:
    """Away from the corner the cut lies on the drawing's line and circle to 0.2 um."""
    made = made_skirt(part_of(START | {"segment": [CONE, BARREL]}))
    found = cut(written(made, tmp_path), "--feed", "0.2")
    assert found.summary["is_good"]
    on_axis = found.surface["turn"] % 0.5 < 1 / 720
    z_mm, radius_mm = (found.surface[name][on_axis] for name in ("z_mm", "radius_mm"))
    clear = np.abs(z_mm - 2) > 0.5
    chord2 = 60.0**2 + (91.737 / 2 - 45.975) ** 2
    away = np.sqrt(3300**2 - chord2 / 4) / np.sqrt(chord2)
    centre = 32 + (91.737 / 2 - 45.975) * away, (91.737 / 2 + 45.975) / 2 - 60 * away
    exact = np.where(
        z_mm < 2, 45.5 + z_mm * 0.2375, centre[1] + np.sqrt(3300**2 - (z_mm - centre[0]) ** 2)
    )
    reduction_mm = 0.15 * np.sin(2 * np.pi / 720) ** 2
    off_mm = (radius_mm - exact)[clear]
    assert off_mm.min() > -reduction_mm - 2e-4
    assert off_mm.max() < 2e-4


def test_program_turns_at_the_corner_of_the_profile() -> None:
    """X in G33 has a point at the corner, and needs few segments: the arc's and the cone's."""
    geometry = make_geometry(part_of(START | {"segment": [CONE, BARREL]}))
    chords = segments(geometry, 0.0, 62.0, 0.0001)
    i = int(np.argmin(np.abs(chords.z_mm - 2)))
    assert (chords.z_mm[i], chords.z_mm.size < 60) == (2.0, True)
    assert chords.x_mm[i] == pytest.approx(91.95 / 2, abs=1e-9)


def test_list_of_the_corner_that_overshoots_is_refused() -> None:
    """Trim and joint are interpolated as the ovality is, and are checked as it is."""
    ovality = {
        "height_mm": [0, 20, 25, 62],
        "ovality_mm": [0.3, 0.31, 0.3125, 0.33],
        "interpolation": "spline",
    }
    section = {"shape": "ellipse-arc", "trim_mm": [0.2, 0.2, 0.3, 0.3], "joint_deg": 50}
    profile = drawn(interpolation="pchip")
    with pytest.raises(GeometryError, match=r"mm trim_mm over height goes .* um beyond both"):
        make_geometry(part_of(profile, ovality=ovality, section=section))
    section |= {"trim_mm": 0.3, "joint_deg": [50, 50, 53, 53]}
    with pytest.raises(GeometryError, match=r"joint_deg over height goes .* degrees beyond"):
        make_geometry(part_of(profile, ovality=ovality, section=section))


Z_MM = np.arange(0.0, 63)
DENSE_MM = np.linspace(0, 62, 2000)


def barrel(z_mm: Floats) -> tuple[Floats, Floats]:
    """Return diameter and its second derivative of a barrel of the fourth degree [mm]."""
    off = (z_mm - 25) / 37
    return 92 - 0.05 * off**2 - 0.21 * off**4, -(0.1 + 2.52 * off**2) / 37**2


def listed(**keys: object) -> dict[str, Any]:
    """Return the profile as a list of micrometres."""
    diameter_mm = np.round(barrel(Z_MM)[0], 3).tolist()
    return {"height_mm": Z_MM.tolist(), "diameter_mm": diameter_mm} | keys


def test_curvature_is_that_of_the_barrel_before_rounding() -> None:
    """Points each mm, rounded to 1 um: met within the band, with the bend of the curve."""
    exact = barrel(DENSE_MM)[1]
    raw, smooth = (
        profile_spline(Profile.model_validate(listed(**keys))) for keys in ({}, {"smooth_um": 0.5})
    )
    inner = slice(100, -100)  # at the ends a spline has no neighbours to one side
    off = [np.abs(2 * one(DENSE_MM, 2) - exact)[inner].max() for one in (raw, smooth)]
    peak = np.abs(exact).max()
    assert off[0] > 0.5 * peak and off[1] < 0.08 * peak
    off_um = 1000 * (2 * smooth(Z_MM) - np.round(barrel(Z_MM)[0], 3))
    assert 0.4 < np.abs(off_um).max() <= 0.5 + 1e-6


def test_ovality_is_smoothed_and_never_below_zero() -> None:
    """A band wider than the least ovality leaves it at 0 or above."""
    ovality_mm = [0.002, 0, 0.001, 0.004, 0.003, 0.006, 0.005, 0.009]
    keys = {"height_mm": [float(9 * i) for i in range(8)], "ovality_mm": ovality_mm}
    found = ovality_spline(Ovality.model_validate(keys | {"smooth_um": 3.0}))(keys["height_mm"])
    assert found.min() >= 0 and np.abs(found - ovality_mm).max() <= 0.003 + 1e-9
    assert np.abs(np.diff(found, 3)).max() < 0.1 * np.abs(np.diff(ovality_mm, 3)).max()


def part_text(profile: dict[str, Any]) -> str:
    """Return the Perkins skirt with another profile over its heights, good to 5 um."""
    before, _, rest = PERKINS.read_text().partition("[piston.profile]")
    after = rest[rest.index("[piston.ovality]") :]
    rows = "".join(f"{key} = {value}\n" for key, value in profile.items())
    text = f"{before}[piston.profile]\n{rows}\n{after}"
    return text.replace("form_error_um = 0.2", "form_error_um = 5")


@pytest.mark.usefixtures("undrawn")
def test_residuals_are_reported() -> None:
    """JSON, text and picture of the table."""
    profile = listed(smooth_um=0.5)
    made = made_skirt(parse_part(part_text(profile)), 20.0)
    pictures = [name for name in made.files(with_plots=True) if name.endswith("_smoothing.png")]
    assert len(pictures) == 1
    found = made.kind.summary(made.table)["smoothing"]["profile"]
    off_um = 2000 * profile_spline(Profile.model_validate(profile))(Z_MM)
    off_um -= 1000 * np.array(profile["diameter_mm"])
    assert found["largest_um"] == pytest.approx(np.abs(off_um).max(), abs=1e-6)
    assert found["rms_um"] == pytest.approx(np.sqrt(np.mean(off_um**2)), rel=1e-6)
    bends = found["bend_per_mm"]
    assert bends["after"] == pytest.approx(np.abs(barrel(Z_MM)[1]).max(), rel=0.25)  # at an end
    assert bends["before"] > 1.2 * bends["after"]
    assert "profile smoothed within 0.5 um: largest residual 0.5 um" in made.text()
    assert "  smoothing takes 0.25 um of the tolerance of 5 um\n" in made.text()


@pytest.mark.long
@pytest.mark.usefixtures("undrawn")
def test_report_of_a_cut_has_residuals(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The tolerance is what smoothing leaves of it."""
    (tmp_path / "p.toml").write_text(part_text(listed(smooth_um=0.5)))
    words = [str(tmp_path / "p.toml"), "--feed", "2", "-o", str(tmp_path / "out")]
    assert run(words) in (0, 1)
    share = "against the smoothed drawing (4.75 um left: smoothing takes 0.25 um"
    shown = capsys.readouterr().out
    assert share in shown and "against the drawing" not in shown
    assert (tmp_path / "out" / "cut_smoothing.png").exists()
    assert "profile smoothed within 0.5 um" in (tmp_path / "out" / "report.html").read_text()


def test_smoothing_without_an_effect() -> None:
    """Lines and arcs are exact, three points have no third derivative, a parabola is smooth."""
    cone = {"to_mm": 62, "diameter_mm": 91.7}
    with pytest.raises(ValidationError, match="only points are smoothed"):
        part_of(START | {"smooth_um": 1, "segment": [cone]})
    few = {"height_mm": [0, 31, 62], "diameter_mm": [91, 92, 91.5], "smooth_um": 1}
    with pytest.raises(ValidationError, match="changes nothing with 3 points, it needs 4"):
        Profile.model_validate(few)
    parabola = (92 - 1e-4 * (Z_MM - 25) ** 2).tolist()
    found = smoothing_facts(part_of(listed(smooth_um=0.5, diameter_mm=parabola)).piston)
    [line] = smoothing_texts(found, {}, 5.0)
    assert line.endswith("within 0.5 um: nothing changes, because its points are smooth already")


def bent(form_error_um: float) -> SkirtPart:
    """Return a part whose profile has a point that is 20 um off a barrel."""
    diameter_mm = barrel(Z_MM)[0]
    diameter_mm[30] += 0.02
    profile = {"interpolation": "linear", "height_mm": Z_MM.tolist(), "smooth_um": 40}
    part = part_of(profile | {"diameter_mm": diameter_mm.tolist()})
    return changed(part, {"process.form_error_um": form_error_um})


def test_smoothing_beyond_the_form_error_is_refused() -> None:
    """Half of a diameter's residual counts, with the number that would do."""
    line = refused(lambda: make_geometry(bent(5.0)), GeometryError)
    found = re.search(r"smooth_um: .*by up to ([0-9.]+) um, .* above ([0-9.]+)$", line)
    assert line.startswith("piston.profile.smooth_um: ") and found is not None
    taken_um, least_um = map(float, found.groups())
    assert 8 < taken_um <= 20 and taken_um <= least_um
    enough = bent(least_um + 0.1)
    make_geometry(enough)
    assert smoothing_takes_um(enough) == pytest.approx(taken_um, rel=0.01)


def test_tolerances_of_the_sheets_are_reduced() -> None:
    """A diameter by the whole residual, the form of a line by the same, no phase."""
    part = bent(100.0)
    stated = ZonedTolerances(diameter_um=50, straightness_um=1, phase_deg=1)
    left = tolerances_left(part.model_copy(update={"tolerances": stated}))
    taken_um = 2 * smoothing_takes_um(part)
    assert left.diameter_um == pytest.approx(50 - taken_um)
    assert (left.straightness_um, left.phase_deg, left.ovality_um) == (0, 1, None)


def test_rounded_profile_is_warned_about() -> None:
    """The warning names a band that lowers the bend; a band that raises it is warned about."""
    noise = noise_facts(part_of(listed()).piston)
    assert set(noise) == {"profile"} and 0.2 < noise["profile"]["smooth_um"] < 2.5
    [line] = smoothing_texts({}, noise, 5.0)
    assert line.startswith("warning: the profile is noisy or rounded coarsely: piston.profile.")
    assert noise_facts(example_part().piston) == {}
    risen = noise["profile"] | {"bend_per_mm": {"before": 0.001, "after": 0.002}}
    told = smoothing_texts({"profile": risen}, {}, 5.0)
    assert told[1].startswith("warning: smoothing raises the largest second derivative")


LAW = ROOT / "tools" / "parts" / "perkins240_law.toml"


@pytest.fixture(scope="module")
def law() -> SkirtPart:
    """Load the part of the repository that is drawn by formula."""
    return load_part(LAW)


@pytest.mark.parametrize(
    ("exponent", "peak_mm", "drop_mm"),
    [(2.0, 20.0, 0.13), (3.0, 20.0, 0.13), (2.2, 31.0, 0.3), (2.5, -7.0, 0.2), (4.0, 62.0, 1.0)],
)
def test_pieces_are_the_formula(
    law: SkirtPart, exponent: float, peak_mm: float, drop_mm: float
) -> None:
    """Everywhere within LAW_ERROR_MM, and the slope is the formula's derivative."""
    far = max(abs(62 - peak_mm), abs(peak_mm))
    k = drop_mm / far**exponent
    profile = {"exponent": exponent, "peak_height_mm": peak_mm, "coefficient": k}
    values = {f"piston.profile.{name}": value for name, value in profile.items()}
    geometry = make_geometry(changed(law, values))
    z = np.linspace(0, 62, 20_001)
    off = np.abs(z - peak_mm)
    a = 46 - k * off**exponent
    assert np.abs(geometry.radius_mm(z) - a).max() <= LAW_ERROR_MM * 1.001
    slope = -k * exponent * np.sign(z - peak_mm) * off ** (exponent - 1)
    assert np.abs(geometry.radius_mm(z, 1) - slope).max() <= 1e-7


def test_part_by_formula_is_the_papers(law: SkirtPart) -> None:
    """The known facts: 92 mm at 20, 91.737 at 62, ovality 0.2 at 20 and 0.3 at 62; or round.

    An exponent that no cubic has makes a table within a nanometre as well.
    """
    geometry = make_geometry(law)
    assert 2 * float(geometry.radius_mm(20.0)) == pytest.approx(92.0, abs=1e-12)
    assert 2 * float(geometry.radius_mm(62.0)) == pytest.approx(91.737, abs=2e-6)
    assert geometry.ovality_mm([20.0, 62.0]) == pytest.approx([0.2, 0.3], abs=2e-8)
    round_one = make_geometry(changed(law, {"piston.ovality.is_oval": False}))
    assert float(np.abs(round_one.delta(np.linspace(0, 6, 50), 30.0).delta).max()) == 0.0
    values = {"piston.profile.exponent": 2.3, "piston.profile.coefficient": 2.4e-5}
    made = generate(changed(law, values))
    assert made.accuracy_x.value_nm <= 1.0
