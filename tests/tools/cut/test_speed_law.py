"""The speed law of least ripple: numbers of MATHS.md (24) .. (29), limits, and properties."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import make_interp_spline

from camtools.cut.speed_law import (
    N_GRID,
    InfeasibleError,
    Load,
    SpeedLimits,
    excess,
    full,
    full_mean_rad_s,
    grid_rad,
    largest_partial,
    optimise,
    periodic_quintic,
    uniform,
)
from camtools.skirt.geometry.sections import Ellipse

RPM = np.pi / 30


def load_of(g_mm: float = 0.2, depth_mm: float = 0.1, a_mm: float = 46.0) -> Load:
    """Return the papers' section, or one like it."""
    u = Ellipse().evaluate(np.pi * np.arange(N_GRID) / N_GRID, a_mm, g_mm)
    blank = a_mm + depth_mm
    return Load((blank**2 - (a_mm - u.delta) ** 2) / 2, u.d1, u.d2, np.pi)


PAPERS = load_of()
LATHE = SpeedLimits(500.0, 3000 * RPM, 400.0, 250_000.0)
WIDE = SpeedLimits(1e9, 1e6, 1e9, 1e12)


def test_full_modulation_has_the_worked_numbers() -> None:
    """Ratios and peaks of MATHS.md (24) and (25); ripple of uniform turning."""
    law = full(PAPERS)
    assert (
        f"{float(law.ratio(0.0)):.8f} {float(law.ratio(np.pi / 2)):.8f}" == "1.49945711 0.75054348"
    )
    alpha, ratio, speed, motion = law.peaks
    assert alpha == pytest.approx(1.056453557, rel=2e-5)
    assert ratio == pytest.approx(1.499457112, abs=1e-8)
    assert speed == pytest.approx(0.106123891, rel=1e-5)
    assert motion == pytest.approx(0.451144917, rel=1e-8)
    assert law.ripple == pytest.approx(0, abs=1e-12)
    assert f"{uniform(PAPERS).ripple:.6f}" == "0.665460"


@pytest.mark.parametrize(
    ("alpha", "rpm"), [(100, 92.907), (500, 207.745), (1000, 293.796), (5000, 656.948)]
)
def test_highest_speed_of_full_modulation(alpha: float, rpm: float) -> None:
    """Mean speeds that the spindle's acceleration allows, to the grid's error of 1e-5."""
    found = full_mean_rad_s(PAPERS, SpeedLimits(alpha, 1e6, 1e9, 1e12)) / RPM
    assert found == pytest.approx(rpm, rel=1e-5)


def test_wide_limits_give_full_and_tiny_ones_uniform_speed() -> None:
    """The two ends of what a machine can do."""
    assert optimise(PAPERS, WIDE, 2500 * RPM).share == 1
    weak = SpeedLimits(1e-3, 3000 * RPM, 400.0, 250_000.0)
    law = optimise(PAPERS, weak, 1000 * RPM)
    np.testing.assert_allclose(law.ratio(grid_rad(PAPERS)), 1, atol=1e-5)


@pytest.mark.parametrize(
    ("rpm", "blended", "best"),
    [(250, 0.139, 0.064), (300, 0.259, 0.156), (400, 0.410, 0.310), (600, 0.544, 0.484)],
)
def test_optimised_law_beats_partial_modulation(rpm: float, blended: float, best: float) -> None:
    """What README tells of the papers' section on a lathe of 500 rad/s2."""
    assert largest_partial(PAPERS, LATHE, rpm * RPM).ripple == pytest.approx(blended, abs=0.003)
    assert optimise(PAPERS, LATHE, rpm * RPM).ripple == pytest.approx(best, abs=0.003)


@pytest.mark.parametrize("n", [64, 511, 512])
def test_spline_of_a_law_is_that_of_a_general_solver(n: int) -> None:
    """Value and three derivatives through random ratios, over several turns."""
    y = 1 + 0.3 * np.random.default_rng(n).random(n)
    found, x = periodic_quintic(y, 3.1), 3.1 * np.arange(n + 1) / n
    wanted = make_interp_spline(x, np.append(y, y[0]), k=5, bc_type="periodic")
    phi = np.linspace(-5, 9, 1000)
    for nu in range(4):
        error = np.abs(found(phi, nu=nu) - wanted(phi, nu=nu)).max()
        assert error < 1e-12 * np.abs(wanted(phi, nu=nu)).max()


@settings(max_examples=12, deadline=None)
@given(
    st.floats(0.05, 0.5),
    st.floats(0.05, 0.5),
    st.floats(50, 2000),
    st.floats(100, 5000),
    st.floats(20, 400),
)
def test_laws_keep_every_limit(
    g_mm: float, depth_mm: float, rpm: float, alpha: float, u_speed: float
) -> None:
    """Never beyond a limit, never worse than partial modulation, mean speed exact."""
    load, limits = load_of(g_mm, depth_mm), SpeedLimits(alpha, 2500 * RPM, u_speed, 100_000.0)
    try:
        blended = largest_partial(load, limits, rpm * RPM)
    except InfeasibleError as error:
        assert "machine.limits." in error.lines[0]
        return
    law = optimise(load, limits, rpm * RPM)
    assert law.ripple <= blended.ripple + 1e-9
    dense = np.linspace(0, np.pi, 8 * N_GRID, endpoint=False)
    for one in (law, blended):
        assert max(excess(one, limits, rpm * RPM).values()) <= 1
        assert float(np.mean(1 / one.ratio(dense))) == pytest.approx(1, abs=1e-8)
        slope = one.ratio(dense) * one.ratio(dense, 1) * (rpm * RPM) ** 2
        assert float(np.abs(slope).max()) <= limits.alpha_rad_s2


def test_law_is_as_symmetric_as_its_section() -> None:
    """A mirrored section has a mirrored law; the second half turn repeats the first."""
    law = optimise(PAPERS, LATHE, 300 * RPM)
    phi = np.linspace(0, np.pi / 2, 200)
    np.testing.assert_allclose(law.ratio(np.pi - phi), law.ratio(phi), atol=1e-9)
    np.testing.assert_allclose(law.ratio(np.pi + phi), law.ratio(phi), atol=1e-12)


def test_section_without_symmetry() -> None:
    """Three waves on the oval: the program runs over the whole turn."""
    phi = 2 * np.pi * np.arange(N_GRID) / N_GRID
    area = 5 + np.cos(2 * phi) + 0.3 * np.sin(3 * phi)
    load = Load(area, 0.1 * np.sin(2 * phi), 0.2 * np.cos(2 * phi), 2 * np.pi)
    law, blended = (solve(load, LATHE, 250 * RPM) for solve in (optimise, largest_partial))
    assert law.ripple <= blended.ripple < uniform(load).ripple
    assert max(excess(law, LATHE, 250 * RPM).values()) <= 1


def test_neighbouring_heights_have_neighbouring_laws() -> None:
    """A little more ovality changes the law a little: the table blends between heights."""
    phi = grid_rad(PAPERS)
    laws = [optimise(load_of(g_mm), LATHE, 300 * RPM).ratio(phi) for g_mm in (0.2, 0.202)]
    assert float(np.abs(laws[1] - laws[0]).max()) < 0.01


def test_uniform_speed_beyond_a_limit_is_refused_with_numbers() -> None:
    """Nothing can be modulated when the plain cut is too fast already."""
    slow_u = SpeedLimits(500.0, 3000 * RPM, 1.0, 250_000.0)
    with pytest.raises(InfeasibleError, match=r"u_speed_mm_s: needs 10.47 times .* 1000 r/min"):
        optimise(PAPERS, slow_u, 1000 * RPM)


def test_law_of_a_shallow_cut_is_one_that_a_table_holds() -> None:
    """At 60 r/min the spindle could accelerate by 12.7 mean speeds squared, the format holds 10."""
    law = optimise(load_of(0.3, 0.01), LATHE, 60 * RPM)
    assert 9 < law.peaks[0] < 10
