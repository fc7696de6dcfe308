"""NC programs of cams: X over C and the swing, times, read back by us and by LinuxCNC."""

from pathlib import Path

import numpy as np
import pytest

from camtools.base.quantities import Floats
from camtools.cli.mkgcode import main
from camtools.ngc.gcode_words import CLEARANCE_MM, ENGAGE_TURNS
from tests.tools.cases.linuxcnc import AXES, Interpreter
from tests.tools.cases.lobe_tables import DISC, POLY345
from tests.tools.cases.ngc_cases import changed, moves
from tests.tools.cases.part_cases import ROOT, Capture

PARTS = ROOT / "tools" / "parts"


def made(folder: Path, name: str, *words: str, **changes: str) -> Path:
    """Return the program of a part of the repository, values of its file replaced."""
    part, program = changed(folder, PARTS / f"{name}.toml", **changes), folder / "part.ngc"
    assert main([str(part), "-o", str(program), *words]) == 0
    return program


def disc_mm(c_rad: Floats) -> Floats:
    """Return the exact distance of a wheel of 200 from the axis of a disc of 25, 5 off."""
    exact = 5 * np.cos(c_rad) + np.sqrt(225**2 - (5 * np.sin(c_rad)) ** 2)
    return np.asarray(exact, dtype=np.float64)


@pytest.mark.parametrize("direction", ["1", "-1"])
def test_ground_disc_is_the_exact_solution(tmp_path: Path, direction: str) -> None:
    """X over C is the disc's for M3 and M4 alike, at every point and on every chord."""
    program = made(tmp_path, "cam-disc", direction=direction, feed_mm="2", phase_deg="30")
    c, x, z, f = moves(program, "G1", "CXZF").T
    sign = int(direction)
    assert (np.diff(sign * c) > 0).all()
    exact = disc_mm(np.radians(c - 30)) - 200
    cut = (sign * c >= 0) & (sign * c <= 6 * 360)
    assert z[cut][-1] == 12
    assert np.abs(x - exact)[cut].max() < 2e-6
    assert (x > exact - 2e-6).all()  # never a gouge
    assert x[-1] == pytest.approx(20 + 10 + 0.1 + CLEARANCE_MM)
    dense = np.linspace(c[cut].min(), c[cut].max(), 200_001)
    order = np.argsort(c)
    chord = np.interp(dense, c[order], x[order]) - (disc_mm(np.radians(dense - 30)) - 200)
    assert np.abs(chord).max() <= 0.1e-3 + 2e-6
    speed = np.abs(np.radians(np.diff(c))) * f[1:] / 60
    assert 4.8 < speed.min() < speed.max() < 5.2


def test_times_are_those_of_constant_surface_speed(tmp_path: Path) -> None:
    """60 / F of the blocks between two rows of the worked table is the integral of its N_C."""
    program = made(tmp_path, "cam-disc", feed_mm="2", spindle_acceleration_rad_s2="10000")
    c, f = moves(program, "G1", "CF").T
    first = ENGAGE_TURNS * int((c <= -(ENGAGE_TURNS - 1) * 360 + 1e-6).sum()) - 1
    assert c[first] == 0
    turn = slice(first + 1, first + 1 + int((c <= -(ENGAGE_TURNS - 1) * 360 + 1e-6).sum()))
    ends, times = c[turn], np.cumsum(1 / f[turn]) * 60
    table = np.array([[float(word) for word in line.split()] for line in DISC])
    phi, rpm = table[:, 4], table[:, 8]
    # Simpson's rule over the half turn, on the table's uneven angles refined by a cubic.
    dense = np.linspace(0, 180, 18_001)
    slow = np.interp(dense, phi, 1 / rpm)
    expected = float(np.sum((slow[1:] + slow[:-1]) / 2) * 0.01 / 360 * 60)
    assert float(np.interp(180, ends, times)) == pytest.approx(expected, rel=2e-4)
    assert times[-1] == pytest.approx(2 * expected, rel=2e-4)


def test_turned_lobe_swings_by_the_pressure_angle(tmp_path: Path) -> None:
    """X is base circle and lift, B the swing, at the worked table's angles; times are even."""
    program = made(tmp_path, "cam-345", "--chord-um", "0.02", feed_mm="2")
    c, x, b, f = moves(program, "G1", "CXBF").T
    turn = (c >= 0) & (c <= 360)
    for line in POLY345:
        theta, lift, swing = map(float, line.split()[:3])
        at = np.mod(theta, 360)
        assert np.interp(at, c[turn], x[turn]) == pytest.approx(20 + lift, abs=3e-5)
        assert np.interp(at, c[turn], b[turn]) == pytest.approx(swing, abs=2e-3)
    rpm = np.diff(c) * f[1:] / 360
    np.testing.assert_allclose(rpm, 60, rtol=1e-6)


def test_both_senses_cut_the_same_lobe(tmp_path: Path) -> None:
    """M4 passes the same angles the other way: X and the swing stand at the same C, off phase 0."""
    found = []
    for direction in ("1", "-1"):
        changes = {"direction": direction, "feed_mm": "3", "phase_deg": "40"}
        c, x, b = moves(made(tmp_path, "cam-345", **changes), "G1", "CXB").T
        turn = (int(direction) * c >= 360) & (int(direction) * c < 720)
        order = np.argsort(np.mod(c[turn], 360))
        at = np.mod(c[turn], 360)[order]
        grid = np.linspace(1, 359, 359)
        found.append([np.interp(grid, at, one[turn][order]) for one in (x, b)])
    (x_one, b_one), (x_other, b_other) = found
    assert np.abs(x_one - x_other).max() < 0.3e-3
    assert np.abs(b_one - b_other).max() < 0.01
    assert grid[int(np.argmax(x_one))] == pytest.approx(40, abs=1)
    assert b_one[9] > 15 > -15 > b_one[69]  # rising before the nose, 30 degrees to either side


def test_flanks_of_the_ground_lobe_are_within_the_spindle(tmp_path: Path) -> None:
    """From block to block the speed keeps the spindle's 60 rad/s2; it is nowhere above N_C."""
    c, f = moves(made(tmp_path, "cam-345-ground", feed_mm="2"), "G1", "CF").T
    omega = np.radians(np.diff(c)) * f[1:] / 60
    seconds = 60 / f[1:]
    alpha = np.diff(omega) / ((seconds[1:] + seconds[:-1]) / 2)
    assert np.abs(alpha).max() < 60 * 1.02
    assert omega.max() / (2 * np.pi / 60) < 104.24 * 1.02


@pytest.mark.parametrize(
    ("name", "words"), [("cam-disc", ("--diameter",)), ("camshaft", ()), ("cam-345", ())]
)
def test_programs_by_linuxcnc(
    tmp_path: Path, linuxcnc: Interpreter, name: str, words: tuple[str, ...]
) -> None:
    """LinuxCNC's interpreter accepts them and goes where our reading goes, X as a radius."""
    program = made(tmp_path, name, *words, feed_mm="2")
    message, points = linuxcnc.points(program)
    assert message == ""
    is_feed = points[:, 0] == 1
    at = dict(zip(AXES, points[is_feed][:, 1:].T, strict=True))
    letters = "CXZB" if name == "cam-345" else "CXZ"
    ours = moves(program, "G1", letters)
    if words:
        ours[:, 1] /= 2
    theirs = np.stack([at[letter] for letter in letters], axis=1)
    np.testing.assert_allclose(theirs, ours, atol=1e-9)
    done = linuxcnc.rs274(program)
    assert done.returncode == 0, done.stderr
    if name == "cam-disc":
        cut = (at["C"] >= 0) & (at["C"] <= 6 * 360)
        exact = disc_mm(np.radians(at["C"][cut])) - 200
        assert np.abs(at["X"][cut] - exact).max() < 2e-6


def test_flat_faced_lobe_is_ground_along_its_envelope(tmp_path: Path) -> None:
    """X of the wheel is the least at which it does not cut the profile of the support function."""
    changes = {"base_radius_mm": '40\nfollower = "flat"', "feed_mm": "3"}
    c, x = moves(made(tmp_path, "cam-345-ground", **changes), "G1", "CX").T
    alpha = np.radians(np.linspace(-180, 180, 36_001))
    u = np.clip(1 - np.abs(alpha) / np.radians(70), 0, 1)
    s = 40 + 8 * u**3 * (10 - 15 * u + 6 * u**2)
    s1 = -np.sign(alpha) * 8 / np.radians(70) * 30 * u**2 * (1 - u) ** 2
    rho, psi = np.hypot(s, s1), alpha + np.arctan2(s1, s)
    for i in np.flatnonzero((c >= 0) & (c < 360))[::40]:
        off = psi - np.radians(c[i])
        inside = np.maximum(200**2 - (rho * np.sin(off)) ** 2, 0)
        needed = float((rho * np.cos(off) + np.sqrt(inside)).max())
        assert x[i] + 200 == pytest.approx(needed, abs=2e-5)


def test_lobes_follow_each_other(tmp_path: Path) -> None:
    """Between two lobes the wheel is off the nose, C goes on, and the phase is the lobe's own."""
    program = made(tmp_path, "camshaft", feed_mm="1")
    text = program.read_text()
    assert text.count("G93\n") == text.count("G94 G0 X30.1") == 3
    c, x, z = moves(program, "G1", "CXZ").T
    assert (np.diff(c) > 0).all()
    for low, high, phase_deg, lift in ((0, 3, 0, 8), (5, 8, 120, 8), (10, 13, -95, 6)):
        here = (z > low + 0.5) & (z < high - 0.5)
        top = int(np.argmax(x[here]))
        assert x[here][top] == pytest.approx(20 + lift, abs=2e-4)
        off = np.mod(c[here][top] - phase_deg + 180, 360) - 180
        assert abs(off) < 1.0


@pytest.mark.parametrize(
    ("changes", "told"),
    [({"spindle_rpm": "299"}, "swing_acceleration_deg_s2"), ({"u_stroke_mm": "15"}, "u_stroke_mm")],
)
def test_what_cannot_be(
    tmp_path: Path, changes: dict[str, str], told: str, capsys: Capture
) -> None:
    """File, what is wrong and what helps; status 2, no program."""
    with pytest.raises(AssertionError):
        made(tmp_path, "cam-345", **changes)
    assert told in capsys.readouterr().err
    assert not (tmp_path / "part.ngc").exists()
