"""Plunge grinding: infeed and spark-out by the turn, wheel width and wear, Z that stands."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError
from camtools.lobe.generate import GeneratedLobes, generate_lobes
from camtools.lobe.kind import KIND
from camtools.lobe.plunge import left_by_wear_um
from camtools.lobe.summary import design_of_lobes, make_lobe_summary
from camtools.ngc.lobe_program import LobeJob, lobe_program
from camtools.pipeline.load import Made
from camtools.sim.binding import Rows
from camtools.table.channel import ImageError
from camtools.table.header import with_bounds
from camtools.table.image import pack, unpack
from tests.tools.cases.camsim_cases import ROOT, camsim, cut, refusal, while_in
from tests.tools.cases.cut_cases import made_of, written
from tests.tools.cases.lobe_cases import MACHINE, cam, evaluate
from tests.tools.cases.part_cases import sure

TEXT = (ROOT / "tools" / "parts" / "camshaft-plunge.toml").read_text()
# two narrow lobes at a high speed, so that a cut is short
SHORT = re.sub(r"\[\[cam.lobe\]\]\nz_mm = \[62.*?\n\n", "", TEXT, flags=re.DOTALL)
SHORT = SHORT.replace("spindle_rpm = 40", "spindle_rpm = 90")


@pytest.fixture(scope="module")
def made() -> GeneratedLobes:
    """Return the table of the part."""
    found: GeneratedLobes = made_of("camshaft-plunge").table
    return found


def text_of(text: str, **keys: object) -> str:
    """Return a part file with other values."""
    for key, value in keys.items():
        text, n = re.subn(rf"(?m)^{key} = .*$", f"{key} = {value}", text)
        assert n, key
    return text


def run(folder: Path, made: GeneratedLobes, wear_um: float) -> tuple[dict[str, Any], Rows]:
    """Return summary and trace of a cut whose wheel wears."""
    image = written(Made(KIND, made), folder)
    machine = KIND.machine(made.part).split("[wheel]")[0]
    machine = re.sub(r"(?m)^ripple = .*$", "ripple = 0.0", machine)
    machine += f"[wheel]\nwear_um_per_lobe = {wear_um!r}\n"
    words = ("--no-learning", "--trace-every", 20)
    found = cut(image, *words, machine=machine, status=None, tables=["trace"])
    return found.summary, while_in(found.trace, "cutting")


@pytest.mark.long
def test_infeed_and_spark_out_are_exact_by_the_turn(tmp_path: Path) -> None:
    """Measured from the trace: Z stands, X falls by the infeed in each turn, then rests."""
    text = SHORT.replace("spindle_rpm = 90", "spindle_rpm = 90\ndirection = -1")
    made = generate_lobes(cam(text))
    plan = sure(made.plunge)
    summary, trace = run(tmp_path, made, 5.0)
    assert summary["end"] == "done"
    assert [one["samples"] for one in summary["cam"]["lobes"]] == [3600, 3600]
    assert max(one["max_um"] for one in summary["cam"]["lobes"]) < 0.1
    turn = np.abs(trace["turn"])
    for i, middle_mm in enumerate((7.0, 37.0)):
        base_nm = (20 + 200 - 0.005 * i) * 1e6
        stands = np.abs(trace["out_z_nm"] - middle_mm * 1e6) <= 1
        x_nm, at = trace["out_x_nm"][stands] - base_nm, turn[stands]
        before = np.interp(at - 1, at, x_nm)
        inside = (at > at[0] + 1) & (x_nm < 150e3) & (x_nm > 30e3) & (at < at[x_nm.argmin()])
        falls = before[inside] - x_nm[inside]
        even = falls[(before[inside] < 200e3)]
        assert even.size > 100 and np.abs(even - 20e3).max() < 60
        rests = np.abs(x_nm) < 2
        assert at[rests].max() - at[rests].min() == pytest.approx(3.0, abs=0.3)
        assert stands.sum() > 0.8 * plan.stay_turns / plan.turns(2) * turn.size


@pytest.mark.long
def test_wear_shows_when_nothing_follows_it(tmp_path: Path) -> None:
    """The same table on a wheel that does not wear: the second lobe is cut too deep by the step."""
    made = generate_lobes(cam(SHORT))
    summary, _ = run(tmp_path, made, 0.0)
    lobes = summary["cam"]["lobes"]
    assert lobes[0]["max_um"] < 0.1 and lobes[1]["max_um"] == pytest.approx(5.0, abs=0.1)
    assert summary["form_error_um"]["max"] == pytest.approx(5.0, abs=0.1)


def test_bound_of_what_the_worn_wheel_leaves_holds() -> None:
    """What the smaller wheel leaves on the normal of each contact, MATHS.md (120)."""
    made = generate_lobes(cam(text_of(TEXT, wheel_wear_um_per_lobe=200)))
    bound = left_by_wear_um(made.part, made.lobes)
    lobe, wear_mm = made.lobes[2], 0.4
    phi = np.linspace(0, 2 * np.pi, 7201)
    path = lobe.at(phi)
    far = lobe.base_mm + lobe.follower_mm + path.lift
    centre = (far - wear_mm) * np.exp(1j * phi)
    normal = np.exp(1j * (phi - path.angle))
    foot = far * np.exp(1j * phi) - lobe.follower_mm * normal
    off = ((centre - foot) * normal.conj()).real
    across = ((centre - foot) * normal.conj()).imag
    left_um = 1000 * (off - np.sqrt((lobe.follower_mm - wear_mm) ** 2 - across**2))
    assert left_um.min() > -1e-6 and left_um.max() == pytest.approx(bound, rel=1e-6)


def test_eval_speaks_of_the_station(made: GeneratedLobes, tmp_path: Path) -> None:
    """X of a lobe rests on the drawing's base during the spark-out; u is the lift by then."""
    plan = sure(made.plunge)
    first = made.table.lobes[1].z_first_nm
    rests = plan.off_turns + plan.infeed_turns + 2
    s_mm = np.array([first + rests * plan.feed_nm, first]) / 1e6
    found = evaluate(tmp_path, made, np.array([120 / 360, 0.0]), s_mm)
    assert found["u_nm"][0] == pytest.approx(8e6, abs=20)
    assert found["x_nm"][0] == pytest.approx(219.995e6, abs=1)
    assert found["x_nm"][1] == pytest.approx(219.995e6 + plan.clear_mm * 1e6, abs=2)


REFUSED = [
    (
        "width_mm = 16",
        "width_mm = 13.9",
        r"width_mm = 13.9: lobe 0 is 14 mm wide; give at least 14",
    ),
    (
        "width_mm = 16",
        "width_mm = 46.1",
        r"reaches 23.05 mm to each side, lobe 1 begins 23 mm away",
    ),
    ("stock_um = 200", "stock_um = 9000", r"infeed_um = 1: the cut takes \d+ turns, more than"),
    ('"plunge-grinding"', '"grinding"', r"infeed_um = 20.*: has no meaning for operation"),
    ("infeed_um = 20\n", "", r"process.infeed_um: is missing for operation"),
    ("wheel_width_mm = 16\n", "", r"cam.wheel_width_mm: is missing for operation"),
    ("infeed_um = 20\n", "infeed_um = 20\nfeed_mm = 1\n", r"feed_mm = 1.*: has no meaning"),
    ("infeed_um = 20\n", 'infeed_um = 20\nspeed = "constant-surface"\n', r"at uniform speed"),
]


@pytest.mark.parametrize(("old", "new", "told"), REFUSED)
def test_what_cannot_be_ground_is_refused_with_numbers(old: str, new: str, told: str) -> None:
    """A wheel too narrow or too wide, too many turns, keys that do not belong together."""
    text = TEXT.replace(old, new)
    assert text != TEXT
    with pytest.raises(CamtoolsError, match=told):
        generate_lobes(cam(text_of(text, infeed_um=1) if "9000" in new else text))


def test_no_program_is_written_for_a_plunge_cut(made: GeneratedLobes, tmp_path: Path) -> None:
    """It would feed Z over the lobe; a measured Z does not tell the turns."""
    image = written(Made(KIND, made), tmp_path)
    line = refusal(image, "--machine", MACHINE, "--set", "z_is_measured=1")
    assert "a measured Z cannot" in line
    with pytest.raises(CamtoolsError, match="plunge-grinding"):
        lobe_program(LobeJob(cam(TEXT), 0.001, False))


def test_format_takes_stations_of_lobes_alone(made: GeneratedLobes, tmp_path: Path) -> None:
    """What the check of the generator and that of the firmware refuse; both take the table."""
    table = made.table
    assert unpack(pack(table)).has_stations
    way = sure(table.way)
    turned = way.knots.copy()
    turned[5:, 0, 0] -= 50_000
    back = with_bounds(replace(way, knots=turned))
    others = tuple(one for one in table.channels if one is not way)
    image = tmp_path / "bad.camtab"
    image.write_bytes(pack(replace(table, channels=(*others, back))))
    with pytest.raises(ImageError, match="way"):
        unpack(image.read_bytes())
    done = camsim("eval", image, stdin="turn,z_mm\n0,0\n")
    assert done.returncode == 2 and "channel" in done.stderr


def test_summary_tells_the_turns(made: GeneratedLobes) -> None:
    """Stock, infeed and spark-out of a lobe; the gauge is told that the wheel stands."""
    found = make_lobe_summary(made)["plunge"]
    assert found["infeed_turns"] == 10 and found["spark_out_turns"] == 3
    assert found["turns_per_lobe"] == 10 + 1 + 3 + 2 * found["clearing_turns"]
    assert found["grinding_s"] == pytest.approx(found["turns"] * 1.5)
    assert design_of_lobes(made)["path"] == "plunge"
