# SPDX-License-Identifier: Apache-2.0
"""Sections of a real cut, recomputed from its trace (Parquet) by another route, sheet included."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.optimize import least_squares, linprog

from camtools.base.quantities import Floats
from camtools.roundness.section import section_of
from camtools.sim.camsim import Simulator
from camtools.sim.results import PLACES, GaugedSections
from camtools.sim.sections import read_sections
from camtools.sim.trace_file import read_columns
from camtools.skirt.geometry.skirt_geometry import Geometry
from camtools.skirt.report.summary import make_summary
from camtools.skirt.table.generate import GeneratedSkirt
from camtools.table.summary import table_files
from tests.tools.cases.camsim_cases import CAMSIM, camsim, only_error

HEIGHTS_MM = (0.8, 2.4)
TURNS = 32
PHI = 2 * np.pi * np.arange(PLACES) / PLACES


class RealCut(NamedTuple):
    """A short cut of the Perkins skirt on the default machine."""

    folder: Path
    gauged: GaugedSections
    turn: Floats  # of every tick of cutting
    z_mm: Floats
    error_mm: Floats


@pytest.fixture(scope="module")
def real(generated: GeneratedSkirt, tmp_path_factory: pytest.TempPathFactory) -> RealCut:
    """Cut the first turns of the skirt, traced."""
    folder = tmp_path_factory.mktemp("sections")
    for name, data in table_files(generated.table, make_summary(generated)).items():
        (folder / name).write_bytes(data)
    words = ["--sections", "sections.csv", "--sections-mm", ",".join(map(str, HEIGHTS_MM))]
    words += ["--turns-limit", str(TURNS), "--no-learning"]
    simulator = Simulator(CAMSIM, folder, "perkins240.camtab")
    assert simulator.run_traced(words, "trace.parquet", is_quiet=True) == 0
    names = ("true_turn", "true_z_mm", "error_nm")
    found = read_columns(folder / "trace.parquet", ("state", *names))
    rows = found["state"].astype(str) == "cutting"
    turn, z_mm, error_nm = (found[name][rows].astype(np.float64) for name in names)
    return RealCut(folder, read_sections(folder / "sections.csv"), turn, z_mm, error_nm * 1e-6)


def of_trace(real: RealCut, z_mm: float) -> Floats:
    """Return the deviation all round at a height: one spline along all turns, then the height."""
    error = CubicSpline(real.turn, real.error_mm)
    height = CubicSpline(real.turn, real.z_mm)
    first, last = int(np.ceil(real.turn[0])), int(np.floor(real.turn[-1])) - 1
    turns = np.arange(first, last)[:, None] + PHI / (2 * np.pi)
    heights, errors = height(turns), error(turns)
    found = [np.interp(z_mm, heights[:, k], errors[:, k]) for k in range(PLACES)]
    return np.array(found)


def test_sections_are_those_of_the_trace(real: RealCut) -> None:
    """All 3600 places within 0.05 nm of a spline along the ticks, at both heights."""
    assert [one.is_whole for one in real.gauged.sections] == [True, True]
    for one in real.gauged.sections:
        off_mm = one.deviation_mm - of_trace(real, one.z_mm)
        assert np.abs(off_mm).max() < 5e-8
        assert np.ptp(one.deviation_mm) > 2e-5  # there is something to be found
        assert one.turn == pytest.approx(PHI / (2 * np.pi), abs=1e-8)


def test_radius_is_that_of_the_drawing_and_the_deviation(real: RealCut, geometry: Geometry) -> None:
    """The radius less the deviation is the ellipse of the generator at that height."""
    for one in real.gauged.sections:
        drawn_mm = geometry.radius_mm(one.z_mm) - geometry.delta(PHI, one.z_mm).delta
        assert one.radius_mm - one.deviation_mm == pytest.approx(drawn_mm, abs=5e-9)
    for line in real.gauged.lines:
        at = np.full(line.z_mm.size, np.radians(line.angle_deg))
        drawn_mm = geometry.radius_mm(line.z_mm) - geometry.delta(at, line.z_mm).delta
        assert line.radius_mm - line.deviation_mm == pytest.approx(drawn_mm, abs=5e-9)


def test_lines_are_those_of_the_trace(real: RealCut) -> None:
    """Along the height at four angles, within 0.05 nm; engaging turns are not in them."""
    assert [one.angle_deg for one in real.gauged.lines] == [0.0, 90.0, 180.0, 270.0]
    error, height = CubicSpline(real.turn, real.error_mm), CubicSpline(real.turn, real.z_mm)
    for line in real.gauged.lines:
        turns = np.arange(np.ceil(real.turn[0]), real.turn[-1] - 1)
        turns += line.angle_deg / 360
        turns = turns[turns > real.turn[1]]
        inside = (line.z_mm > height(turns[0])) & (line.z_mm < height(turns[-1]))
        assert inside.sum() > 0.9 * line.z_mm.size
        expected = np.interp(line.z_mm[inside], height(turns), error(turns))
        assert line.deviation_mm[inside] == pytest.approx(expected, abs=5e-8)
        assert real.z_mm[0] <= line.z_mm[0] and line.z_mm[-1] <= real.z_mm[-1]


def test_sheet_of_the_cut_by_another_route(real: RealCut) -> None:
    """Filter by convolution, circle by a minimiser, zone by HiGHS, waves by lstsq: 0.1 nm."""
    one = real.gauged.sections[1]
    drawn_mm = one.radius_mm - one.deviation_mm
    found = section_of(drawn_mm, one.deviation_mm, 50)
    off_mm = of_trace(real, one.z_mm)
    wave, alpha = 1 / 50, np.sqrt(np.log(2) / np.pi)
    x = np.arange(-PLACES, PLACES + 1) / PLACES
    weights = np.exp(-np.pi * (x / (alpha * wave)) ** 2) / (alpha * wave) / PLACES
    filtered = np.convolve(np.tile(off_mm, 3), weights, mode="same")[PLACES : 2 * PLACES]
    basis = np.stack([np.ones(PLACES), np.cos(PHI), np.sin(PHI)], axis=1)
    points = (drawn_mm.mean() + filtered)[:, None] * basis[:, 1:]
    circle = least_squares(
        lambda at: np.hypot(*(points - at[:2]).T) - at[2], [0, 0, 46], xtol=1e-15, ftol=1e-15
    )
    assert found.off.total_mm == pytest.approx(np.ptp(circle.fun), abs=1e-7)
    assert found.off.q_mm == pytest.approx(np.sqrt(np.mean(circle.fun**2)), abs=1e-7)
    rows = np.block([[basis, -np.ones((PLACES, 1))], [-basis, -np.ones((PLACES, 1))]])
    scaled = np.concatenate([filtered, -filtered]) * 1e4
    bounds = [(None, None)] * 3 + [(0, None)]
    zone = linprog([0, 0, 0, 1], rows, scaled, bounds=bounds)
    assert found.off_zone.width_mm == pytest.approx(2 * zone.fun * 1e-4, abs=1e-7)
    waves = [np.ones(PLACES)]
    for order in range(1, 51):
        waves += [np.cos(order * PHI), np.sin(order * PHI)]
    fitted = np.linalg.lstsq(np.column_stack(waves), off_mm, rcond=None)[0][1:].reshape(50, 2)
    amplitudes = [each.amplitude for each in found.off_waves]
    assert amplitudes == pytest.approx(np.hypot(*fitted.T), abs=1e-8)
    diameter = drawn_mm + filtered + np.roll(drawn_mm + filtered, PLACES // 2)
    axes = (found.cut_axes.long_mm, found.cut_axes.short_mm)
    assert axes == pytest.approx((diameter.max(), diameter.min()), abs=1e-7)


def test_file_has_the_same_bytes_again(real: RealCut) -> None:
    """The same cut writes the same file; without heights there are five."""
    table, other = real.folder / "perkins240.camtab", real.folder / "again.csv"
    words = ("--turns-limit", str(TURNS), "--no-learning", "--sections", other)
    heights = ",".join(map(str, HEIGHTS_MM))
    assert camsim("run", table, *words, "--sections-mm", heights).returncode == 0
    assert other.read_bytes() == (real.folder / "sections.csv").read_bytes()
    assert camsim("run", table, "--sections", other).returncode == 0
    found = read_sections(other)
    assert [one.z_mm for one in found.sections] == pytest.approx([6.2, 18.6, 31, 43.4, 55.8])
    assert all(one.is_whole for one in found.sections)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--sections-mm", "5"), "no file for them"),
        (("--sections", "s.csv", "--sections-mm", "5,4"), "no rising heights"),
        (("--sections", "s.csv", "--sections-mm", "5,x"), "no rising heights"),
        (("--sections", "s.csv", "--sections-mm", "5,"), "no rising heights"),
        (("--sections", "s.csv", "--sections-mm", "99"), "beyond the part"),
        (("--sections", "s.csv", "--sections-mm", ",".join(map(str, range(17)))), "1 .. 16"),
    ],
)
def test_wrong_heights_are_refused(real: RealCut, words: tuple[str, ...], told: str) -> None:
    """Heights without a file, not rising, no numbers, beyond the part, or too many."""
    assert told in only_error(camsim("run", real.folder / "perkins240.camtab", *words))
