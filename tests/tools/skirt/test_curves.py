"""Profiles and ovalities between the drawing's points: bounds, circles and points, no splines.

What is compared with is the drawing itself: its points, the interval between two of them, the
equation of its circles in extended precision.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from camtools.base.errors import GeometryError
from camtools.ngc.profile_program import segments
from camtools.pipeline.make_table import Made
from camtools.skirt.geometry.profile import notable_overshoots, profile_pieces, profile_spline
from camtools.skirt.geometry.skirt_geometry import make_geometry
from camtools.skirt.kind import KIND
from camtools.skirt.part.part_file import SkirtPart, example_part
from camtools.skirt.part.profile_keys import Profile
from camtools.skirt.report.summary import make_summary
from camtools.skirt.report.summary_text import emit_text
from camtools.skirt.table.generate import generate
from camtools.skirt.table.search import UnreachableError
from tests.tools.cases.camsim_cases import camsim, columns_of

# the conical end of a drawing
HEIGHTS = [0.0, 2, 10, 20, 30, 40, 50, 62]
DIAMETERS = [91.0, 91.95, 91.985, 92, 91.985, 91.94, 91.866, 91.737]
CONE = {"to_mm": 2, "diameter_mm": 91.95}
BARREL = {"to_mm": 62, "diameter_mm": 91.737, "kind": "arc", "radius_mm": 3300}
START = {"interpolation": "segments", "height_mm": [0], "diameter_mm": [91]}


def part_of(profile: dict[str, Any], **piston: object) -> SkirtPart:
    """Return the example with another profile."""
    tree = example_part().model_dump()
    tree["piston"] |= {"profile": profile} | piston
    return SkirtPart.model_validate(tree)


def drawn(**keys: object) -> dict[str, Any]:
    """Return the profile of the conical end."""
    return {"height_mm": HEIGHTS, "diameter_mm": DIAMETERS} | keys


def cut_radii(part: SkirtPart, folder: Path) -> tuple[np.ndarray, np.ndarray, dict[str, Any]]:
    """Cut a part on the simulator; return heights, tip radii on the long axis and the summary."""
    made = Made(KIND, KIND.make(part))
    for file, data in made.files(with_plots=False).items():
        (folder / file).write_bytes(data)
    results = ["--surface", str(folder / "s.csv"), "--summary", str(folder / "s.json")]
    done = camsim("run", folder / "example.camtab", *results)
    assert done.returncode == 0, done.stderr
    table = columns_of(folder / "s.csv")
    on_axis = table["turn"] % 0.5 < 1 / 720
    z_mm, radius_mm = (table[key][on_axis] for key in ("z_mm", "radius_mm"))
    return z_mm, radius_mm, json.loads((folder / "s.json").read_text())


def test_a_spline_over_a_conical_end_is_refused() -> None:
    """It would rise to 92.406 mm at 5.15 mm of height, 421 um above both of its points there."""
    with pytest.raises(GeometryError) as info:
        make_geometry(part_of(drawn()))
    assert str(info.value) == (
        "piston.profile.interpolation: between the points at 2 and 10 mm the diameter goes "
        '421.4 um beyond both, at height 5.14965 mm; set interpolation = "pchip", or give more '
        "points there, or allow it: overshoot_um = 430"
    )


def test_what_was_allowed_is_told() -> None:
    """Table and report name what a curve does between its points, once it is more than usual."""
    part = part_of(drawn(overshoot_um=900))
    told = "between the points at 2 and 10 mm the diameter goes 421.4 um beyond both"
    assert told in emit_text(make_summary(generate(part)))
    assert notable_overshoots(part.piston)[0].startswith(told)
    assert notable_overshoots(part_of(drawn(interpolation="pchip")).piston) == []


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


def test_the_remedy_of_the_refusal_works() -> None:
    """What the message names is accepted: more is allowed, or the curve is another one."""
    make_geometry(part_of(drawn(overshoot_um=430)))
    for interpolation in ("pchip", "akima", "linear"):
        make_geometry(part_of(drawn(interpolation=interpolation)))


def test_a_spline_of_ovality_is_refused_likewise() -> None:
    """Ovality falls by 14 um below both its points, which the table's unit counts."""
    ovality = {"height_mm": [0, 20, 25, 62], "ovality_mm": [0.2, 0.2, 0.3, 0.3]}
    with pytest.raises(GeometryError, match=r"piston\.ovality\.interpolation: between the points"):
        make_geometry(
            part_of(drawn(interpolation="pchip"), ovality=ovality | {"interpolation": "spline"})
        )
    make_geometry(
        part_of(drawn(interpolation="pchip"), ovality=ovality | {"interpolation": "pchip"})
    )


def test_a_conical_end_is_cut_within_its_points(tmp_path: Path) -> None:
    """With pchip the cut lies between the diameters of the two points around it, to 0.1 um."""
    z_mm, radius_mm, summary = cut_radii(part_of(drawn(interpolation="pchip")), tmp_path)
    i = np.clip(np.searchsorted(HEIGHTS, z_mm) - 1, 0, len(HEIGHTS) - 2)
    low, high = np.sort(np.array([np.array(DIAMETERS)[i], np.array(DIAMETERS)[i + 1]]) / 2, axis=0)
    reduction_mm = np.zeros_like(z_mm)  # on the long axis, to a 720th of a turn
    reduction_mm += 0.15 * np.sin(2 * np.pi / 720) ** 2
    assert (radius_mm >= low - reduction_mm - 1e-4).all()
    assert (radius_mm <= high + 1e-4).all()
    assert summary["is_good"]
    assert summary["form_error_um"]["max"] < 0.2


@given(
    drops=st.lists(st.floats(0, 0.4), min_size=3, max_size=7),
    steps=st.lists(st.floats(0.5, 30), min_size=6, max_size=6),
)
@settings(max_examples=50, derandomize=True, deadline=None)
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
    radius = np.longdouble(profile_pieces(profile)[index].radius_mm)
    half2 = ((z1 - z0) ** 2 + (r1 - r0) ** 2) / 4
    away = np.sqrt(radius**2 - half2) / np.sqrt(4 * half2) * np.sign(radius)
    centre = (z0 + z1) / 2 + (r1 - r0) * away, (r0 + r1) / 2 - (z1 - z0) * away
    z = np.linspace(profile.height_mm[index], profile.height_mm[index + 1], 20_001)
    exact = centre[1] + np.sign(radius) * np.sqrt(radius**2 - (z - centre[0]) ** 2)
    return float(np.abs(profile_spline(profile)(z) - exact).max() * 1e6)


def test_arcs_are_circles_to_a_ten_thousandth_of_a_nanometre() -> None:
    """Barrel of 3.3 m, hollow of 50 mm, and a rounding of 1 mm on which the slope reaches 0.7."""
    barrel = Profile.model_validate(START | {"segment": [CONE, BARREL]})
    assert off_circle_nm(barrel, 1) < 1e-4
    hollow = {"to_mm": 12, "diameter_mm": 92.5, "kind": "arc", "radius_mm": -50}
    assert off_circle_nm(Profile.model_validate(START | {"segment": [CONE, hollow]}), 1) < 1e-4
    small = {"to_mm": 1.414, "diameter_mm": 91, "kind": "arc", "radius_mm": 1.0}
    assert off_circle_nm(Profile.model_validate(START | {"segment": [small]}), 0) < 1e-4


@given(
    radius_mm=st.floats(30, 1e5),
    width_mm=st.floats(1, 40),
    rise_mm=st.floats(-1, 1),
    is_hollow=st.booleans(),
)
@settings(max_examples=60, derandomize=True, deadline=None)
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
    piece = profile_pieces(profile)[1]
    assert piece.radius_mm == pytest.approx(radius, rel=1e-9)
    assert piece.kink_deg == pytest.approx(0, abs=1e-9)
    assert off_circle_nm(profile, 1) < 1e-4
    stated = Profile.model_validate(start | {"segment": [line, arc | {"radius_mm": 4000}]})
    assert profile_pieces(stated)[1].kink_deg == pytest.approx(0, abs=1e-9)


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
    """A derived arc far beyond both its ends is refused until the radius is stated."""
    line = {"to_mm": 10, "diameter_mm": 91.5}
    arc = {"to_mm": 62, "diameter_mm": 91.5, "kind": "arc", "tangent": True}
    with pytest.raises(GeometryError, match=r"segment\.1\.tangent.*radius 1040.32 mm.*give its"):
        make_geometry(part_of(START | {"segment": [line, arc]}))
    stated = arc | {"radius_mm": 1040.325, "tangent": True}
    make_geometry(part_of(START | {"segment": [line, stated]}))


def test_cone_and_barrel_are_cut_on_their_circle(tmp_path: Path) -> None:
    """Away from the corner the cut lies on the drawing's line and circle to 0.2 um."""
    z_mm, radius_mm, summary = cut_radii(part_of(START | {"segment": [CONE, BARREL]}), tmp_path)
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
    assert summary["is_good"]


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


def test_program_turns_at_the_corner_of_the_profile() -> None:
    """X in G33 has a point at the corner, and needs few segments: the arc's and the cone's."""
    geometry = make_geometry(part_of(START | {"segment": [CONE, BARREL]}))
    chords = segments(geometry, 0.0, 62.0, 0.0001)
    i = int(np.argmin(np.abs(chords.z_mm - 2)))
    assert chords.z_mm[i] == 2.0
    assert chords.x_mm[i] == pytest.approx(91.95 / 2, abs=1e-9)
    assert chords.z_mm.size < 60


def test_radii_that_were_worked_out_are_told() -> None:
    """Report and terminal name each segment with its radius, derived or given."""
    line = {"to_mm": 10, "diameter_mm": 91.5}
    arc = {"to_mm": 62, "diameter_mm": 91.5, "kind": "arc", "tangent": True}
    profile = START | {"segment": [line, arc], "overshoot_um": 700}
    summary = KIND.summary(KIND.make(part_of(profile)))
    told = summary["segments"]["profile"]
    assert told[0]["radius_mm"] is None
    assert told[1]["radius_mm"] == pytest.approx(26 / np.sin(np.arctan(0.025)), rel=1e-9)
    assert told[1]["kink_deg"] == pytest.approx(0, abs=1e-9)
    text = "profile: line to 10 mm, 91.5 mm; arc of 1040.32 mm to 62 mm, 91.5 mm"
    assert text in KIND.text(summary)
