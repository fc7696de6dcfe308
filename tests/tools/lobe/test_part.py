"""Part files of cams: what is read, and what is refused with field and remedy."""

import re
from pathlib import Path

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError, GeometryError
from camtools.base.quantities import Floats
from camtools.lobe.channels import places_of
from camtools.lobe.lift import Poly345, make_lift, points_of
from camtools.lobe.motion import extent_of, extent_texts, make_lobes
from camtools.lobe.part import MAX_LOBES, LobePart
from camtools.pipeline.load import load, parse, parse_for
from camtools.skirt.part.part_file import SkirtPart
from tests.tools.cases.lobe_cases import cam as cam_of
from tests.tools.cases.part_cases import PERKINS, ROOT, parse_part, refused, refused_lines

PARTS = ROOT / "tools" / "parts"
GOOD = (PARTS / "cam-345.toml").read_text()
DISC = (PARTS / "cam-disc.toml").read_text()
LOBE = "cam.lobe.0"
LAW = 'law = "poly345"\nlift_mm = 8\nhalf_angle_deg = 70\n'
POINTS = "angle_deg = [0, 45, 90, 135, 180, 225, 270, 315]\n"
LIST = f'law = "list"\n{POINTS}lift_mm = [0, 1, 2, 3, 4, 3, 2, 1]\n'


def with_law(text: str) -> str:
    """Return the good file with another law."""
    return GOOD.replace(LAW, text)


def lines_of(text: str) -> list[str]:
    """Return the messages that a part file's text is refused with."""
    return refused_lines(lambda: parse(text.encode(), "c.toml"))


def test_cam_has_its_defaults() -> None:
    """Turning follows the roller, grinding the wheel; phase, feed and limits have defaults."""
    short = GOOD[: GOOD.index("[machine")].replace("phase_deg = 0", "")
    part = cam_of(short)
    assert (part.cam.lobe[0].phase_deg, part.process.feed_mm, part.process.direction) == (0, 0.1, 1)
    assert part.follower_radius_mm == 10
    assert cam_of(DISC).follower_radius_mm == 200
    assert part.machine.limits.u_stroke_mm == 30


def test_pistons_are_read_as_before() -> None:
    """A part file says itself what it is; what takes pistons only says so of a cam."""
    assert not isinstance(load(PERKINS).part, LobePart)
    assert refused(lambda: parse_for("trade", SkirtPart, GOOD.encode(), "c.toml")) == (
        "c.toml: part.kind = 'cam': cams are for mktables, run, analyse and mkgcode; give the part "
        "file of a piston"
    )
    with pytest.raises(CamtoolsError, match=r"part\.kind = 'cam': is of the wrong kind"):
        parse_part(GOOD.encode(), "c.toml")


@pytest.mark.parametrize("kind", ['"gear"', '["cam"]', "1", "{}"])
def test_a_wrong_kind_is_all_that_is_told(kind: str) -> None:
    """Nobody knows which keys belong to it: the rest of a cam is no mistake in a piston."""
    [line] = lines_of(GOOD.replace('kind = "cam"', f"kind = {kind}"))
    assert line.startswith("c.toml: part.kind = ")
    assert line.endswith("; use one of: 'piston', 'cam' or 'polygon'")


FLANKS = """law = "cycloidal"
lift_mm = 8
rise_deg = 60
dwell_deg = 20
fall_deg = 80
"""
BAD = [
    (GOOD.replace("base_radius_mm = 20", ""), "cam.base_radius_mm", "add it"),
    (GOOD.replace("roller_radius_mm = 10", "roller_radius_mm = 0"), "cam.roller_rad", "at least"),
    (GOOD.replace("z_mm = [0, 12]", "z_mm = [0]"), f"{LOBE}.z_mm", "at least 2 entries"),
    (GOOD.replace("z_mm = [0, 12]", "z_mm = [12, 0]"), f"{LOBE}.z_mm", "list the points upwards"),
    (GOOD.replace("phase_deg = 0", "phase_deg = 400"), f"{LOBE}.phase_deg = 400", "at most 360"),
    (with_law('law = "sine"\n'), f"{LOBE}.law = 'sine'", "'poly345', 'disc' or 'list'"),
    (with_law('law = "poly345"\nhalf_angle_deg = 70\n'), f"{LOBE}.lift_mm", "add it"),
    (with_law(LAW.replace("8", "[8]")), f"{LOBE}.lift_mm", "at least 8 entries"),
    (with_law(LAW.replace("= 8", f"= {[1] * 8}")), f"{LOBE}.lift_mm", "largest lift"),
    (with_law(LAW.replace("= 8", "= 16")), f"{LOBE}.lift_mm = 16", "at most 15"),
    (with_law(LAW.replace("= 8", "= 0")), f"{LOBE}.lift_mm = 0:", "give more than 0"),
    (with_law(LAW.replace("= 8", "= -1")), f"{LOBE}.lift_mm = -1:", "give more than 0"),
    (with_law(LAW.replace("= 8", "= nan")), f"{LOBE}.lift_mm = nan", "finite"),
    (with_law(LAW + "offset_mm = 1\n"), f"{LOBE}.offset_mm = 1", 'law = "disc"'),
    (with_law(LAW + 'csv = "a"\n'), f"{LOBE}.csv = 'a'", 'law = "list"'),
    (with_law(LAW + "smooth_um = 1\n"), f"{LOBE}.smooth_um = 1", 'law = "list"'),
    (with_law(LAW + "lft = 1\n"), f"{LOBE}.lft: ", "spelling"),
    (with_law(LAW + "rise_deg = 60\n"), f"{LOBE}.half_angle_deg = 70", "give either"),
    (with_law(LAW + "dwell_deg = 10\n"), f"{LOBE}.half_angle_deg = 70", "give either"),
    (with_law(FLANKS.replace("= 20", "= 300")), f"{LOBE}.rise_deg = 60", "360 degrees at most"),
    (with_law(FLANKS.replace("fall_deg = 80\n", "")), f"{LOBE}.fall_deg", "add it"),
    (with_law(FLANKS.replace("= 60", "= 2")), f"{LOBE}.rise_deg = 2", "at least 5"),
    (with_law(FLANKS + "design_rpm = 9\n"), f"{LOBE}.design_rpm = 9", 'law = "polydyne"'),
    (with_law(FLANKS.replace("cycloidal", "polydyne")), f"{LOBE}.design_rpm", "add it"),
    (GOOD.replace("[[cam", 'follower = "knife"\n[[cam'), "cam.follower = 'knife'", "'flat'"),
    (with_law('law = "list"\n'), f"{LOBE}.csv", "give one of them"),
    (with_law(LIST + 'csv = "a"\n'), f"{LOBE}.csv = 'a'", "give one of them"),
    (with_law(f'law = "list"\n{POINTS}'), f"{LOBE}: angle_deg", "give both"),
    (with_law(LIST.replace("[0, 1,", "[")), f"{LOBE}.lift_mm", "at least 8 entries"),
    (with_law(LIST.replace("[0, 1,", "[0, 0, 1,")), f"{LOBE}.lift_mm", "one value for each"),
    (with_law(LIST.replace("lift_mm = [", "lift_mm = 8 #")), f"{LOBE}.lift_mm = 8", "give a list"),
    (with_law(LIST.replace("45", "95")), f"{LOBE}.angle_deg", "sort the points"),
    (with_law(LIST.replace("315", "361")), f"{LOBE}.angle_deg", "list one turn"),
    (DISC.replace("offset_mm = 5", "offset_mm = 4"), f"{LOBE}.disc_radius_mm = 25", "make them eq"),
    (DISC.replace("wheel_radius_mm = 200", ""), "cam.wheel_radius_mm: is missing", "add it"),
    (DISC.replace('"grinding"', '"milling"'), "process.operation", "or 'plunge-grinding'"),
    (DISC.replace('"constant-surface"', '"even"'), "process.speed", "'uniform' or 'constant-sur"),
    (GOOD.replace("= 60\n\n[machine", "= 0\n\n[machine"), "process.spindle_rpm = 0", "at least 1"),
    (GOOD.replace("swing_deg = 30", "swing_deg = 90"), "machine.limits.swing_deg", "at most 80"),
    (GOOD.replace("[[cam.lobe]]", "[cam.lobe]"), "cam.lobe", "[[cam.lobe]]"),
]


@pytest.mark.parametrize(("text", "field", "remedy"), BAD)
def test_bad_field_is_named(text: str, field: str, remedy: str) -> None:
    """One of the lines names field and remedy."""
    lines = lines_of(text)
    first = next((line for line in lines if line.startswith(f"c.toml: {field}")), None)
    assert first is not None, lines
    assert remedy in first.split("; ", 1)[1], first


def with_lobes(*places_mm: list[float]) -> str:
    """Return the good file with lobes at other places."""
    lobe = GOOD[GOOD.index("[[cam.lobe]]") : GOOD.index("[process]")]
    return GOOD.replace(lobe, "".join(lobe.replace("[0, 12]", str(one)) for one in places_mm))


@pytest.mark.parametrize(("end", "start"), [(1, 1.2), (3, 3.2), (12.1, 12.3), (20.7, 20.9)])
def test_gap_is_compared_in_nanometres(end: float, start: float) -> None:
    """1.2 - 1 is less than 0.2 in binary; a gap of 0.2 mm is one, a micrometre less is told."""
    assert len(cam_of(with_lobes([0, end], [start, 30])).cam.lobe) == 2
    near = round(start - 0.001, 4)
    assert lines_of(with_lobes([0, end], [near, 30])) == [
        f"c.toml: cam.lobe.1.z_mm = [{near:g}, 30.0]: a lobe from {near:g} mm follows one that "
        f"ends at {end:g} mm: the gap must be at least 0.2 mm; list the lobes upwards, apart from "
        "each other"
    ]


def test_part_file_takes_the_lobes_that_a_table_holds() -> None:
    """64 lobes of one profile are read and keep their places; one more is refused as read."""
    places_mm: list[list[float]] = [[10 * i, 10 * i + 3] for i in range(MAX_LOBES + 1)]
    places = places_of(make_lobes(cam_of(with_lobes(*places_mm[:-1]))))
    assert [one.z_first_nm for one in places] == [10_000_000 * i for i in range(MAX_LOBES)]
    assert {one.pattern for one in places} == {0}
    told = "has 65 lobes, a part file at most 64; make tables of fewer lobes each"
    assert lines_of(with_lobes(*places_mm)) == [f"c.toml: cam.lobe: {told}"]


@pytest.mark.parametrize(("text", "field"), [(GOOD, "roller"), (DISC, "wheel")])
def test_follower_stays_within_the_table(text: str, field: str) -> None:
    """A table holds 2000 mm; what is asked for instead is taken."""
    text = text.replace("base_radius_mm = 20", "base_radius_mm = 200")
    text = text.replace("disc_radius_mm = 25", "disc_radius_mm = 205")
    before = f"{field}_radius_mm = {'10' if field == 'roller' else '200'}\n"
    [line] = lines_of(text.replace(before, f"{field}_radius_mm = 1990\n"))
    assert line.startswith(f"c.toml: cam.{field}_radius_mm = 1990.0: with base_radius_mm")
    most = line.partition("; give at most ")[2].partition(",")[0]
    most_mm = float(most)
    part = cam_of(text.replace(before, f"{field}_radius_mm = {most}\n"))
    assert part.follower_radius_mm == most_mm


def closing(first: float, last: float) -> list[float]:
    """Return angles every 30 degrees as a drawing writes them, with a last one."""
    return [*(round(first + angle, 3) for angle in range(0, 360, 30)), last]


@pytest.mark.parametrize(("first", "last"), [(152.3, 512.3), (152.2, 512.2), (0.0, 359.99)])
def test_turn_closes_with_decimal_angles(first: float, last: float, tmp_path: Path) -> None:
    """512.3 - 152.3 is not 360 in binary; part file and CSV file take it for a turn."""
    angles = closing(first, last)
    lifts = [*(1 - np.cos(np.radians(np.arange(0, 360, 30)))).tolist(), 0.0]
    listed = cam_of(with_law(f'law = "list"\nangle_deg = {angles}\nlift_mm = {lifts}\n'))
    rows = "".join(f"{a},{h}\n" for a, h in zip(angles, lifts, strict=True))
    (tmp_path / "lift.csv").write_text("angle_deg,lift_mm\n" + rows)
    from_csv = cam_of(with_law(f'law = "list"\ncsv = "{tmp_path / "lift.csv"}"\n'))
    for part in (listed, from_csv):
        law = make_lift(part.cam, part.cam.lobe[0], LOBE)
        top = law.evaluate(np.radians([first + 180, first + 540])).lift
        assert top == pytest.approx([2, 2], abs=1e-9)


@pytest.mark.parametrize("last", [359.995, 360.001])
def test_end_of_a_turn_is_a_step_away_or_none(last: float) -> None:
    """What is neither closed nor open is refused."""
    angles = closing(0.0, last)
    text = f'law = "list"\nangle_deg = {angles}\nlift_mm = {[0] * len(angles)}\n'
    assert any(f"span {last} degrees" in line for line in lines_of(with_law(text)))


def test_spline_stays_between_the_given_lifts() -> None:
    """Few points: the spline dips below the base circle, or rises over the nose; told where."""
    angles = [*range(-80, 81, 10), 180]
    lifts = Poly345(8.0, np.radians(70.0)).evaluate(np.radians(angles)).lift.clip(0)
    no_nose = [*range(5, 360, 10)]
    waves = (2 - 2 * np.cos(np.radians(no_nose))).tolist()
    cases = (
        (angles, lifts.tolist(), "-0.1436 mm at ", "0 .. 8 mm"),
        (no_nose, waves, "4 mm at 1", "0 .. 3.99239 mm"),
    )
    for degrees, values, found, given in cases:
        text = f'law = "list"\nangle_deg = {degrees}\nlift_mm = {values}\n'
        line = refused_lift(cam_of(with_law(text)))
        assert line.startswith(f"{LOBE}.lift_mm: between the points the lift comes to {found}")
        assert given in line and "; give more points there" in line


def refused_lift(part: LobePart) -> str:
    """Return the message that refuses the lift of the first lobe."""
    return refused(lambda: make_lift(part.cam, part.cam.lobe[0], LOBE), GeometryError)


def test_points_come_from_a_file_too(tmp_path: Path) -> None:
    """A CSV file beside the part file, read line by line."""
    path, table = tmp_path / "c.toml", tmp_path / "lift.csv"
    path.write_text(with_law('law = "list"\ncsv = "lift.csv"\n'))
    rows = [f"{angle},{1 - np.cos(np.radians(angle))}\n" for angle in range(0, 360, 30)]
    table.write_text("angle_deg,lift_mm\n" + "".join(rows))
    part = load(path).part
    assert isinstance(part, LobePart)
    law = make_lift(part.cam, part.cam.lobe[0], LOBE)
    assert float(law.evaluate(np.array(np.pi / 6)).lift) == pytest.approx(1 - np.sqrt(0.75))
    for text, problem in (
        ("angle,lift\n", "line 1: no points follow"),
        ("angle,hub\n0,1\n", "line 1: no column of Y"),
        ("".join(f"{45 * i} {i % 8 - 0.0011}\n" for i in range(9)), "lifts of -0.0011 .. 6.9989"),
        ("angle_deg,lift_mm\n0,1\n0,2\n", "line 3: angle 0 follows 0 degrees"),
        ("angle_deg,lift_mm\n0,1\n", "line 2: 1 points span 0 degrees"),
    ):
        table.write_text(text)
        line = refused_lift(part)
        assert line.startswith(f"{LOBE}.csv: lift.csv: ") and problem in line
    table.unlink()
    assert "No such file" in refused_lift(part)


def lobe_mm(degrees: Floats) -> Floats:
    """Return the lift of a lobe of 6 mm at angles from its nose."""
    return Poly345(6.0, np.radians(70.0)).evaluate(np.radians(degrees)).lift


def law_of(degrees: Floats, lift_mm: Floats, csv: Path | None = None) -> str:
    """Return a law of these points, in the part file or in another."""
    if csv is None:
        return f'law = "list"\nangle_deg = {degrees.tolist()}\nlift_mm = {lift_mm.tolist()}\n'
    csv.write_text("".join(f"{a},{mm:.9f}\n" for a, mm in zip(degrees, lift_mm, strict=True)))
    return f'law = "list"\ncsv = "{csv}"\n'


WHOLE = np.arange(-90.0, 270)


@pytest.mark.parametrize(
    ("degrees", "problem"),
    [
        (np.arange(0.0, 181), "from 180 to 360 degrees, where the lift goes from 0 to 6 mm"),
        (np.arange(0.0, 91), "from 90 to 360 degrees, where the lift goes from 0 to 6 mm"),
        (WHOLE[(WHOLE < 20) | (WHOLE > 50)], "from 19 to 51 degrees, where the lift goes from 5"),
        (
            WHOLE[abs(WHOLE) > 6],
            "from -7 to 7 degrees, where the lift goes from 5.94864 to 5.94864",
        ),
    ],
    ids=["half", "quarter", "flank", "nose"],
)
def test_part_of_a_lobe_is_no_turn(degrees: Floats, problem: str, tmp_path: Path) -> None:
    """A gap that is not on the base circle is refused, in the part file and in any other."""
    for csv, field in ((None, "angle_deg"), (tmp_path / "a.csv", "csv")):
        line = refused_lift(cam_of(with_law(law_of(degrees, lobe_mm(degrees), csv))))
        assert line.startswith(f"{LOBE}.{field}: no points {problem}")
        assert ": the turn is not closed; list all of the lobe, both flanks, points" in line
        [most_deg] = re.findall(r"at most (\S+) degrees apart$", line)
        assert float(most_deg) == pytest.approx(np.clip(1440 / degrees.size, 10, 45), rel=1e-5)
    crank = 'degrees_of = "crank"\n' + law_of(2 * degrees, lobe_mm(degrees))
    assert "the turn is not closed; list all" in refused_lift(cam_of(with_law(crank)))


def test_gap_ends_where_its_refusal_says(tmp_path: Path) -> None:
    """A fine nose and coarse flanks: the stated distance is allowed, in degrees of the crank."""
    nose = np.linspace(-8, 8, 201)
    for step_deg, is_refused in ((12, True), (10, False)):
        flank = np.arange(8.0 + step_deg, 178, step_deg)
        degrees = np.concatenate([-flank[::-1], nose, flank])
        lift_mm = 3 + 3 * np.cos(np.radians(degrees))
        crank = law_of(2 * degrees, lift_mm, tmp_path / "a.csv")
        part = cam_of(with_law(crank + 'degrees_of = "crank"\n'))
        if is_refused:
            assert refused_lift(part).endswith("at most 20 degrees apart")
        else:
            make_lift(part.cam, part.cam.lobe[0], LOBE)


def test_turn_of_the_crank_may_lack_the_base_circle(tmp_path: Path) -> None:
    """Its list is taken with points of the base circle, or as one of the cam."""

    def given(end: int, csv: Path | None) -> tuple[LobePart, Floats, Floats]:
        degrees = np.arange(-180.0, end, 5)
        lift_mm = lobe_mm(degrees.clip(-90, 90))
        crank = law_of(degrees, lift_mm, csv) + 'degrees_of = "crank"\n'
        return cam_of(with_law(crank)), degrees, lift_mm

    for csv in (None, tmp_path / "a.csv"):
        line = refused_lift(given(181, csv)[0])
        assert " of 720 degrees of the crank: one turn of the cam?; add points of lift 0" in line
        assert line.endswith('if the angles are of the cam, remove degrees_of = "crank"')
        part, degrees, lift_mm = given(540, csv)
        law = make_lift(part.cam, part.cam.lobe[0], LOBE)
        found_mm = law.evaluate(np.radians(degrees / 2)).lift
        np.testing.assert_allclose(found_mm, lift_mm, atol=2e-9)


@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
def test_file_has_as_many_points_as_the_page_states(separator: str, tmp_path: Path) -> None:
    """100 000 of them, whatever separates the cells; one more is refused."""
    csv = tmp_path / "a.csv"
    part = cam_of(with_law(f'law = "list"\ncsv = "{csv}"\n')).cam.lobe[0]
    rows = [f"{0.0036 * i:.4f}{separator}0.001" for i in range(100_001)]
    csv.write_text("\n".join([f"angle_deg{separator}lift_mm", *rows[:-1], ""]))
    assert points_of(part, LOBE).x_deg.size == 100_000
    csv.write_text("\n".join([f"angle_deg{separator}lift_mm", *rows, ""]))
    with pytest.raises(GeometryError, match="has 100001 rows, at most 100000 are read; leave out"):
        points_of(part, LOBE)


@pytest.mark.parametrize("ends_deg", [(-71, 71), (-90, 90), (-70, 250)])
def test_base_circle_may_be_left_out(ends_deg: tuple[int, int]) -> None:
    """The arc without points may be longer than half a turn, and a few micrometres uneven."""
    degrees = np.arange(*ends_deg, dtype=np.float64)
    lift_mm = lobe_mm(degrees)
    lift_mm[-1] += 0.004
    part = cam_of(with_law(law_of(degrees, lift_mm) + "smooth_um = 8\n"))
    assert make_lift(part.cam, part.cam.lobe[0], LOBE).evaluate(np.zeros(1)).lift > 5.99


@pytest.mark.parametrize(
    ("base_mm", "expected"),
    [
        (0.0, ["list of lifts of 0 .. 6 mm, above 0.1 mm over 122.25 degrees of the cam"]),
        (-1e-9, ["list of lifts of 0 .. 6 mm"]),
        (-0.0002, ["list of lifts of 0 .. 6 mm", "lifts down to -0.2 um are taken as 0"]),
        (5.0, ["list of lifts of 5 .. 11 mm, above 0.1 mm over 360", "caution: the lift is never"]),
    ],
)
def test_extent_of_a_list_is_reported(base_mm: float, expected: list[str], tmp_path: Path) -> None:
    """Least lift and open angle, lifts below 0, and a lift that never ends."""
    lift_mm = lobe_mm(WHOLE)
    lift_mm = np.where(lift_mm == 0, base_mm, lift_mm + max(base_mm, 0))
    part = cam_of(with_law(law_of(WHOLE, lift_mm, tmp_path / "a.csv")))
    found = extent_texts(extent_of(make_lift(part.cam, part.cam.lobe[0], LOBE)))
    assert len(found) == len(expected)
    assert all(line.startswith(text) for line, text in zip(found, expected, strict=True)), found
