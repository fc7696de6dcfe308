"""Skirts that are drawn hot or coated, against rings of the textbook: dr = alpha dT r."""

import json
from pathlib import Path

import numpy as np
import pytest

from camtools.cut.correction import N_NODES, Correction
from camtools.skirt.geometry.run_in import corrected
from camtools.skirt.geometry.skirt_geometry import make_geometry
from camtools.skirt.kind import KIND
from camtools.skirt.part.part_file import SkirtPart
from camtools.skirt.report.plots import draw_clearance
from camtools.table.image import pack
from tests.tools.cases.cut_cases import PARTS, cut_made, evaluated, made_skirt, skirt_of, tip_mm
from tests.tools.cases.part_cases import changed, load_part, oval_text, parse_part, refused

ALPHA = 21e-6
COSINE = '[piston.section]\nshape = "cosine"\n'
HOT = f"""[piston.growth]
drawn = "hot"
height_mm = [0, 6]
expansion_per_k = {ALPHA}
temperature_c = [120, 120]
"""
COLD = HOT.replace('"hot"', '"cold"')
PIN = "pin_temperature_c = [140, 140]\n"
PIN_260 = PIN.replace("140", "260")
COATED = "[piston.coating]\nthickness_um = 15\n"
ZONES = "[piston.coating]\nheight_mm = [1, 2, 4, 5]\nthickness_um = [0, 15, 15, 5]\n"
BORE = "[piston.bore]\ndiameter_mm = 92.04\n"


def ring_text(more: str, oval: float = 0.0) -> str:
    """Return the part file of a cylinder of 92 mm, or of an oval one, with tables."""
    return oval_text("ring", (6, 92), [oval, oval], "feed_mm = 0.1", COSINE + more)


def ring(more: str, oval: float = 0.0) -> SkirtPart:
    """Return a cylinder of 92 mm, or an oval one, with tables."""
    return parse_part(ring_text(more, oval), "ring.toml")


def test_table_and_gauge_have_the_cold_shape(tmp_path: Path) -> None:
    """As the firmware plays it: 20 to 120 degrees along the thrust, 140 along the pin, coated.

    The simulator's own radius of the drawing is that of the cold, bare oval, too.
    """
    made = made_skirt(ring(HOT + PIN + COATED, oval=0.2))
    rows = cut_made(made, tmp_path, tables=("surface",)).surface
    judged = rows["radius_mm"] - 1e-6 * rows["error_nm"]
    turn = np.array([0.0, 0.125, 0.25, 0.5, 0.75])
    played = tip_mm(evaluated(tmp_path, made.table.table, turn, np.full(5, 3.1)))
    for turns, found, most in ((turn, played, 2e-6), (rows["turn"], judged, 3e-6)):
        pin = np.sin(2 * np.pi * turns) ** 2
        expected = (46 - 0.1 * pin) / (1 + ALPHA * (100 + 20 * pin)) - 0.015
        assert found == pytest.approx(expected, abs=most)


WARM = {  # at the ends and in the middle
    "drawn": "hot",
    "expansion_per_k": ALPHA,
    "temperature_c": [110, 130, 180],
    "pin_temperature_c": [115, 150, 200],
    "antithrust_temperature_c": [100, 120, 160],
}


@pytest.mark.parametrize(
    ("name", "thrust_deg"),
    [("perkins240", 0), ("thrust90", 0), ("16v240zj", 0), ("scan90", 0), ("long-axis", 90)],
)
def test_growth_of_every_section(name: str, thrust_deg: int) -> None:
    """Each point of any section is that of a ring of its temperature."""
    part = load_part(PARTS / f"{'thrust90' if thrust_deg else name}.toml")
    if thrust_deg:
        more = {"meet": "long-axis", "ovality_mm": [0.2, 0.25, 0.3]}
        part = changed(part, {f"piston.antithrust.{key}": value for key, value in more.items()})
    heights = np.linspace(part.piston.profile.height_mm[0], part.piston.profile.height_mm[-1], 3)
    growth = WARM | {"height_mm": heights.tolist()}
    hot, cold = make_geometry(part), make_geometry(changed(part, {"piston.growth": growth}))
    for deg, key in ((0, ""), (90, "pin_"), (180, "antithrust_"), (270, "pin_")):
        phi, above_k = np.radians(deg + thrust_deg), np.array(WARM[f"{key}temperature_c"]) - 20
        expected = hot.drawn_mm(phi, heights) / (1 + ALPHA * above_k)
        assert cold.drawn_mm(phi, heights) == pytest.approx(expected, abs=5e-6)


@pytest.mark.parametrize(
    "more",
    [
        HOT.replace(f"{ALPHA}", "0"),
        HOT.replace("120", "20"),
        COLD + PIN,
        HOT.replace("expansion_per_k = 2.1e-05\ntemperature_c", "hot_drop_um")
        + "cold_drop_um = [120, 120]\n",
        COATED.replace("15", "0"),
        COATED + 'drawn = "bare"\n',
        BORE,
    ],
)
def test_nothing_grows(more: str) -> None:
    """No byte of the table changes."""
    plain, fitted = (made_skirt(ring(text, oval=0.2)).table.table for text in ("", more))
    assert pack(fitted) == pack(plain)


def test_measured_growth() -> None:
    """The cold skirt is the hot one less the difference of the profiles."""
    measured = """[piston.growth]
drawn = "hot"
height_mm = [0, 6]
cold_drop_um = [10, 0]
hot_drop_um = [-60, -80]
pin_cold_drop_um = [110, 100]
pin_hot_drop_um = [20, -20]
"""
    cold = make_geometry(ring(measured, oval=0.2))
    z_mm = np.array([0.0, 6.0])
    for deg, radius_mm, growth_um in ((0, 46, [70, 80]), (90, 45.9, [90, 120])):
        found = cold.drawn_mm(np.radians(deg), z_mm)
        assert found == pytest.approx(radius_mm - np.array(growth_um) / 1000, abs=1e-6)


def test_coating_by_zones() -> None:
    """Flat in a zone, monotone and smooth at its edges."""
    radius = make_geometry(ring(ZONES)).radius
    at = np.array([0.0, 1, 1.5, 2, 3, 4, 4.5, 5, 6])
    assert 1000 * (46 - radius(at)) == pytest.approx([0, 0, 7.5, 15, 15, 15, 10, 5, 5], abs=1e-6)
    rise_um = np.diff(-1000 * radius(np.linspace(0.9, 2.1, 1201)))
    assert rise_um.min() >= -1e-9
    assert np.abs(np.diff(rise_um, 2)).max() < 2e-6  # no jump of slope or curvature


@pytest.mark.parametrize(
    ("more", "least"),
    [
        (COATED + BORE, {"cold": (35, 0), "coated": (20, 0)}),
        (HOT + BORE + "temperature_c = 110\n", {"cold": (20 + 96.3976, 0), "hot": (65.5598, 0)}),
        (HOT + PIN_260 + BORE, {"cold": (116.3976, 0), "hot": (20, 0)}),
        (COLD + PIN_260 + BORE, {"cold": (20, 0), "hot": (20 - 181.588, 90)}),
        (
            COLD + "antithrust_temperature_c = [130, 130]\n" + BORE,
            {"cold": (20, 0), "hot": (20 - 106.26, 180)},
        ),
    ],
)
def test_least_clearance(more: str, least: dict[str, tuple[float, float]]) -> None:
    """Radii by hand; a caution in one line where there is none."""
    summary = KIND.summary(made_skirt(ring(more, oval=0.1)).table)
    clearance = json.loads(json.dumps(summary))["fit"]["clearance"]
    found = {name: (place["um"], place["angle_deg"]) for name, place in clearance.items()}
    assert list(found) == list(least)
    for name, (um, deg) in least.items():
        assert found[name] == (pytest.approx(um, abs=0.01), deg)
    tight = [line for line in KIND.text(summary).splitlines() if "larger than the bore" in line]
    assert len(tight) == any(um < 0 for um, _ in least.values())


def test_growth_that_the_waves_cannot_follow_is_refused() -> None:
    """40 K within 0.02 of 6 mm: a step of 19 um of the radius."""
    steep = HOT.replace("[0, 6]", "[0, 3, 3.02, 6]").replace("[120, 120]", "[120, 120, 80, 80]")
    line = refused(lambda: make_geometry(ring(steep)))
    assert "piston.growth: changes too fast near height 3" in line and "0.2 um are allowed" in line


def test_clearance_is_that_of_the_metal() -> None:
    """A pin that is 30 um too large is no caution where a window takes it away."""
    text = COLD + PIN.replace("140", "190") + BORE
    window = "[[piston.window]]\nangle_deg = 90\nwidth_deg = 120\nfrom_mm = -1\nto_mm = 7\n"
    at_30_deg = 120 + (190 - 120) * np.sin(np.radians(30)) ** 2  # beside the window
    for more, hot, most in (("", 190, 0.01), (window + "both_sides = true\n", at_30_deg, 1.0)):
        found = KIND.summary(made_skirt(ring(text + more)).table)["fit"]["clearance"]["hot"]
        assert found["um"] == pytest.approx(20 - 46e3 * ALPHA * (hot - 20), abs=most)


def test_gauged_part_corrects_the_cold_shape() -> None:
    """Growth and correction add up; the cold shape stays what judges."""
    cold = make_geometry(ring(HOT + PIN, oval=0.1))
    off = Correction(
        cold.skirt_mm, {0: np.full(N_NODES, 2e-3 + 0j), 2: np.full(N_NODES, 1e-3 + 0j)}
    )
    played, phi, z_mm = corrected(cold, off), np.array([0.0, 0.7, 2.0]), np.full(3, 2.5)
    more = played.delta(phi, z_mm).delta - cold.delta(phi, z_mm).delta
    assert more == pytest.approx(1e-3 * np.cos(2 * phi), abs=1e-9)
    assert played.drawn_mm(phi, z_mm) == pytest.approx(cold.drawn_mm(phi, z_mm), abs=1e-12)


def test_example_and_its_picture() -> None:
    """The example runs with the clearance of the drawing; its cold profile, too, is drawn."""
    hot = skirt_of("hot92")
    fit = KIND.summary(hot)["fit"]
    bore_mm = 46.025 * (1 + 11e-6 * 90)
    assert fit["clearance"]["hot"]["um"] == pytest.approx(1000 * (bore_mm - 46.05), abs=0.3)
    low_um, high_um = fit["less_than_drawn_um"]  # thrust at the lower end, pin at the upper one
    assert low_um == pytest.approx(46.035e3 * ALPHA * 90 / (1 + ALPHA * 90), abs=0.1)
    assert high_um == pytest.approx(45.915e3 * ALPHA * 166 / (1 + ALPHA * 166), abs=6)
    left, right, *_ = draw_clearance(hot).axes
    assert len(left.lines) == 2 * len(fit["clearance"]) + 1
    assert np.asarray(right.images[0].get_array()).min() == pytest.approx(
        fit["clearance"]["hot"]["um"], abs=0.1
    )
    assert KIND.sections_mm(hot, 0.1) == [0.5, 20.0, 30.0, 40.0, 61.5]


@pytest.mark.parametrize(
    ("more", "place", "remedy"),
    [
        (HOT.replace("[0, 6]", "[1, 6]"), "growth.height_mm", "add points at the ends"),
        (HOT.replace("[120, 120]", "[120]"), "growth.temperature_c", "at least 2"),
        (HOT.replace("temperature", "pin_temperature"), "growth.temperature_c", "add it"),
        (HOT.replace(f"{ALPHA}", "21"), "growth.expansion_per_k", "at most 0.0001"),
        (HOT + "hot_drop_um = [0, 0]\n", "growth.cold_drop_um", "add it"),
        (HOT.partition("expansion")[0], "growth", "give expansion_per_k and temperature_c"),
        (HOT + "hot_drop_um = [0, 0]\ncold_drop_um = [0, 0]\n", "cold_drop_um", "remove one"),
        (COATED.replace("15", "[0, 15]"), "coating.height_mm", "give both"),
        (ZONES.replace("[0, 15, 15, 5]", "[0, 15]"), "thickness_um", "one value for"),
        (ZONES.replace("[1, 2", "[1.9, 2"), "thickness_um", "least 0.5 mm"),
        (BORE + "temperature_c = 110\n", "bore.temperature_c", "add that table"),
        (HOT + "[magnify]\nfactor = 30\n", "magnify", "remove one of them"),
    ],
)
def test_refusals(more: str, place: str, remedy: str) -> None:
    """File, key and remedy are named in one line."""
    line = refused(lambda: ring(more))
    assert line.startswith("ring.toml: piston." if place != "magnify" else "ring.toml: magnify")
    assert place in line.partition("(")[0] + line.partition("=")[0]
    assert remedy in line


@pytest.mark.parametrize(("table", "state"), [(HOT, "cold"), (COATED, "bare")])
def test_imported_points_are_turned_as_they_are(table: str, state: str) -> None:
    """Hot or coated points are refused."""
    head, _, tail = ring_text(table).partition("[piston.ovality]")
    points = COSINE.replace("cosine", "points") + 'csv = "a.csv"\n'
    text = head + points + tail.partition(COSINE)[2]
    line = refused(lambda: parse_part(text, "ring.toml"))
    assert ".drawn" in line and f'set drawn = "{state}"' in line
