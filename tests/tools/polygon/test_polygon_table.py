"""Tables of polygons: the firmware's evaluation, the cut, what is refused."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError
from camtools.cli.mktables import main as mktables
from camtools.cli.run import main as run
from camtools.pipeline.load import load, parse
from camtools.pipeline.make_table import make
from camtools.polygon.blend import bend_of, blended
from camtools.polygon.generate import GeneratedPolygon, generate_polygon
from camtools.polygon.outline import measures_of
from camtools.polygon.part import PolygonPart
from camtools.polygon.plots import draw_motion
from camtools.polygon.shapes import p3g
from camtools.table.image import pack
from tests.tools.cases import polygon_cases as cases
from tests.tools.cases.camsim_cases import camsim, columns_of
from tests.tools.cases.part_cases import ROOT

PARTS = ROOT / "tools" / "parts"
NAMES = ("p3g-25", "p4c-35", "hexagon")
HEAD = '[part]\nname = "a"\nkind = "polygon"\nsource = "s"\n[polygon]\n'
TAIL = """\
[process]
spindle_rpm = 100
feed_mm = 0.2
[tool]
clearance_deg = 45
[machine.limits]
u_stroke_mm = 12
"""


def radius_of(name: str, phi: cases.Floats) -> cases.Floats:
    """Return the radius of an example's drawing by another method."""
    if name == "p3g-25":
        return cases.p3g_mm(phi, 25.0, 0.8)
    if name == "p4c-35":
        return cases.p4c_mm(phi, 35.0, 30.0, 5.0)
    return cases.rounded_mm(phi, cases.regular_corners(6, 20.0), 1.0)


def surface_of(folder: Path) -> tuple[cases.Floats, cases.Floats, cases.Floats]:
    """Return turn, radius [mm] and error [nm] of the surface that was cut."""
    table = columns_of(folder / "surface.csv")
    return table["turn"], table["radius_mm"], table["error_nm"]


def cut(path: Path, folder: Path, *words: str) -> tuple[int, dict[str, Any]]:
    """Cut a part as tools/run does, without its report; return exit status and summary."""
    made = make(load(path), path)
    folder.mkdir(exist_ok=True)
    for name, data in made.files(with_plots=False).items():
        (folder / name).write_bytes(data)
    part = made.table.part
    (folder / "machine.toml").write_text(made.kind.machine(part))
    tolerance = ("--tolerance-um", repr(made.kind.form_error_um(part)))
    done = camsim(
        "run", folder / f"{part.part.name}.camtab", "--machine", folder / "machine.toml",
        *("--surface", folder / "surface.csv", "--summary", folder / "summary.json"),
        *(*tolerance, *words),
    )  # fmt: skip
    summary: dict[str, Any] = json.loads((folder / "summary.json").read_text())
    return done.returncode, summary


def part_of(polygon: str, tail: str = TAIL) -> PolygonPart:
    """Return the part of the lines of [polygon]."""
    part = parse((HEAD + polygon + tail).encode(), "a.toml").part
    assert isinstance(part, PolygonPart)
    return part


@pytest.fixture(scope="module", params=NAMES)
def made(request: pytest.FixtureRequest) -> GeneratedPolygon:
    """Make the table of an example."""
    return generate_polygon(load(PARTS / f"{request.param}.toml").part)


def test_firmware_plays_the_drawing(made: GeneratedPolygon, tmp_path: Path) -> None:
    """Tip = x - u of the firmware is the drawing's radius, off by the table and by the blends."""
    name = made.part.part.name
    (tmp_path / "a.camtab").write_bytes(pack(made.table))
    rng = np.random.default_rng(3271)
    low, high = made.part.polygon.z_mm
    turn, z = rng.uniform(-3, 3, 400), rng.uniform(low, high, 400)
    rows = "".join(f"{a!r},{b!r}\n" for a, b in zip(turn.tolist(), z.tolist(), strict=True))
    done = camsim("eval", tmp_path / "a.camtab", stdin=f"turn,z_mm\n{rows}")
    assert done.returncode == 0, done.stderr
    got = np.array([[float(word) for word in line.split(",")] for line in done.stdout.split()[1:]])
    off_um = (got[:, 5] - got[:, 2]) / 1e3 - 1e3 * radius_of(name, 2 * np.pi * (turn % 1))
    near = np.zeros(turn.size, dtype=bool)
    for blend in made.blended.blends:
        away = np.mod(2 * np.pi * turn - blend.joint_rad + np.pi, 2 * np.pi) - np.pi
        near |= np.abs(away) <= blend.half_rad
    assert np.abs(off_um[~near]).max() < 1.2e-3
    assert np.abs(off_um).max() <= made.blended.deviation_um + 1.2e-3


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(
    ("name", "feed_mm"), [("p3g-25", "2"), ("p4c-35", "0.2"), ("hexagon", "2")]
)
def test_cut_surface_is_the_drawing(name: str, feed_mm: str, tmp_path: Path) -> None:
    """The radius that the simulator cut is the drawing's, off by what the verdict says.

    The cut with the fine feed is longer than its trace.
    """
    assert run([str(PARTS / f"{name}.toml"), "--feed", feed_mm, "-o", str(tmp_path)]) == 0
    turn, radius, error_nm = surface_of(tmp_path)
    some = np.random.default_rng(1).choice(turn.size, 300, replace=False)
    own_um = 1e3 * (radius[some] - radius_of(name, 2 * np.pi * turn[some]))
    summary: dict[str, Any] = json.loads((tmp_path / "summary.json").read_text())
    assert np.abs(own_um - error_nm[some] / 1e3).max() < 4e-3  # turn has 7 digits
    assert np.abs(own_um).max() <= summary["form_error_um"]["max"] + 4e-3
    page = (tmp_path / "report.html").read_text()
    assert "inner circle" in page and "WITHIN TOLERANCE" in page


def test_verdict_is_against_the_drawing(tmp_path: Path) -> None:
    """A blend beyond the tolerance makes a bad part, however well the controller plays it."""
    text = (PARTS / "p4c-35.toml").read_text()
    path = tmp_path / "p.toml"
    path.write_text(text.replace("form_error_um = 15.0", "form_error_um = 5.0"))
    status, summary = cut(path, tmp_path, "--feed", "2")
    assert status == 1
    assert summary["form_error_um"]["max"] == pytest.approx(12.0, abs=0.2)
    assert not summary["is_good"]


def test_table_is_judged_by_the_joints(made: GeneratedPolygon) -> None:
    """The header promises at least the acceleration that dense samples of the blends show."""
    bounds = made.table.bounds
    assert bounds.u2_peak_nm_per_rad2 >= 1e6 * bend_of(made.blended) * (1 - 1e-6)
    assert bounds.u2_peak_nm_per_rad2 <= 1e6 * bend_of(made.blended) * 1.01
    assert made.accuracy_u.value_nm <= 1.0
    assert max(made.accuracy_u.first_share, made.accuracy_u.second_share) <= 1e-3


def test_taper_makes_all_sections_alike() -> None:
    """The outer circle grows by taper x length, the inner one in proportion."""
    lines = "sides = 5\nacross_flats_mm = 20\ncorner_radius_mm = 2\nz_mm = [0, 20]\ntaper = 0.05\n"
    made = generate_polygon(part_of('form = "regular"\n' + lines))
    phi = np.linspace(0, 6, 50)
    first, last = (
        made.geometry.radius_mm(z) - made.geometry.delta(phi, z).delta for z in (0.0, 20.0)
    )
    grown = 2 * float(made.geometry.radius_mm(20.0) - made.geometry.radius_mm(0.0))
    assert grown == pytest.approx(1.0, abs=1e-12)
    assert np.ptp(last / first) < 1e-12
    assert made.deviation_um <= 2.0 * (1 + 1e-6) < 1.05 * made.blended.deviation_um * last[0]


def test_too_sharp_names_the_blend_that_would_do(tmp_path: Path) -> None:
    """With the advised blend the part is accepted; with a little less it is not."""
    lines = 'form = "p4c"\nsize_mm = 35\nz_mm = [0, 20]\nblend_um = {}\n'
    tail = TAIL.replace("100\n", "200\n") + "u_acceleration_mm_s2 = 400000\nu_speed_mm_s = 800\n"
    with pytest.raises(CamtoolsError) as info:
        generate_polygon(part_of(lines.format(8.0), tail))
    *_, line = info.value.lines
    assert line.startswith("polygon.blend_um = 8: at this speed ")
    least = float(line.split("speed ")[1].split(" would")[0])
    generate_polygon(part_of(lines.format(least), tail))
    with pytest.raises(CamtoolsError, match="u_acceleration_mm_s2"):
        generate_polygon(part_of(lines.format(0.95 * least), tail))


def test_corner_that_no_blend_helps() -> None:
    """The arc of the corner itself needs more than there is."""
    lines = (
        'form = "regular"\nsides = 6\nacross_flats_mm = 20\ncorner_radius_mm = 0.2\nz_mm = [0, 9]\n'
    )
    with pytest.raises(CamtoolsError, match="no blend helps"):
        generate_polygon(part_of(lines, TAIL + "u_acceleration_mm_s2 = 1000\n"))


P3G = 'form = "p3g"\nz_mm = [0, 9]\n'
WRONG = [
    (P3G + "size_mm = 26\n", "polygon.size_mm = 26: no nominal size of p3g; use one of 14, 16"),
    (P3G + "mean_diameter_mm = 25\n", "polygon.eccentricity_mm: is missing for form"),
    (P3G + "size_mm = 25\neccentricity_mm = 1\n", "polygon.eccentricity_mm = 1: contradicts"),
    (P3G + "size_mm = 25\nsides = 3\n", "polygon.sides = 3: sides has no meaning"),
    ('form = "hexagon"\nz_mm = [0, 9]\n', "polygon.form = 'hexagon'"),
    (P3G.replace("[0, 9]", "[9, 0]") + "size_mm = 25\n", "polygon.z_mm"),
    (P3G + "size_mm = 25\nblend_um = 0\n", "polygon.blend_um = 0: "),
    (
        'form = "corners"\nz_mm = [0, 9]\ncorners_mm = [[9, 0], [0, 9], [-9, -9]]\n'
        "corner_radius_mm = [1, 1, 1, 1]\n",
        "polygon.corner_radius_mm = [1.0, 1.0, 1.0, 1.0]: has 4 entries, corners_mm has 3",
    ),
    (P3G + "size_mm = 25\ntaper = -3\n", "polygon.taper = -3: "),
]


@pytest.mark.parametrize(("lines", "message"), WRONG, ids=[message for _, message in WRONG])
def test_wrong_part_files(
    lines: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """One line with file, field, value and remedy, exit status 2, nothing written."""
    path = tmp_path / "a.toml"
    path.write_text(HEAD + lines + TAIL)
    assert mktables([str(path), "-o", str(tmp_path / "out")]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert f"a.toml: {message}" in line and "; " in line
    assert not (tmp_path / "out").exists()


def test_blends_of_repeated_sides_are_alike() -> None:
    """The pattern repeats exactly: all blends have the width of the first side's."""
    made = generate_polygon(load(PARTS / "hexagon.toml").part)
    assert len({blend.half_rad for blend in made.blended.blends}) == 1
    assert blended(made.drawing, 2.0).outline.repeat == 6


@pytest.mark.parametrize("direction", [1, -1])
def test_both_senses_cut_the_drawing(direction: int, tmp_path: Path) -> None:
    """Four sides without symmetry, turned with M3 and with M4, are those of the drawing."""
    corners = [[9.0, -9.0], [9.0, 8.0], [-9.0, 7.0], [-7.0, -8.0]]
    lines = f'form = "corners"\nz_mm = [0, 4]\ncorner_radius_mm = 4\ncorners_mm = {corners}\n'
    tail = TAIL.replace("100\n", f"100\ndirection = {direction}\n").replace("12\n", "20\n")
    path = tmp_path / "a.toml"
    path.write_text(HEAD + lines + tail)
    assert cut(path, tmp_path)[0] == 0
    turn, radius, _ = surface_of(tmp_path)
    some = np.random.default_rng(1).choice(turn.size, 500, replace=False)
    drawn = cases.rounded_mm(2 * np.pi * turn[some], np.array(corners), 4.0)
    assert np.abs(radius[some] - drawn).max() < 2.5e-3


def test_area_and_inch_sizes() -> None:
    """A = pi dm^2 / 4 - 4 pi e^2; Stoffel prints 1.330 and 1.170 for 1.250 and 0.040 inches."""
    e, dm = 0.04 * 25.4, 1.25 * 25.4
    measures = measures_of(p3g(dm, e, 0.0))
    assert measures.area_mm2 == pytest.approx(np.pi * dm**2 / 4 - 4 * np.pi * e**2, rel=1e-9)
    assert measures.outer_circle_mm == pytest.approx(1.330 * 25.4, abs=1e-9)
    assert measures.inner_circle_mm == pytest.approx(1.170 * 25.4, abs=1e-9)


def test_about_the_mean_with_run_in(tmp_path: Path) -> None:
    """U needs half of the travel, the tool enters and leaves through the air, the part is good."""
    text = (PARTS / "p3g-25.toml").read_text()
    text = text.replace("u_stroke_mm = 8", "u_stroke_mm = 2").replace("[0, 30]", "[0, 4]")
    path = tmp_path / "a.toml"
    path.write_text(text)
    with pytest.raises(CamtoolsError, match=r'process\.u_zero = "mean", which needs 1\.6'):
        generate_polygon(load(path).part)
    more = 'u_zero = "mean"\nrun_in_mm = 1.5\nrun_out_mm = 1.0\n[machine.limits]'
    path.write_text(text.replace("[machine.limits]", more))
    assert cut(path, tmp_path)[0] == 0
    turn, radius, _ = surface_of(tmp_path)
    some = np.random.default_rng(2).choice(turn.size, 200, replace=False)
    drawn = radius_of("p3g-25", 2 * np.pi * turn[some])
    assert np.abs(radius[some] - drawn).max() < 2e-4


STRONG = TAIL + "u_acceleration_mm_s2 = 1e8\nu_speed_mm_s = 10000\n"
NEVER = [
    (
        'form = "p4c"\nsize_mm = 35\nz_mm = [0, 20]\n',
        r"blend_um = 2: U would need 6\d{3}\.\d+ mm/rad2, a table holds 2147\.48; allow 6\.",
    ),
    (
        'form = "regular"\nsides = 6\nacross_flats_mm = 20\nz_mm = [0, 20]\nblend_um = 9\n',
        r"polygon\.blend_um = 9: U would need .* allow 1\d\.\d+ um",
    ),
    (
        'form = "regular"\nsides = 14\nacross_flats_mm = 5.29\ncorner_radius_mm = 2.55\n'
        "z_mm = [0, 20]\n",
        "is allowed; give larger corner radii",
    ),
    (
        'form = "p3g"\nmean_diameter_mm = 900\neccentricity_mm = 18\nz_mm = [0, 20]\n',
        "u: its travel to one side comes to 36.0001 mm, a table holds 16.7772; give",
    ),
]


@pytest.mark.parametrize(("lines", "message"), NEVER, ids=["p4c", "sharp", "arcs", "large"])
def test_what_no_table_holds(lines: str, message: str) -> None:
    """Refused with numbers and remedy, where the image would not take it or the firmware refuse."""
    with pytest.raises(CamtoolsError, match=message):
        generate_polygon(part_of(lines, STRONG))


def test_advised_blend_makes_a_table(tmp_path: Path) -> None:
    """What the refusal of P4C 35 advises is taken, and the firmware takes the table."""
    lines = 'form = "p4c"\nsize_mm = 35\nz_mm = [0, 20]\nblend_um = {}\n'
    with pytest.raises(CamtoolsError) as info:
        generate_polygon(part_of(lines.format(2), STRONG))
    least = float(info.value.lines[0].split("allow ")[1].split(" um")[0])
    made = generate_polygon(part_of(lines.format(least), STRONG))
    (tmp_path / "a.camtab").write_bytes(pack(made.table))
    done = camsim("eval", tmp_path / "a.camtab", stdin="turn,z_mm\n0.1,5\n")
    assert done.returncode == 0, done.stderr


def test_passes(tmp_path: Path) -> None:
    """Roughing and finishing of a hexagon in one run; the last pass is the drawing."""
    text = (PARTS / "hexagon.toml").read_text().replace("[0, 15]", "[0, 3]")
    more = (
        "[[process.pass]]\nallowance_um = 40\nfeed_mm = 0.2\n"
        "[[process.pass]]\nallowance_um = 0\n[machine.limits]"
    )
    path = tmp_path / "a.toml"
    path.write_text(text.replace("[machine.limits]", more))
    status, summary = cut(path, tmp_path)
    assert status == 0
    assert [one["allowance_um"] for one in summary["passes"]] == [40, 0]
    assert summary["form_error_um"]["max"] < 2.0
    weak = more.replace("= 0.2", "= 2") + "\nz_speed_mm_s = 5"
    path.write_text(text.replace("[machine.limits]", weak))
    with pytest.raises(CamtoolsError, match=r"^process\.pass number 1: machine\.limits\.z_speed"):
        generate_polygon(load(path).part)


def test_motion_about_the_mean_is_drawn_from_there(tmp_path: Path) -> None:
    """U of the picture is the reduction less its middle, as the trace has it."""
    text = (PARTS / "p3g-25.toml").read_text().replace("[0, 30]", "[0, 2]")
    path = tmp_path / "a.toml"
    path.write_text(text.replace("[machine.limits]", 'u_zero = "mean"\n[machine.limits]'))
    loaded = load(path)
    made = loaded.kind.make(loaded.part)
    assert made.middle_nm == 800_000
    [line] = draw_motion(made).axes[0].lines
    degrees, u_mm = (np.asarray(one) for one in line.get_data())
    drawn = 12.5 + 0.8 - cases.p3g_mm(np.radians(degrees), 25.0, 0.8)
    np.testing.assert_allclose(u_mm, drawn - 0.8, atol=1e-6)


def test_the_manual_has_the_numbers(made: GeneratedPolygon) -> None:
    """The list of examples says what is made of them."""
    lines = (ROOT / "tools" / "docs" / "POLYGONS.md").read_text().splitlines()
    name = made.part.part.name
    [line] = [one for one in lines if one.startswith(f"| `{name}.toml` |")]
    off_um, rpm = line.split(" | ")[2:]
    assert float(off_um) == pytest.approx(made.deviation_um, abs=0.005)
    assert float(rpm.strip(" |")) == pytest.approx(made.highest_speed.rpm, abs=0.5)
    assert made.highest_speed.decides == "u_acceleration_mm_s2"
