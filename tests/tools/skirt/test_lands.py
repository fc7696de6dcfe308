"""A skirt and lands in one program: the cut surface, the motion of all axes, refusals.

Radii are those of ellipses by the numbers of the drawing.
"""

from functools import partial
from pathlib import Path

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError
from camtools.base.quantities import Bools, Floats
from camtools.cli.analyse import main as analyse
from camtools.cli.mkgcode import main as mkgcode
from camtools.cli.mktables import main as mktables
from camtools.cli.run import main as run
from camtools.skirt.part.part_file import SkirtPart
from tests.tools.cases.camsim_cases import form_um, while_in
from tests.tools.cases.cut_cases import PARTS, cut_made, made_skirt, written
from tests.tools.cases.part_cases import changed, load_part, oval_text, parse_part, refused

LOW = "[[piston.land]]\nfrom_mm = -5\nto_mm = -2.5\ndiameter_mm = 91.8\novality_mm = 0.1\n"
TOP = "[[piston.land]]\nfrom_mm = 8.5\nto_mm = 11\ndiameter_mm = 91.4\ntaper_um = 40\n"
PASSES = "allowance_um = [100, 0]\nfeed_mm = 0.25\n"
PROCESS = """feed_mm = 0.5
depth_mm = 0.2
[[process.pass]]
allowance_um = 50
[[process.pass]]
allowance_um = 0
"""
BANDS = {  # ends, long-axis diameters at both, ovality [mm]
    "low": ((-5.0, -2.5), (91.8, 91.8), 0.1),
    "skirt": ((0.0, 6.0), (92.0, 92.0), 0.2),
    "top": ((8.5, 11.0), (91.4, 91.36), 0.0),
}
STOCK = {"low": [50, 0], "skirt": [50, 0], "top": [100, 0]}  # um, pass by pass


def part_of(more: str = LOW + TOP + PASSES, process: str = PROCESS, tool: str = "") -> SkirtPart:
    """Return a skirt of 6 mm with lands."""
    text = oval_text("belt", (6, 92), [0.2, 0.2], process + tool, more)
    return parse_part(text.encode(), "belt.toml")


def drawn_mm(name: str, turn: Floats, z_mm: Floats) -> Floats:
    """Return the radius of a band: that of an ellipse, in polar form."""
    ends, diameters, ovality = BANDS[name]
    a = np.interp(z_mm, ends, diameters) / 2
    b, phi = a - ovality / 2, 2 * np.pi * turn
    return np.asarray(a * b / np.hypot(b * np.cos(phi), a * np.sin(phi)))


def inside(name: str, z_mm: Floats) -> Bools:
    """Return which heights are those of a band."""
    low, high = BANDS[name][0]
    return np.asarray((z_mm >= low) & (z_mm <= high), dtype=np.bool_)


@pytest.mark.parametrize("tool", ["", "[tool]\nnose_radius_mm = 0.8\n"])
def test_each_band_is_that_of_the_drawing(tool: str, tmp_path: Path) -> None:
    """The surface is whole in all bands, and nothing is judged between them."""
    found = cut_made(made_skirt(part_of(tool=tool)), tmp_path)
    assert form_um(found) < 0.5
    surface, n = found.surface, 0
    for name, (ends, *_) in BANDS.items():
        at = inside(name, surface["z_mm"])
        z_mm, turn = surface["z_mm"][at], surface["turn"][at]
        left_um = 1000 * (surface["radius_mm"][at] - drawn_mm(name, turn, z_mm))
        assert np.abs(left_um).max() < (0.5 if not tool else 0.6)  # a nose on a slope of 0.008
        assert z_mm.min() - ends[0] < 0.01
        assert ends[1] - z_mm.max() < 0.01
        n += at.sum()
    assert n == surface["z_mm"].size


def test_axes_move_clear_of_the_part(tmp_path: Path) -> None:
    """X moves where Z rests beside a band; Z goes back and across grooves clear of the blank."""
    found = cut_made(made_skirt(part_of()), tmp_path, tables=["trace"])
    trace = while_in(found.trace, "cutting")
    turns = np.abs(np.diff(trace["turn"]))
    z_mm, x_mm = trace["in_z_nm"] * 1e-6, trace["in_x_nm"] * 1e-6
    z_feed, x_feed = np.diff(z_mm) / turns, np.diff(x_mm) / turns
    tip_mm = x_mm - trace["u_act_nm"] * 1e-6
    is_clear = tip_mm[1:] > 46.2 + 0.99  # the blank and the clearance
    assert is_clear[(z_feed < -0.01) | (z_feed > 0.51)].all()
    assert np.abs(z_feed[~is_clear & (np.abs(x_feed) > 0.02)]).max() < 0.02
    assert (z_feed < -0.1).sum() > 1000
    for name, stock_um in STOCK.items():
        above_um = 1000 * (tip_mm[1:] - drawn_mm(name, trace["turn"][1:], z_mm[1:]))
        feeds = inside(name, z_mm[1:]) & ~is_clear
        begins = np.flatnonzero(np.diff(feeds.astype(int)) == 1)
        passes = [np.median(above_um[at + 1 :][:200]) for at in begins]
        assert passes == pytest.approx(stock_um, abs=0.5), name


@pytest.mark.parametrize(("trim_um", "status"), [(-30, 0), (-80, 1)])
def test_a_first_pass_that_cuts_too_deep_is_seen(trim_um: int, status: int, tmp_path: Path) -> None:
    """It leaves 50 um, X is trimmed by less or more, and back before the second pass."""
    words = ["--rpm", "300", "--set", "x_trim_rate_nm_per_s=100000"]
    words += ["--inject", f"trim@5:{trim_um}", "--inject", "trim@6.5:0"]
    found = cut_made(made_skirt(part_of()), tmp_path, *words, status=None)
    assert found.status == status
    assert form_um(found) == pytest.approx(-50 - trim_um if status else 0, abs=0.5)


COARSE_FIRST = PROCESS.replace("= 50", "= 50\nfeed_mm = 0.35") + "feed_mm = 0.2\n"
FINE_FIRST = PROCESS.replace("= 50", "= 50\nfeed_mm = 0.2") + "feed_mm = 0.26\n"
NARROW = TOP.replace("8.5", "6.7").replace("91.4", "88")
FAR = TOP.replace("8.5", "14").replace("11", "66") + "feed_mm = 1.5\n"


@pytest.mark.parametrize(
    ("more", "process"),
    [
        (LOW + TOP, COARSE_FIRST),
        (LOW + TOP, FINE_FIRST),
        (FAR, "feed_mm = 0.1\ndepth_mm = 0.4\n"),
        (NARROW, "feed_mm = 0.1\n[tool]\nnose_radius_mm = 0.4\n"),
    ],
    ids=["coarse first", "fine first", "another feed", "a nose near a high band"],
)
def test_feeds_of_passes_and_bands_differ(more: str, process: str, tmp_path: Path) -> None:
    """Whatever the order, the stands of a band suit its coarsest pass."""
    assert form_um(cut_made(made_skirt(part_of(more, process)), tmp_path)) < 0.5


def test_a_round_band_does_not_mislead_the_controller(tmp_path: Path) -> None:
    """What the rehearsal has learned on the oval skirt holds: a round land shows no drive."""
    oval = {"height_mm": [0, 7.6], "ovality_mm": [0.288, 0.078]}
    profile = {"height_mm": [0, 7.6], "diameter_mm": [92, 92]}
    lands = [
        {"from_mm": 8.66, "to_mm": 11.58, "diameter_mm": 90.964, "feed_mm": 0.472},
        {"from_mm": 13.97, "to_mm": 15.47, "diameter_mm": 91.222, "ovality_mm": 0.271},
    ]
    process = {"spindle_rpm": 2500, "direction": -1, "u_zero": "mean"}
    passes = [{"allowance_um": 60, "feed_mm": 0.282}, {"allowance_um": 0, "feed_mm": 0.115}]
    changes = {"piston.profile": profile, "piston.ovality": oval, "piston.lands": lands}
    changes |= {f"process.{key}": value for key, value in (process | {"passes": passes}).items()}
    assert form_um(cut_made(made_skirt(changed(part_of(), changes)), tmp_path)) < 0.5


def test_x_keeps_the_tolerance_or_is_refused() -> None:
    """A corner of the profile costs at most half of the form error."""
    bent = {"height_mm": [0, 2.03, 6], "diameter_mm": [90, 92, 92], "interpolation": "linear"}
    part = changed(part_of(), {"piston.profile": bent})
    assert "unreachable for x" in refused(lambda: made_skirt(part))


def test_example_is_cut_in_one_program(tmp_path: Path) -> None:
    """The ring belt of tools/parts, by a table below 40 KiB."""
    made = made_skirt(load_part(PARTS / "belt86.toml"))
    assert written(made, tmp_path).stat().st_size < 40 << 10
    found = cut_made(made, tmp_path)
    assert form_um(found) < 0.05
    z_mm = found.surface["z_mm"]
    ends = [(0, 40), (43, 45.5), (47.25, 50.5), (51.75, 58)]
    assert all(((z_mm >= low) & (z_mm <= high)).sum() > 1000 for low, high in ends)


IN_GROOVE = """[[tolerances.zone]]
name = "a"
from_mm = 7
to_mm = 8
"""
GROOVE = TOP.replace("8.5", "6.4")


@pytest.mark.parametrize(
    ("more", "process", "line"),
    [
        (TOP.replace("8.5", "5.5"), PROCESS, "has no groove between 5.5 and 6 mm"),
        (TOP + "allowance_um = [0, 100]", PROCESS, "must fall from pass to pass, to 0"),
        (TOP.replace("8.5", "12"), PROCESS, "must be above from_mm = 12"),
        (TOP + "ovality_mm = 91.4", PROCESS, "must be smaller than its diameters"),
        (GROOVE, PROCESS, "in the groove from 6 to 6.4 mm the tool runs"),
        (TOP, PROCESS + "spindle_rpm = 900\n", "has one spindle_rpm for all"),
        (TOP, "feed_mm = 0.5\nrun_in_mm = 1\n", "runs into each band by itself"),
        (TOP, 'feed_mm = 0.5\npath = "ring-helix"\n', 'needs path = "helix"'),
        (
            TOP + '[piston.section]\nshape = "power"\nexponent = 3',
            PROCESS,
            "needs an oval alike at all heights",
        ),
        (TOP + "[piston.bore]\ndiameter_mm = 92.1", PROCESS, "drawn cold, bare and plain"),
        (TOP + "allowance_um = [900, 0]", PROCESS, "must be below 500, the stock of the blank"),
        (TOP + IN_GROOVE, PROCESS, "must lie within the part's heights, 0 .. 11 mm, and not in a"),
        (TOP + "feed_mm = 0.9\n[tool]\nnose_radius_mm = 0.4", PROCESS, "metal stays"),
        (TOP.replace("11", "1000"), "feed_mm = 0.05\n", "no table holds the turns"),
    ],
)
def test_refusals(more: str, process: str, line: str) -> None:
    """Each names what is wrong before anything is made."""
    assert line in refused(lambda: made_skirt(part_of(more, process)), CamtoolsError)


def test_a_nose_needs_room_in_the_groove() -> None:
    """A nose of 0.8 mm on a land 0.6 mm deeper comes within sqrt(0.6) mm of the skirt."""
    process = "feed_mm = 0.2\ndepth_mm = 0.2\n[tool]\nnose_radius_mm = 0.8\n"
    part = part_of(process=process)
    low, top = part.piston.lands
    lower = {"diameter_mm": 90.8, "to_mm": 11.0}
    for gap_mm, fits in ((1.42, True), (1.36, False)):
        land = top.model_dump() | lower | {"from_mm": 6 + gap_mm, "allowance_um": []}
        narrow = changed(part, {"piston.lands": [low.model_dump(), land]})
        if fits:
            made_skirt(narrow)
        else:
            assert "its nose needs 0.7" in refused(partial(made_skirt, narrow))


def test_what_has_one_band_refuses_lands(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """They are refused with their key; exports and corrections need one band, too."""
    part, folder = str(PARTS / "belt86.toml"), str(tmp_path / "made")
    assert mkgcode([part, "-o", str(tmp_path / "belt.ngc")]) == 2
    assert "piston.land: is played by the controller alone" in capsys.readouterr().err
    assert analyse([part, "-o", folder]) == 2
    assert "piston.land: is not analysed" in capsys.readouterr().err
    assert run([part, "-o", folder, "--feed", "0.1"]) == 2
    assert "--feed: has no meaning with [[piston.land]]" in capsys.readouterr().err
    assert mktables([part, "-o", folder, "--export", "xyva"]) == 2
    assert "--export: the table of a part with [[piston.land]]" in capsys.readouterr().err
    assert mktables([part, "-o", folder, "--measured", str(tmp_path / "surface.csv")]) == 2
    assert "--measured: has no meaning with [[piston.land]]" in capsys.readouterr().err
    assert not Path(folder).exists()
