"""Rounded lists of lift, smoothed within a band, judged by the laws before rounding."""

import json
import re
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError, GeometryError
from camtools.base.quantities import Floats
from camtools.cli.run import main as run
from camtools.lobe.generate import generate_lobes
from camtools.lobe.kind import KIND
from camtools.lobe.lift import Listed, band_for
from camtools.lobe.motion import make_lobes
from camtools.pipeline.load import Made
from camtools.table.image import pack
from camtools.table.points import PointedTurn
from tests.tools.cases.lobe_cases import QUICK, cam, ground_list
from tests.tools.cases.part_cases import ROOT, refused, refused_lines, sure

PARTS = ROOT / "tools" / "parts"
TURNED = (PARTS / "cam-345.toml").read_text()
GROUND = (PARTS / "cam-345-ground.toml").read_text()
LAW = 'law = "poly345"\nlift_mm = 8\nhalf_angle_deg = 70\n'
DEG = np.arange(-180.0, 180.0)
DENSE = np.radians(np.arange(-179.99, 180, 0.05))
LIFT_MM, HALF_RAD = 8.0, np.radians(70.0)
Law = Callable[[Floats], tuple[Floats, Floats, Floats]]


def cycloid(u: Floats) -> tuple[Floats, Floats, Floats]:
    """Return a rise of 1 over u = 0 .. 1 with its first two derivatives."""
    w = 2 * np.pi
    return u - np.sin(w * u) / w, 1 - np.cos(w * u), w * np.sin(w * u)


def polynomial(u: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the rise of the 3-4-5 polynomial."""
    slope, bend = 30 * u**2 * (1 - u) ** 2, 60 * u * (1 - u) * (1 - 2 * u)
    return 10 * u**3 - 15 * u**4 + 6 * u**5, slope, bend


def lobe(law: Law, theta_rad: Floats) -> tuple[Floats, Floats, Floats]:
    """Return lift, slope and acceleration [mm, mm/rad, mm/rad2] of equal flanks."""
    y, slope, bend = law(np.clip(1 - np.abs(theta_rad) / HALF_RAD, 0, 1))
    scale = LIFT_MM / HALF_RAD
    return LIFT_MM * y, -np.sign(theta_rad) * scale * slope, scale / HALF_RAD * bend


def rounded(law: Law, step_mm: float = 0.001) -> Floats:
    """Return the lifts of a printed table: every degree, in steps."""
    return np.round(lobe(law, np.radians(DEG))[0] / step_mm) * step_mm


def with_list(lift_mm: Floats, more: str = "", text: str = TURNED) -> str:
    """Return a part file with a list of lift at every degree."""
    listed = f'law = "list"\nangle_deg = {DEG.tolist()}\nlift_mm = {lift_mm.tolist()}\n'
    return text.replace(LAW, listed + more)


def allowing(text: str, form_error_um: float) -> str:
    """Return a part file with another form error."""
    return text.replace("[process]\n", f"[process]\nform_error_um = {form_error_um}\n")


def law_of(text: str) -> Listed:
    """Return the curve of the first lobe of a part file."""
    law = make_lobes(cam(text))[0].law
    assert isinstance(law, Listed)
    return law


@pytest.mark.parametrize("law", [cycloid, polynomial])
def test_acceleration_is_that_of_the_law_before_rounding(law: Law) -> None:
    """1 degree and 1 um: peaks within 2 %, where the list as it is has 8 % and more too much."""
    exact = lobe(law, DENSE)[2]
    raw = law_of(with_list(rounded(law))).evaluate(DENSE).d2
    smooth = law_of(with_list(rounded(law), "smooth_um = 0.5\n")).evaluate(DENSE).d2
    assert raw.max() > 1.08 * exact.max()
    assert [smooth.max(), smooth.min()] == pytest.approx([exact.max(), exact.min()], rel=0.02)
    off = [np.sqrt(np.mean((one - exact) ** 2)) / exact.max() for one in (raw, smooth)]
    assert off[1] < 0.015 and off[1] < 0.4 * off[0]


def test_every_point_is_met_within_the_band() -> None:
    """Listed points are off by the band at most, the dwell is 0, and the turn is closed."""
    listed = rounded(cycloid, 0.002)
    law = law_of(allowing(with_list(listed, "smooth_um = 1.5\n"), 2.0))
    lift = law.evaluate(np.radians(DEG)).lift
    off_um = 1000 * (lift - listed)
    assert 1.4 < np.abs(off_um).max() <= 1.5 + 1e-6
    assert np.abs(lift[listed == 0]).max() < 1e-12
    for before, after in zip(*(law.evaluate(np.array([a * np.pi])) for a in (-1, 1)), strict=True):
        assert before == pytest.approx(after, abs=1e-6)


def test_no_curve_in_the_band_is_smoother() -> None:
    """Neither the law itself nor small changes within the band have less of a third difference."""
    listed = rounded(polynomial)
    found = law_of(with_list(listed, "smooth_um = 0.5\n")).evaluate(np.radians(DEG)).lift

    def roughness(lift_mm: Floats) -> float:
        return float(np.sum(np.diff(lift_mm, 3, append=lift_mm[:3]) ** 2))

    rng, free = np.random.default_rng(4), listed > 0
    exact = np.where(free, lobe(polynomial, np.radians(DEG))[0], 0.0)
    assert roughness(found) < roughness(exact)
    for _ in range(50):
        other = found + free * rng.normal(0, 1e-6, found.size)
        other = np.clip(other, np.maximum(listed - 0.0005, 0), listed + 0.0005) * free
        assert roughness(other) > roughness(found)


def test_residuals_and_peaks_are_shown(tmp_path: Path) -> None:
    """JSON, text and picture of a table: residuals, acceleration and jerk before and after."""
    listed = rounded(polynomial)
    text = with_list(listed, "smooth_um = 0.5\n")
    made = Made(KIND, KIND.make(cam(text)))
    assert "smoothing" in KIND.report().pictures(made.table)
    [one] = KIND.summary(made.table)["lobes"]
    off_um = 1000 * (law_of(text).evaluate(np.radians(DEG)).lift - listed)
    found = one["smoothing"]
    assert found["largest_um"] == pytest.approx(np.abs(off_um).max(), abs=1e-6)
    at = int(np.flatnonzero(found["largest_at_deg"] == DEG)[0])
    assert abs(off_um[at]) == pytest.approx(found["largest_um"], abs=1e-6)
    assert found["rms_um"] == pytest.approx(np.sqrt(np.mean(off_um**2)), rel=1e-6)
    exact = np.abs(lobe(polynomial, DENSE)[2]).max()
    acceleration, jerk = found["acceleration_mm_per_rad2"], found["jerk_mm_per_rad3"]
    assert acceleration["after"] == pytest.approx(exact, rel=0.02)
    assert acceleration["before"] > 1.1 * exact and jerk["before"] > 3 * jerk["after"]
    line = f"list smoothed within 0.5 um: largest residual 0.5 um at {DEG[at]:g} degrees, rms "
    assert line in made.text()
    assert "  smoothing takes 0.5 um of the tolerance of 1 um\n" in made.text()


@pytest.mark.long
@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(("asked", "left_um"), [("1.2", 0.7), ("0.4", None)])
def test_smoothing_takes_its_share_of_a_given_tolerance(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], asked: str, left_um: float | None
) -> None:
    """Of --tolerance-um as of the part's own; nothing left is refused. The page has the picture."""
    text = with_list(rounded(polynomial), "smooth_um = 0.5\n", GROUND)
    (tmp_path / "c.toml").write_text(text)
    out = tmp_path / "out"
    quick = (*QUICK[:-1], "--set", "rehearse_turns=0")
    words = ("--feed", "4", "-o", str(out), "--", "--tolerance-um", asked, *quick)
    status = run([str(tmp_path / "c.toml"), *words])
    shown = capsys.readouterr()
    if left_um is None:
        assert status == 2 and "--tolerance-um 0.4: smoothing takes 0.5 um" in shown.err
        return
    assert status == 0, shown.err
    summary = json.loads((out / "summary.json").read_text())
    assert summary["form_error_um"]["tolerance"] == pytest.approx(left_um, abs=1e-4)
    assert (out / "cut_smoothing.png").exists()
    page = (out / "report.html").read_text()
    assert "Smoothing of a list" in page and "list smoothed within 0.5 um" in page
    share = "smoothing takes 0.5 um of the tolerance of 1.2 um"
    assert f"against the smoothed drawing (700 nm left: {share})" in shown.out


def test_rounded_list_is_warned_about() -> None:
    """The warning names a band that does what it says; exact lists and coarse angles have none."""
    noisy = law_of(with_list(rounded(polynomial)))
    assert noisy.smoothing is None and noisy.needed is not None
    band_um = noisy.needed.band_um
    assert 0.3 <= band_um <= 1.2
    smooth = law_of(with_list(rounded(polynomial), f"smooth_um = {band_um}\n"))
    exact = lobe(polynomial, DENSE)[2].max()
    assert smooth.evaluate(DENSE).d2.max() == pytest.approx(exact, rel=0.03)
    assert smooth.needed is None
    assert law_of(with_list(rounded(polynomial, 1e-6))).needed is None
    coarse = DEG[::5].tolist(), rounded(polynomial)[::5].tolist()
    listed = f'law = "list"\nangle_deg = {coarse[0]}\nlift_mm = {coarse[1]}\n'
    assert law_of(TURNED.replace(LAW, listed)).needed is None


@pytest.mark.parametrize(("step_deg", "step_mm"), [(0.25, 0.001), (0.5, 0.005), (2.0, 0.005)])
def test_band_of_the_warning_suits_any_table(step_deg: float, step_mm: float) -> None:
    """Fine angles, coarse lifts, few points: the band named brings the acceleration of the law."""
    deg = np.arange(-180, 180, step_deg)
    lift_mm = np.round(lobe(polynomial, np.radians(deg))[0] / step_mm) * step_mm
    needed = band_for(PointedTurn(deg, lift_mm, *np.zeros((2, 0))))
    assert needed is not None and needed.band_um <= 2500 * step_mm
    exact = lobe(polynomial, DENSE)[2].max()
    assert np.abs(needed.after(DENSE, nu=2)).max() == pytest.approx(exact, rel=0.02)


def test_refusals_that_are_noise_name_a_band_that_works() -> None:
    """With the form error where it is beyond that; none without noise."""
    hollow = with_list(rounded(polynomial, 0.002), text=GROUND)
    line = refused(lambda: make_lobes(cam(hollow)), GeometryError)
    assert "is hollow with a radius" in line
    told, band = line.split("; or smooth the noise of the list: ")
    assert "give a wheel below" in told and band.startswith("cam.lobe.0.smooth_um = ")
    make_lobes(cam(with_list(rounded(polynomial, 0.002), band[11:] + "\n", GROUND)))
    with pytest.raises(CamtoolsError, match="swing_acceleration_deg_s2 = 100000") as weak:
        generate_lobes(cam(with_list(rounded(polynomial))))
    assert "; the list is noisy: cam.lobe.0.smooth_um = " in weak.value.lines[0]
    listed = rounded(polynomial, 0.005)
    line = refused(lambda: make_lobes(cam(with_list(listed, text=GROUND))), GeometryError)
    told = r"smooth_um = ([0-9.]+) with process.form_error_um = ([0-9.]+)$"
    found = sure(re.search(told, line.partition("or smooth the noise of the list: ")[2]))
    text = with_list(listed, f"smooth_um = {found[1]}\n", GROUND)
    make_lobes(cam(allowing(text, float(found[2]))))
    with pytest.raises(GeometryError, match=r"leaves nothing of process\.form_error_um = 1;"):
        make_lobes(cam(text))
    steep = lobe(polynomial, np.radians(DEG * 70 / 55))[0]
    line = refused(lambda: make_lobes(cam(with_list(steep, text=GROUND))), GeometryError)
    assert "is hollow with a radius" in line and "smooth" not in line


@pytest.mark.parametrize(("sign", "side"), [(1, "opening"), (-1, "closing")])
def test_fast_ramp_is_refused_with_number_and_angle(sign: int, side: str) -> None:
    """A rise over 60 degrees and a fall over 110: the steeper one is named."""
    rise_rad, fall_rad = (np.radians(one) for one in ((60, 110) if sign > 0 else (110, 60)))

    def flanks(theta: Floats) -> tuple[Floats, Floats]:
        half = np.where(theta < 0, rise_rad, fall_rad)
        y, slope, _ = cycloid(np.clip(1 - np.abs(theta) / half, 0, 1))
        return LIFT_MM * y, -np.sign(theta) * LIFT_MM * slope / half

    lift, slope = flanks(DENSE)
    um_per_deg = np.where(lift <= 0.3, np.radians(slope) * 1000, 0)
    worst = int(np.abs(um_per_deg).argmax())
    most = float(np.abs(um_per_deg[worst]))
    listed = flanks(np.radians(DEG))[0]
    ramp = "ramp_height_mm = 0.3\nramp_um_per_deg = {:.3f}\n"
    steep = with_list(listed, ramp.format(0.9 * most))
    line = refused(lambda: make_lobes(cam(steep)), GeometryError)
    assert line.startswith(f"cam.lobe.0.ramp_um_per_deg: the {side} ramp has ")
    words = line.partition(" ramp has ")[2].split()
    assert float(words[0]) == pytest.approx(most, rel=0.01)
    at_deg = float(line.partition(" cam at ")[2].split()[0])
    assert (at_deg + 180) % 360 - 180 == pytest.approx(np.degrees(DENSE[worst]), abs=0.2)
    make_lobes(cam(with_list(listed, ramp.format(1.02 * most))))


CSV = 'law = "list"\ncsv = "{}"\n'


def csv_law(folder: Path, rows: tuple[Floats, Floats], header: str, more: str = "") -> Listed:
    """Return the curve of a list in a file."""
    lines = (f"{a!r} {b!r}\n" for a, b in zip(*(one.tolist() for one in rows), strict=True))
    (folder / "lift.txt").write_text(header + "".join(lines))
    return law_of(TURNED.replace(LAW, CSV.format(folder / "lift.txt") + more))


def test_crank_degrees_shares_inches_and_counts(tmp_path: Path) -> None:
    """The same lobe from angles of the crank, shares of the largest lift, inches and counts."""
    lift = lobe(cycloid, np.radians(DEG))[0]
    plain = law_of(with_list(lift)).evaluate(DENSE)
    share, inch = (2 * DEG, lift / LIFT_MM), (DEG, lift / 25.4)
    crank, counts = 'degrees_of = "crank"\n', "counts_per_turn = 11520\n"
    listed = f'law = "list"\n{crank}angle_deg = {(2 * DEG).tolist()}\nlift_mm = {lift.tolist()}\n'
    own = TURNED.replace(LAW, CSV.format(tmp_path / "own.csv") + crank)
    rows = "".join(f"{2 * a},{b}\n" for a, b in zip(DEG.tolist(), lift.tolist(), strict=True))
    (tmp_path / "own.csv").write_text("angle_deg,lift_mm\n" + rows)
    for law in (
        csv_law(tmp_path, share, "", f"{crank}largest_lift_mm = {LIFT_MM}\n"),
        csv_law(tmp_path, inch, "angle_deg lift\n", 'lift_unit = "inch"\n'),
        csv_law(tmp_path, inch, "angle_deg lift_inch\n"),
        csv_law(tmp_path, (32 * DEG, 4000 * lift), "", f"{counts}counts_per_mm = 4000\n"),
        law_of(TURNED.replace(LAW, listed)),
        law_of(own),
    ):
        found = law.evaluate(DENSE)
        assert found.lift == pytest.approx(plain.lift, abs=1e-9)
        assert found.d2 == pytest.approx(plain.d2, abs=1e-4)


def test_motion_of_the_crank_is_that_of_the_cam(tmp_path: Path) -> None:
    """Velocity and acceleration by the degree of the crank are doubled and quadrupled."""
    lift, slope, bend = lobe(cycloid, np.radians(DEG))
    columns = 2 * DEG, lift, slope * np.pi / 360, bend * (np.pi / 360) ** 2
    rows = zip(*(one.tolist() for one in columns), strict=True)
    (tmp_path / "xyva.txt").write_text("".join(f"{a} {b} {c} {d}\n" for a, b, c, d in rows))
    part = TURNED.replace(LAW, CSV.format(tmp_path / "xyva.txt") + 'degrees_of = "crank"\n')
    law = law_of(part)
    assert law.evaluate(np.radians(DEG)).d2 == pytest.approx(bend, abs=1e-6)
    with pytest.raises(GeometryError, match=r"cam\.lobe\.0\.smooth_um: the file has velocities"):
        law_of(part.replace('"crank"\n', '"crank"\nsmooth_um = 1\n'))
    columns = DEG, lift, slope * np.pi / 180, bend * (np.pi / 180) ** 2
    rows = zip(*(one.tolist() for one in columns), strict=True)
    (tmp_path / "xyva.txt").write_text("".join(f"{a} {b} {c} {d}\n" for a, b, c, d in rows))
    with pytest.raises(GeometryError, match="359 of 720 degrees of the crank: one turn of the"):
        law_of(part)


def test_units_that_contradict_are_refused(tmp_path: Path) -> None:
    """A header or a key against another key, shares above 1, a turn of the cam as of the crank."""
    lift = lobe(cycloid, np.radians(DEG))[0]
    for header, more, told in (
        ("angle_deg lift_mm\n", 'lift_unit = "inch"\n', "line 1: the header names a unit of le"),
        ("X_deg y\n", "counts_per_turn = 360\n", "line 1: the header names a unit of angle, and"),
        ("", f"largest_lift_mm = {LIFT_MM}\n", "shares of 0 .. 8, not 0 .. 1; give shares of 0"),
        ("", "counts_per_mm = 0.001\n", "the base circle, or correct counts_per_mm"),
        ("", 'degrees_of = "crank"\n', "of the crank: one turn of the cam?; add points of lift 0"),
    ):
        law = partial(csv_law, tmp_path, (DEG, lift), header, more)
        assert told in refused(law, GeometryError)
    with pytest.raises(CamtoolsError, match="lift_unit = 'inch': says what the lifts"):
        csv_law(tmp_path, (DEG, lift), "", 'lift_unit = "inch"\ncounts_per_mm = 9\n')


@pytest.mark.parametrize(
    ("more", "told"),
    [
        ('lift_unit = "inch"\n', "lift_unit = 'inch': is for a csv, the lists of the part file"),
        ("largest_lift_mm = 8\n", "largest_lift_mm = 8.0: is for a csv"),
        ("counts_per_turn = 4096\n", "counts_per_turn = 4096.0: is for a csv"),
        ("ramp_height_mm = 0.3\n", "ramp_um_per_deg: is missing"),
        ("ramp_um_per_deg = 9\n", "ramp_height_mm: is missing"),
        ("smooth_um = 0\n", "smooth_um = 0: "),
        ("smooth_um = 51\n", "smooth_um = 51"),
        ('degrees_of = "crank"\n', "neither a turn of the cam (720) nor 0.02 degrees less"),
        ("", 'degrees less; list one turn, or set degrees_of = "crank"'),
    ],
)
def test_keys_of_a_list_are_checked(more: str, told: str) -> None:
    """Each refusal names the key and what is wrong with it."""
    angles = [*range(0, 360, 30)]
    if "crank" in told or "crank" in more:
        angles = [*range(0, 720, 60), 719.99]
    text = TURNED.replace(
        LAW, f'law = "list"\n{more}angle_deg = {angles}\nlift_mm = {[0] * len(angles)}\n'
    )
    lines = refused_lines(lambda: cam(text))
    assert any(told in line for line in lines), lines


@pytest.mark.parametrize("header", ["", "angle_deg lift\n", "angle_deg,lift_mm\n"])
def test_crank_degrees_without_their_key_name_it(tmp_path: Path, header: str) -> None:
    """718 degrees of points every two are those of the crank."""
    (tmp_path / "lift.csv").write_text(
        header + "".join(f"{2 * i}{',' if ',' in header else ' '}0.1\n" for i in range(360))
    )
    with pytest.raises(GeometryError, match=r', or set degrees_of = "crank"$'):
        law_of(TURNED.replace(LAW, CSV.format(tmp_path / "lift.csv")))


@pytest.mark.parametrize(
    ("step_deg", "rise"),
    [(0.036, (8, 65)), pytest.param(0.01, (6, 80), marks=pytest.mark.long)],
)
def test_fine_list_is_refused_with_the_band_that_it_needs(
    step_deg: float, rise: tuple[float, float], tmp_path: Path
) -> None:
    """Listed to 0.1 nm, far below the least band: the noise is in the jerk alone."""
    text = ground_list(tmp_path / "a.csv", step_deg, 7, rise)
    refusal = refused(lambda: generate_lobes(cam(text)))
    assert refusal.endswith("; the list is noisy: cam.lobe.0.smooth_um = 0.001 smooths it")
    band = text.replace('law = "list"', 'law = "list"\nsmooth_um = 0.001')
    assert len(pack(generate_lobes(cam(band)).table)) < 100_000
