"""Axes by hand with tools/camctl, against the firmware with an ideal machine."""

import re
import signal
import threading
import time

import pytest

from tests.tools.cases.camctl_bench import Bench, Refusal, act_when
from tests.tools.cases.camsim_cases import ROOT


def places(bench: Bench) -> dict[str, tuple[float, float, bool]]:
    """Return of each axis the machine's and the part's number, and whether it is homed."""
    pattern = r"(\w) (\S+) mm, of the part (\S+) mm, (not )?homed"
    found = re.findall(pattern, bench.do("where"))
    return {axis: (float(a), float(b), not no) for axis, a, b, no in found}


def test_an_axis_is_jogged_for_a_time_and_by_steps(bench: Bench) -> None:
    """In both senses; a step ends where it should; then off."""
    assert bench.do("manual") == "manual: manual\n"
    x = places(bench)["x"][0]
    assert x == pytest.approx(60, abs=1e-6)
    assert bench.do("jog", "x", "+", "--speed", "5", "--seconds", "0.4").startswith("x ")
    assert places(bench)["x"][0] - x > 0.5
    there = places(bench)["x"][0]
    time.sleep(0.1)
    assert places(bench)["x"][0] == there
    assert bench.do("jog", "x", "--step", "-0.125") == f"x {there - 0.125:.6f} mm\n"
    bench.do("jog", "z", "-", "--seconds", "0.2")
    assert places(bench)["z"][0] < -0.05
    assert bench.do("disable") == "disable: off\n"


def test_control_c_ends_a_jog_that_is_held(bench: Bench) -> None:
    """The command ends with status 0 and the axis stands."""
    bench.do("manual")
    z_mm = places(bench)["z"][0]
    act_when(
        bench,
        lambda status: status.signals.get("z", z_mm) > z_mm + 0.3,
        lambda: signal.raise_signal(signal.SIGINT),
    )
    assert bench.do("jog", "z", "+", "--speed", "2").startswith("z ")
    z = places(bench)["z"][0]
    assert z_mm + 0.3 < z < z_mm + 2.5
    assert places(bench)["z"][0] == z


def test_axes_are_homed(bench: Bench, refusal: Refusal) -> None:
    """By switch and index, by switch, and where it stands; what is not homed refuses the cut."""
    bench.do("set", "homing_required", "1")
    for name, value in (
        *(("x_home", 3), ("x_home_nm", 200_000_000), ("x_home_slow_um_per_s", 5000)),
        *(("u_home", 2), ("z_home", 1), ("z_home_nm", -7_000_000)),
    ):
        bench.do("set", name, str(value))
    assert "not homed; in manual, home every axis" in refusal(bench, 1, "enable")
    bench.do("manual")
    assert "set x_low_nm" not in bench.do("home", "x")
    assert bench.do("home", "u").startswith("home u ")
    assert bench.do("home", "z") == "home z -7.000000 mm\n"
    now = places(bench)
    assert all(homed for _, _, homed in now.values())
    assert now["x"][0] == pytest.approx(200, abs=0.3)
    assert "homed             u, x, z" in bench.do("status")
    bench.do("disable")
    # The part's numbers are the machine's by now, where the drawing's 46 mm would be 154 mm off.
    bench.do("set", "x_datum_nm", str(-139_000_000))
    bench.do("set", "z_datum_nm", str(7_000_000))
    assert bench.do("home") == "home: ready\n"
    assert bench.do("start").splitlines()[-1].startswith("start: part cut, ")


def test_a_home_that_is_not_found_says_why(bench: Bench, refusal: Refusal) -> None:
    """Z has no switch; after its travel the axis stands, and is not homed."""
    bench.do("manual")
    assert "home axis: refused: home none; set u_home" in refusal(bench, 1, "home z")
    bench.do("set", "z_home", "2")
    bench.do("set", "z_home_travel_nm", "2000000")
    assert "home z: no home switch or stop within the travel" in refusal(bench, 1, "home z")
    assert not places(bench)["z"][2]


def test_zero_and_tools_move_the_part(bench: Bench, refusal: Refusal) -> None:
    """A datum follows from diameter and height, a tool adds its offsets, within their ranges."""
    before = places(bench)
    assert "datum -19.994000 mm" in bench.do("zero", "x", "--diameter", "80.012")
    assert "datum 12.000000 mm" in bench.do("zero", "z", "--height", "12")
    now = places(bench)
    assert [now[a][0] for a in "uxz"] == [before[a][0] for a in "uxz"]
    assert now["x"][1] == pytest.approx(40.006, abs=1e-6)
    text = bench.do("tool", "2", "--x", "-0.5", "--z", "1.25")
    assert "tool 2: x -0.500000 mm, z 1.250000 mm, in use" in text
    now = places(bench)
    assert now["x"][1] == pytest.approx(39.506, abs=1e-6)
    assert now["z"][1] == pytest.approx(13.25, abs=1e-6)
    assert "diameter 79.012000 mm at U = 0, tool 2" in bench.do("status")
    assert "no tool is in use" in bench.do("tool", "0")
    assert "give --diameter" in refusal(bench, 2, "zero x --height 3")
    assert "give the number of a tool" in refusal(bench, 2, "tool --x 3")
    assert "tool_2_x_nm is -500000000 .. 500000000" in refusal(bench, 1, "tool 2 --x 1e12")
    bench.do("manual")
    bench.do("jog", "z", "--step", f"{-0.5 - before['z'][0]}")
    line = refusal(bench, 1, "zero z --height 1000")
    assert "z_datum would leave -1000 .. 1000 mm" in line


def test_limits_of_speed_and_travel_are_told(bench: Bench, refusal: Refusal) -> None:
    """In millimetres, as the command; a jog to the limit stands there."""
    assert "state off; give manual first" in refusal(bench, 1, "jog x + --speed 1")
    bench.do("set", "z_low_nm", "-1000000")
    bench.do("set", "z_high_nm", "1000000")
    bench.do("manual")
    assert "this axis moves at most 10 mm/s" in refusal(bench, 1, "jog z + --speed 11")
    assert "its travel ends at 0.9999" in refusal(bench, 1, "jog z --step 1.5")
    assert "at the limit of its travel" in bench.do("jog", "z", "+", "--speed", "10")
    assert "give either + or -" in refusal(bench, 2, "jog z")
    assert "no --speed" in refusal(bench, 2, "jog z --step 1 --speed 3")


def test_an_emergency_stop_ends_a_jog(bench: Bench, refusal: Refusal) -> None:
    """The command ends with status 1 and names the fault."""
    bench.do("manual")
    threading.Timer(0.3, bench.estop, [True]).start()
    line = refusal(bench, 1, "jog z + --speed 5 --seconds 5")
    assert "state" in line
    assert "state             fault" in bench.do("status")


def by_hand() -> list[str]:
    """Return the commands of the manual's section on axes by hand, without tools/camctl."""
    manual = (ROOT / "tools" / "docs" / "CAMCTL.md").read_text("utf-8")
    section = manual.partition("\n## By hand, from power-on to the first cut\n")[2]
    block = section.partition("\n## ")[0]
    lines = [line.partition("#") for line in block.splitlines() if line.startswith("    ")]
    found = []
    for line, _, comment in lines:
        # Nobody is there to press control-C.
        end = " --seconds 0.3" if comment.startswith(" until control-C") else ""
        found += [f"{one.strip()}{end}" for one in line.split("&&")]
    assert all(one.startswith("tools/camctl ") for one in found)
    return [one.removeprefix("tools/camctl ") for one in found]


def test_the_manual_from_power_on_to_the_first_cut(bench: Bench) -> None:
    """Its commands by hand succeed as they are printed; they leave the axes where they belong."""
    commands = by_hand()
    assert {"home u", "home x", "home z", "zero z --height 0"} <= set(commands)
    for name, value in (("u_home", 2), ("x_home", 2), ("x_home_nm", 61_000_000), ("z_home", 1)):
        bench.do("set", name, str(value))
    for one in commands:
        bench.do(*one.split())
    now = places(bench)
    assert all(homed for _, _, homed in now.values())
    radius_mm = now["x"][1] - now["u"][0]
    assert (radius_mm, now["z"][1]) == pytest.approx((40.006, 0.0), abs=2e-6)
    assert "state             off" in bench.do("status")
