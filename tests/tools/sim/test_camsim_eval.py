# SPDX-License-Identifier: Apache-2.0
"""The firmware's evaluation of generated tables against exact geometry."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from camtools.skirt.geometry.skirt_geometry import Geometry
from tests.tools.cases.camsim_cases import camsim, only_error

HEADER = "turn,z_mm"
COLUMNS = "turn,z_mm,u_nm,u1_nm_per_rad,u2_nm_per_rad2,x_nm,speed_ratio,clamped"
NM_PER_MM = 1e6


def evaluate(
    table: Path, turn: NDArray[np.float64], z_mm: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the rows that camsim eval gives for some points, shape (n, 8)."""
    rows = "".join(f"{t!r},{z!r}\n" for t, z in zip(turn.tolist(), z_mm.tolist(), strict=True))
    done = camsim("eval", table, stdin=f"{HEADER}\n{rows}")
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[0] == COLUMNS
    return np.array([[float(word) for word in line.split(",")] for line in lines[1:]])


def test_eval_is_within_1_nm_of_exact_geometry(table: Path, geometry: Geometry) -> None:
    """Judge the firmware's u and x on random points of the whole skirt, many turns out."""
    rng = np.random.default_rng(240)
    turn, z_mm = rng.uniform(-50, 50, 20_000), rng.uniform(0, 62, 20_000)
    got = evaluate(table, turn, z_mm)
    phi_rad = 2 * np.pi * (turn - np.floor(turn))
    exact = geometry.delta(phi_rad, z_mm)
    assert np.abs(got[:, 2] - exact.delta * NM_PER_MM).max() <= 1.0
    assert np.abs(got[:, 5] - geometry.radius_mm(z_mm) * NM_PER_MM).max() <= 1.0
    for column, derivative in ((3, exact.d1), (4, exact.d2)):
        off = np.abs(got[:, column] - derivative * NM_PER_MM).max()
        assert off <= 1e-3 * np.abs(derivative * NM_PER_MM).max()


def test_eval_gives_the_golden_values(table: Path) -> None:
    """Compare with MATHS.md (2), G = 0.2 at z = 20, and MATHS.md (6), to the nanometre."""
    degrees = np.array([0, 10, 15, 30, 45, 60, 75, 90], dtype=float)
    delta_nm = [0, 3024.932, 6719.165, 25061.263, 50081.610, 75061.152, 93321.641, 100000]
    got = evaluate(table, degrees / 360, np.full(8, 20.0))
    assert got[:, 2] == pytest.approx(delta_nm, abs=1.0)
    heights = np.array([5, 15, 25, 35, 45, 56], dtype=float)
    a_nm = [45983096.898, 45998129.455, 45998135.281, 45983079.419, 45953359.542, 45903454.932]
    assert evaluate(table, heights * 0, heights)[:, 5] == pytest.approx(a_nm, rel=0, abs=1.0)


def test_eval_wraps_and_flags_heights_outside(table: Path) -> None:
    """See the same value every turn, and clamped heights marked."""
    turn = np.array([0.1, 1.1, -0.9, 0.1, 0.1, 0.1, 0.1])
    z_mm = np.array([30, 30, 30, -0.001, 0, 62, 62.001])
    got = evaluate(table, turn, z_mm)
    assert got[0, 2] == pytest.approx(got[1, 2], abs=1e-2)
    assert got[0, 2] == pytest.approx(got[2, 2], abs=1e-2)
    assert got[:, 7].tolist() == [0, 0, 0, 1, 0, 0, 1]
    assert got[3, 2] == got[4, 2]
    assert got[6, 2] == got[5, 2]
    assert np.all(got[:, 6] == 1), "no speed channel: ratio 1"


@pytest.mark.parametrize(
    ("points", "place"),
    [
        ("", "empty"),
        ("z_mm,turn\n0,1\n", "line 1"),
        (f"{HEADER}\n0,20\n0.1\n", "line 3"),
        (f"{HEADER}\n0,20,7\n", "line 2"),
        (f"{HEADER}\nabc,20\n", "line 2"),
        (f"{HEADER}\n0,nan\n", "line 2"),
        (f"{HEADER}\ninf,20\n", "line 2"),
    ],
)
def test_eval_refuses_malformed_points(table: Path, points: str, place: str) -> None:
    """Name the line of a malformed point and leave with status 2."""
    assert place in only_error(camsim("eval", table, stdin=points))
