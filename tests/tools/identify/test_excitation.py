"""Excitations of U: waves and plans within limits, records of them, drives simulated and on CAN."""

import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from camtools.base.errors import CamtoolsError
from camtools.identify.configured_drive import Believed, with_keys
from camtools.identify.drives import ConnectedU, CutShortError, SimulatedU
from camtools.identify.excitation_plan import Excitation, Wishes, excited, plan
from camtools.identify.fit import FRICTION, K1, K2, LEAD
from camtools.identify.identified import Identified, identify
from camtools.identify.recording import CARRIER_LINE, Grid, multisine, record_of
from camtools.link.controller import Link
from camtools.link.messages import Refused
from camtools.sim.machine_file import machine_bytes, names
from camtools.table.image import pack
from checks.patience import limit_s
from tests.tools.cases.camctl_bench import Bench, ready
from tests.tools.cases.cut_cases import skirt_of
from tests.tools.cases.part_cases import refused


@pytest.mark.parametrize("tick_hz", [20_000.0, 40_000.0, 10_000.0, 5000.0, 7777.0, 100_000.0])
def test_only_odd_lines_and_the_carrier_are_excited(tick_hz: float) -> None:
    """Flat up to 100 Hz, then with 1/f; nothing elsewhere but rounding."""
    grid = Grid.of(tick_hz)
    wave = multisine(grid, 25_000.0, 150_000.0)
    assert wave.u_nm.size == grid.n_ticks
    amplitude = np.abs(np.fft.rfft(wave.u_nm)) * 2 / grid.n_ticks
    assert amplitude[CARRIER_LINE] == pytest.approx(150_000.0, abs=1.0)
    flat = amplitude[1]
    for i in grid.bins:
        hz = i * grid.line_hz
        assert amplitude[i] == pytest.approx(flat * min(1.0, 100.0 / hz), abs=1.0)
    amplitude[grid.excited] = 0.0
    assert amplitude.max() < 1.0
    assert grid.bins[-1] * grid.line_hz <= min(700.0, tick_hz / 12)


def test_amplitude_crest_and_quantum() -> None:
    """Parseval; random phases have a crest of 3, Schroeder's 1.7; the scale's quantum is kept."""
    grid = Grid.of(20_000.0)
    wave = multisine(grid, 25_000.0, 300_000.0)
    spectrum = np.fft.rfft(wave.u_nm)
    spectrum[CARRIER_LINE] = 0
    assert np.std(np.fft.irfft(spectrum)) == pytest.approx(25_000.0, rel=1e-4)
    wave = multisine(grid, 25_000.0, 0.0)
    line = np.zeros(grid.n_ticks // 2 + 1, complex)
    line[grid.bins] = np.fft.rfft(wave.u_nm)[grid.bins] * (2j * np.pi * grid.bins * 5.0) ** 2
    acceleration = np.fft.irfft(line)
    assert np.max(np.abs(acceleration)) / np.std(acceleration) < 1.68
    wave = multisine(Grid.of(20_000.0), 50_000.0, 300_000.0, quantum_nm=1000.0)
    assert np.all(wave.u_nm % 1000 == 0)


def test_peaks_are_those_of_the_wave() -> None:
    """Travel, speed and acceleration against differences of a finely ticked wave."""
    grid = Grid.of(100_000.0)
    wave = multisine(grid, 1e6, 3e6)
    u_mm = wave.u_nm * 1e-6
    speed = np.gradient(np.tile(u_mm, 3), 1 / grid.tick_hz)
    acceleration = np.gradient(speed, 1 / grid.tick_hz)[grid.n_ticks : 2 * grid.n_ticks]
    assert wave.peaks.travel_mm == pytest.approx(np.max(np.abs(u_mm)), rel=0.01)
    assert wave.peaks.speed_mm_s == pytest.approx(np.max(np.abs(speed)), rel=0.01)
    assert wave.peaks.acceleration_mm_s2 == pytest.approx(np.max(np.abs(acceleration)), rel=0.01)


DEFAULT = Believed(20_000.0, 742_723, 281_448, 100_000, 0, 10, 1_200_000, 400_000, 250_000)


def within(excitation: Excitation, believed: Believed) -> bool:
    """Return whether a wave keeps to stroke, speed and acceleration."""
    peaks = excitation.wave.peaks
    far_nm = abs(excitation.play.place_nm) + peaks.travel_mm * 1e6
    return (
        far_nm <= believed.u_stroke_nm / 2
        and peaks.speed_mm_s * 1e3 <= believed.u_speed_um_per_s
        and peaks.acceleration_mm_s2 <= believed.u_acceleration_mm_per_s2
    )


def test_amplitude_is_that_of_the_scale() -> None:
    """25 um, and as much of 100 um as 250 m/s2 allow for a scale of 1 um."""
    assert plan(DEFAULT, Wishes()).wave.rms_nm == 25_000
    coarse = plan(replace(DEFAULT, u_scale_nm=1000), Wishes())
    assert 35_000 < coarse.wave.rms_nm < 40_000
    assert within(coarse, DEFAULT)
    strong = replace(DEFAULT, u_scale_nm=1000, u_acceleration_mm_per_s2=2_000_000)
    strong = replace(strong, u_speed_um_per_s=1_000_000, u_stroke_nm=2_000_000)
    assert plan(strong, Wishes()).wave.rms_nm == 100_000


@pytest.mark.parametrize("stroke_nm", [30_000, 100_000, 800_000, 24_000_000])
@pytest.mark.parametrize("speed_um_per_s", [5000, 400_000])
@pytest.mark.parametrize("acceleration_mm_per_s2", [5000, 20_000, 2_000_000])
def test_limits_are_kept(stroke_nm: int, speed_um_per_s: int, acceleration_mm_per_s2: int) -> None:
    """Whatever they are, or it is refused with the amplitude that is left."""
    believed = replace(
        DEFAULT,
        u_stroke_nm=stroke_nm,
        u_speed_um_per_s=speed_um_per_s,
        u_acceleration_mm_per_s2=acceleration_mm_per_s2,
    )
    try:
        assert within(plan(believed, Wishes()), believed)
    except CamtoolsError as error:
        assert "U: its limits leave 0." in str(error)


@pytest.mark.parametrize(
    ("wishes", "says"),
    [
        (Wishes(rms_nm=60_000), "--rms-um 60: too large: acceleration of U 3"),
        (Wishes(rms_nm=25_000, carrier_nm=600_000), "--rms-um 25: too large: travel of U 1.3"),
    ],
)
def test_what_is_asked_for_is_checked(wishes: Wishes, says: str) -> None:
    """With the numbers and the remedy."""
    line = refused(lambda: plan(DEFAULT, wishes))
    assert line.startswith(says) and "; give at most --rms-um " in line


GRID = Grid.of(20_000.0)
WAVE = np.tile(multisine(GRID, 25_000.0, 1e5).u_nm, 5).astype(float)
TICKS = np.arange(WAVE.size)


def test_whole_periods_at_the_end_are_taken() -> None:
    """What comes before is left out; means are taken away."""
    record = record_of(GRID, TICKS[100:], WAVE[100:] + 7, WAVE[100:] + 9, 10.0)
    assert record.u_nm.shape == (4, GRID.n_ticks)
    assert record.settled[0].shape == (3, GRID.n_ticks)
    assert abs(record.period_nm.mean()) < 1e-6


@pytest.mark.parametrize(
    ("ticks", "u", "y", "says"),
    [
        (np.append(TICKS[:-1], TICKS[-1] + 3), WAVE, WAVE, "1 gap, the first after tick 19998"),
        (TICKS[:9000], WAVE[:9000], WAVE[:9000], "9000 ticks are 2 periods, a fit needs 3"),
        (TICKS, WAVE * (1 + 1e-6 * TICKS), WAVE, "the set-points of two periods differ by"),
        (TICKS, 0 * WAVE, WAVE, "U was not excited"),
        (TICKS, WAVE, 0 * WAVE, "U did not move"),
    ],
)
def test_bad_records_are_refused(
    ticks: np.ndarray, u: np.ndarray, y: np.ndarray, says: str
) -> None:
    """One line each, with a remedy."""
    line = refused(lambda: record_of(GRID, ticks, u, y, 10.0))
    assert says in line and "; " in line


MACHINE = """\
[machine]
tick_hz = {tick_hz}
[u]
bandwidth_hz = {hz}
damping = {damping}
delay_us = {delay_us}
friction_m_per_s2 = {friction}
quantum_nm = {quantum_nm}
{more}
[believed.u]
bandwidth_hz = 270
damping = 0.8
delay_us = 60
"""
DRIVE: dict[str, float | str] = {"tick_hz": 20_000, "hz": 300.0, "damping": 0.7, "delay_us": 75.0}
DRIVE |= {"friction": 5, "quantum_nm": 10, "more": ""}


def simulated(folder: Path, text: str, *options: str) -> SimulatedU:
    """Return U of a machine."""
    table = skirt_of("perkins240").table
    return SimulatedU(folder, text.encode(), "m.toml", pack(table), options)


def found_on(u: SimulatedU) -> Identified:
    """Excite and identify."""
    believed = u.believed()
    return identify(excited(u, plan(believed, Wishes()), believed))


@pytest.mark.parametrize(
    "other",
    [
        {"friction": 20, "quantum_nm": 1000},
        {"hz": 600.0, "damping": 0.8, "delay_us": 40.0, "friction": 2, "tick_hz": 40_000},
        {"more": "scale_latency_us = 6\nscale_error_nm = 20\nscale_period_um = 4"},
    ],
)
def test_constants_are_found(tmp_path: Path, other: dict[str, float | str]) -> None:
    """1 % of k1 and k2, 2 us of lead; the lead holds the latency of the scale."""
    drive: dict[str, float | str] = DRIVE | other
    text = MACHINE.format(**drive)
    found = found_on(simulated(tmp_path, text))
    w, damping = 2 * np.pi * float(drive["hz"]), float(drive["damping"])
    latency_us = 6.0 if drive["more"] else 0.0
    lead_us = float(drive["delay_us"]) + 0.5e6 / float(drive["tick_hz"]) + latency_us
    values, exact = found.plain.values, 1e-3 if drive["quantum_nm"] == 10 else 0.01
    assert values[[K1, K2]] == pytest.approx([2 * damping / w, 1 / w**2], rel=exact)
    assert values[LEAD] * 1e6 == pytest.approx(lead_us, abs=2.0)
    friction_m_s2 = values[FRICTION] / values[K2] * 1e-9
    assert friction_m_s2 == pytest.approx(float(drive["friction"]), rel=0.05, abs=0.2)
    assert found.problems() == []


def test_believed_is_what_the_controller_has(tmp_path: Path) -> None:
    """Not what is true; a bad machine has the name that the user gave it."""
    believed = simulated(tmp_path, MACHINE.format(**DRIVE)).believed()
    w = 2 * np.pi * 270
    assert believed.k1_ns == pytest.approx(1.6 / w * 1e9, abs=1)
    assert believed.k2_us2 == pytest.approx(1e12 / w**2, abs=1)
    assert believed.lead_ns == 85_000
    assert believed.tick_hz == 20_000
    line = refused(lambda: simulated(tmp_path, "[u]\nbandwidth_hz = 0\n").believed())
    assert line.startswith("m.toml: ")


def test_excitation_that_ends_early_gives_no_record(tmp_path: Path) -> None:
    """The emergency stop is pressed meanwhile."""
    u = simulated(tmp_path, MACHINE.format(**DRIVE), "--inject=estop@t0.5")
    believed = u.believed()
    with pytest.raises(CutShortError, match="cut short"):
        excited(u, plan(believed, Wishes()), believed)


WIDE = {"x_trim_limit_nm": 90_000, "x_trim_nm": 80_000}
# One by one the limit would be refused, because the trim before is beyond it.
NARROW = {"x_trim_limit_nm": 50_000, "x_trim_nm": 40_000}


def test_parameters_that_bound_each_other_are_set_together(bench: Bench, link: Link) -> None:
    """They are in force and read back; a set with a wrong one changes nothing, and names it."""
    u = ConnectedU(link)
    for pair in (WIDE, NARROW):
        ready(bench)
        u.apply(pair)
        assert u.values(pair) == pair
    ready(bench)
    before = u.values(["k1_ns"])
    with pytest.raises(Refused, match=r"nothing is set: .*x_trim_limit") as refused:
        u.apply({"k1_ns": 7} | NARROW | {"x_trim_nm": 50_001})
    assert "\n" not in str(refused.value)
    assert u.values(NARROW) == NARROW
    assert u.values(before) == before


def test_a_value_that_reads_another_is_refused(
    bench: Bench, link: Link, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Somebody else sets it at the same time."""
    ready(bench)
    u = ConnectedU(link)
    monkeypatch.setattr("camtools.identify.drives.set_all", lambda *_: {})
    with pytest.raises(Refused, match=r"servo_mass_g = 777: reads 1500; .*apply again"):
        u.apply({"servo_mass_g": 777})


def test_a_fault_ends_the_excitation_with_its_name(
    bench: Bench, link: Link, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The remedy stands in the same line, and command is given back."""
    ready(bench)
    u = ConnectedU(link)
    excitation = plan(u.believed(), Wishes())

    def fault(link: Link, _timeout_s: float) -> str:
        bench.estop(is_pressed=True)
        assert link.wait(lambda: link.status.state == "fault", limit_s(5.0))
        return "fault"

    monkeypatch.setattr("camtools.link.excitation._follow", fault)
    with pytest.raises(Refused, match=r"cut short: fault: estop; see status, then reset"):
        u.played(excitation.play, ("u_set_q6", "u_actual_nm"))
    assert link.rights.session == 0


def test_nothing_else_changes() -> None:
    """Every machine, twice over: the last numbers count; a table within a line is refused."""
    for name in names():
        text = machine_bytes(name).decode()
        once = with_keys(text, "controller", {"k1_ns": 1, "lead_ns": 2})
        twice = with_keys(once, "controller", {"k1_ns": 3, "k2_us2": 4})
        wanted = tomllib.loads(text)
        wanted.setdefault("controller", {}).update({"k1_ns": 3, "lead_ns": 2, "k2_us2": 4})
        assert tomllib.loads(twice) == wanted
        notes = [[line for line in one.splitlines() if "#" in line] for one in (text, twice)]
        assert notes[0] == notes[1]
    text = "[believed.u]\ndamping = 0.5 # old\nmode_hz = 1\n[cut]\nkc_n_per_mm2 = 2\n"
    changed = with_keys(text, "believed.u", {"damping": 0.7})
    assert tomllib.loads(changed)["believed"]["u"] == {"damping": 0.7, "mode_hz": 1}
    with pytest.raises(CamtoolsError, match="its keys cannot be replaced; write it as"):
        with_keys("controller = {k1_ns = 3}\n", "controller", {"k1_ns": 4})
